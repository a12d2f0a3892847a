"""Every part with first-order states in every analysis: events, dense output, saving, rest, derivatives, plots."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.states import test_controllers, test_hydraulic_cylinder, test_lugre, test_pneumatic_chamber
from tests.states.motors import TIGHT, arm, value
from tests.states.test_maxwell import buffered
from tests.states.test_state_space_block import controlled

import sarrus as sr
from sarrus.model.model import Model
from sarrus.model.tyres.rolling_tyre import RollingTyre
from sarrus.model.written import with_numbers, written_numbers

UNTIL = 0.1
SPRING = sr.Torque("spring", "pin", value="-30*x - v")


def lagging() -> Model:
    """A lag whose output is a torque."""
    return arm(
        sr.FirstOrderLag("lag", input="-pin.angle", time=0.3), sr.Torque("t", "pin", value="9*lag"), SPRING
    )


def filtered() -> Model:
    """A filter of second order whose output is a torque."""
    part = sr.TransferFunction("filter", numerator=[2, 3], denominator=[1, 4, 5], input="-pin.angle")
    return arm(part, sr.Torque("t", "pin", value="filter.output"), SPRING)


def winding() -> Model:
    """A motor at a constant voltage."""
    return arm(sr.DCMotor("motor", "pin", "5 - 20*pin.angle", **test_controllers.MOTOR), SPRING)


def contracting() -> Model:
    """A muscle with a smooth excitation."""
    effort = sr.MuscleActivation("effort", input="0.5 - pin.angle", smoothing=0.5, initial=0.3)
    given = {"peak_force": 20.0, "optimal_length": 0.4, "tendon_length": -0.4}
    return arm(effort, sr.Muscle("m", joints={"pin": 0.3}, activation="effort", **given), SPRING)


def driving() -> Model:
    """An engine, whose shaft turns the arm by a slipping clutch."""
    crank = sr.Shaft("crank", inertia=0.2, torque="engine.value - box.value", initial=3.0)
    engine = sr.Engine("engine", "crank", "0.5 - 0.2*pin.angle", [[-400, 9], [0, 8], [400, 5]], "-0.1*x")
    return arm(crank, engine, sr.Transmission("box", "crank", "pin", 2.0, 8.0, 0.7, creep=20.0), SPRING)


def following() -> Model:
    """A point of the arm along a bend, whose deviation is a torque."""
    path = sr.PathFollower("path", "arm", [[0.3, -0.9], [0.5, -0.4], [0.55, 0.1], [0.4, 0.6]], initial=0.9)
    return arm(path, sr.Torque("t", "pin", value="9*path.deviation + path.curvature"), SPRING)


def drawn(model: Model) -> Model:
    """With a spring along its slide."""
    return replace(model, forces=[*model.forces, sr.Force("draw", "slide", value="1 - 90*x - 3*v")])


@dataclass(frozen=True)
class Block:
    """A model of one degree of freedom with a part, a state and two parameters of it, and the model that can rest."""

    make: Callable[[], Model]
    state: str
    names: tuple[str, str]
    resting: Callable[[], Model] | None = None

    @cached_property
    def system(self) -> sr.System:
        return sr.System(self.make())

    @cached_property
    def run(self) -> sr.Trajectory:
        return sr.simulate(self.system, until=UNTIL, store="dense", **TIGHT)

    @cached_property
    def rest(self) -> sr.Equilibrium:
        return sr.equilibrium(sr.System((self.resting or self.make)()))


BLOCKS = {
    "state variable": Block(
        lambda: arm(sr.StateVariable("x1", rate="-k*x1 - pin.angle", initial=0.1, parameters={"k": 2.0}), SPRING),
        "x1", ("x1.initial", "x1.parameters.k"),
    ),
    "lag": Block(lagging, "lag", ("lag.time", "lag.gain")),
    "transfer function": Block(filtered, "filter.x2", ("filter.numerator.1", "filter.denominator.2")),
    "state space": Block(controlled, "ss.x1", ("ss.A.1.1", "ss.C.1.2")),
    "PID": Block(lambda: test_controllers.servo(lower=-50.0, upper=50.0), "pid.integral", ("pid.kp", "pid.filter")),
    "motor": Block(winding, "motor.current", ("motor.inductance", "motor.gear")),
    "muscle": Block(contracting, "effort", ("effort.deactivation_time", "m.peak_force")),
    "cylinder": Block(
        test_hydraulic_cylinder.driven, "jack.pressure_a", ("jack.area", "jack.bulk"),
        lambda: test_hydraulic_cylinder.driven(0.0, spring=2e4),
    ),
    "chamber": Block(
        test_pneumatic_chamber.filled, "gas.pressure", ("gas.area", "gas.exponent"),
        lambda: test_pneumatic_chamber.filled("1e-9*(3e5 - gas.pressure)"),
    ),
    "shaft": Block(driving, "crank.rate", ("crank.inertia", "box.capacity")),
    "path follower": Block(following, "path.progress", ("path.return_rate", "path.path.2.1")),
    "Maxwell": Block(buffered, "buffer.tension", ("buffer.k", "buffer.c"), lambda: drawn(buffered())),
    "LuGre": Block(
        test_lugre.pulled, "rub.deflection", ("rub.stiffness", "rub.mu"), lambda: drawn(test_lugre.pulled(0.0))
    ),
}  # fmt: skip


def test_every_part_with_states_is_here() -> None:
    """Except tyres, whose states no position determines at rest: see `tests.tyres.test_rolling_tyres`."""
    every = {kind for kind in sr.model.Force.kinds.values() if kind.states is not sr.model.Force.states}
    every -= {kind for kind in every if issubclass(kind, RollingTyre)}
    own = {kind for kind in every if kind.__module__.startswith("sarrus.")}
    assert own == {type(part) for one in BLOCKS.values() for part in one.make().forces if [*part.states()]}


@pytest.mark.slow
@pytest.mark.parametrize("kind", BLOCKS)
def test_blocks_of_the_newton_matrix_are_exact(kind: str) -> None:
    report = BLOCKS[kind].system.check_derivatives(BLOCKS[kind].system.q0)
    assert report, str(report)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", BLOCKS)
def test_dense_output_and_saved_runs_have_the_state(kind: str, tmp_path: Path) -> None:
    block = BLOCKS[kind]
    run, middle = block.run, 0.61 * UNTIL
    nominal = block.system.states[block.state].nominal
    half = sr.simulate(block.system, until=middle, **TIGHT)
    place = block.system.states[block.state].place
    size = max(abs(value(run, block.state)).max(), 1e-3 * nominal)
    assert run.state(middle).v[place] == pytest.approx(value(half, block.state)[-1], abs=1e-8 * size)
    run.save(tmp_path / "run.sarrus")
    assert np.array_equal(sr.load_run(tmp_path / "run.sarrus")[block.state], run[block.state])


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", BLOCKS)
def test_an_event_on_the_state_is_where_dense_output_has_its_level(kind: str) -> None:
    block = BLOCKS[kind]
    place = block.system.states[block.state].place
    level = float(block.run.state(0.61 * UNTIL).v[place])
    size = abs(value(block.run, block.state)).max()
    event = sr.Event(lambda t, q, v: (v[place] - level) / size, name="level")
    found = sr.simulate(block.system, until=UNTIL, events=event, **TIGHT).events
    assert min(abs(one.t - 0.61 * UNTIL) for one in found) < 1e-6 * UNTIL


@pytest.mark.one_in(16)
@pytest.mark.parametrize("kind", BLOCKS)
def test_rates_are_zero_at_rest_and_poles_are_those_of_differences(kind: str) -> None:
    """Differences of forward dynamics along the joint: x' = f(position, rate, states)."""
    rest = BLOCKS[kind].rest
    assert rest.success, rest.message
    system = rest.system
    f, places = system.forward_dynamics, [one.place for one in system.states.values()]
    sizes = np.maximum(abs(rest.v[places]), 1e-3 * np.array([one.nominal for one in system.states.values()]))
    assert np.all(abs(f(rest.q, rest.v).a[places]) <= 1e-8 * sizes * 1e3)
    plant = sr.linearize(system, rest)
    (joint, rate), count = plant.states[:2], len(places)

    def rates(x: np.ndarray) -> np.ndarray:
        v = plant.v_x[:, 1] * x[1]
        v[places] = x[2:]
        a = f(_onto(system, rest.q + plant.q_x[:, 0] * x[0]), v).a
        return np.array([x[1], *np.linalg.lstsq(plant.v_x[:7, 1:2], a[:7], rcond=None)[0], *a[places]])

    assert (joint + ".rate", 2 + count) == (rate, plant.A.shape[0])
    h = 1e-5 * np.array([1.0, 1.0, *np.maximum(sizes, 1e-3 * sizes.max())])
    start = np.array([0.0, 0.0, *rest.v[places]])
    A = np.array(
        [(rates(start + d) - rates(start - d)) / (2 * step) for d, step in zip(np.diag(h), h, strict=True)]
    ).T
    exact = np.sort_complex(np.linalg.eigvals(A))
    assert np.sort_complex(plant.poles) == pytest.approx(exact, rel=1e-5, abs=1e-5 * abs(exact).max() * 1e-3)
    modes = sr.modes(system, rest)
    for pole in modes.eigenvalues:
        assert abs(plant.poles - pole).min() < 1e-7 * abs(plant.poles).max()


def _onto(system: sr.System, q: np.ndarray) -> np.ndarray:
    """The nearest position without gaps, with normalized Euler parameters."""
    for _ in range(4):
        q = q - np.linalg.lstsq(system.Phi_q(q).toarray(), system.Phi(q), rcond=None)[0]
    return q


@pytest.mark.slow
@pytest.mark.parametrize("kind", BLOCKS)
def test_direct_is_adjoint_and_second_derivatives_are_differences_of_gradients(kind: str) -> None:
    """Relative to the largest entry, by numbers in relative changes."""
    block = BLOCKS[kind]
    model, names, response = block.make(), [*block.names, "pin.point.x"], sr.Final(block.state)
    names = names[: 2 + ("pin" in {joint.name for joint in model.joints})]
    own = written_numbers(model)

    def gradient(changes: dict[str, float], method: Any = "adjoint") -> np.ndarray:
        numbers = {name: own[name] + step for name, step in changes.items()}
        run = sr.simulate(
            sr.System(with_numbers(model, numbers)), until=UNTIL, store="steps", method=sr.Radau(rtol=1e-11)
        )
        return sr.sensitivity(run, response, wrt=names, method=method).matrix[0]

    run = sr.simulate(sr.System(model), until=UNTIL, store="steps", method=sr.Radau(rtol=1e-11))
    sizes = np.array([abs(own[name]) or 1.0 for name in names])
    direct, adjoint = (
        sr.sensitivity(run, response, wrt=names, method=how).matrix[0] for how in ("direct", "adjoint")
    )
    assert direct * sizes == pytest.approx(adjoint * sizes, rel=1e-7, abs=1e-9 * abs(direct * sizes).max())
    H = np.array(sr.hessian(run, response, wrt=names).matrix) * np.outer(sizes, sizes)
    first = 1e-3 * sizes[1]
    f = [gradient({names[1]: n * first}) for n in (-2, -1, 1, 2)]
    wanted = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * first) * sizes * sizes[1]
    assert H[:, 1] == pytest.approx(wanted, abs=1e-5 * max(abs(H).max(), abs(adjoint * sizes).max()))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", BLOCKS)
def test_the_state_is_plotted_with_its_unit(kind: str) -> None:
    block = BLOCKS[kind]
    (axes,) = np.ravel(block.run.plot(block.state, ax=Figure()))
    assert axes.lines[0].get_ydata() == pytest.approx(value(block.run, block.state))
    assert block.run.output(block.state).unit in axes.get_ylabel()
