"""Drivers that follow first-order states: closed forms of motion and torque, derivatives, refusals."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.analyses.rolling import upright
from tests.states.gradients import differences, direct_and_adjoint
from tests.states.motors import INERTIA, TIGHT, WEIGHT, arm, value

import sarrus as sr
from sarrus.analyses.equilibria.independent_coordinates import of_joints
from sarrus.model import ModelError
from sarrus.model.written import with_numbers, written_numbers

T, X0 = 0.2, 0.1  # [s], [rad] of the lag of a ramp
LAG = sr.FirstOrderLag("lag", input="2*t", time=T, initial=X0, unit="rad")


def crank(*forces: Any, motion: Any = "0.5*lag + 0.1*sin(t)", name: str = "turn") -> sr.Model:
    """An arm whose angle follows a law."""
    return replace(arm(*forces or (LAG,)), drivers=[sr.AngleDriver(name, "pin", motion)])


def angle(t: Any, derivative: int = 0) -> np.ndarray[Any, Any]:
    """The angle, or its second derivative: x = 2 (t - T) + (x0 + 2 T) exp(-t/T)."""
    decay = (X0 + 2 * T) * np.exp(-t / T)
    if derivative:
        return np.asarray(0.5 * decay / T**2 - 0.1 * np.sin(t))
    return np.asarray(0.5 * (2 * (t - T) + decay) + 0.1 * np.sin(t))


METHODS = {
    "Radau": (sr.Radau(), 1e-10, 1e-9),
    "HHT": (sr.HHT(), 1e-8, 1e-6),
    "generalized-α": (sr.GeneralizedAlpha(), 1e-8, 1e-6),
    "HHT, stabilized": (sr.HHT(stabilized=True), 1e-8, 1e-6),
    "ODE": (sr.ODE(), 1e-10, 1e-8),
}  # fmt: skip


@pytest.mark.one_in(8)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_a_joint_follows_the_lag_of_a_ramp_and_its_driver_has_the_torque_of_the_motion(method: str) -> None:
    chosen, rtol, error = METHODS[method]
    run = sr.simulate(sr.System(crank()), until=1.0, method=replace(chosen, rtol=rtol))
    assert run.success
    theta = angle(run.t)
    assert value(run, "pin.angle") == pytest.approx(theta, abs=error)
    torque = INERTIA * angle(run.t, 2) + WEIGHT * np.cos(theta)
    assert value(run, "turn.torque.z") == pytest.approx(torque, abs=300 * error)
    assert value(run, "turn.power") == pytest.approx(torque * value(run, "pin.angle.rate"), abs=600 * error)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_derivatives_of_a_driven_motion() -> None:
    """Direct, adjoint, differences of runs, and the closed form by the initial value; second ones by differences."""
    names, model = ["lag.time", "lag.gain", "lag.initial", "arm.mass"], crank()
    direct, adjoint = direct_and_adjoint(model, "turn.torque.z", names, 0.3, 1e-11)
    assert direct == pytest.approx(adjoint, rel=1e-9)
    assert adjoint == pytest.approx(differences(model, "turn.torque.z", names, 0.3, 1e-5), rel=1e-6)
    run = sr.simulate(sr.System(model), until=0.3, store="steps", method=sr.Radau(rtol=1e-11))
    by_initial = sr.sensitivity(run, sr.Final("pin.angle"), wrt=["lag.initial"])["lag.initial"]
    assert by_initial == pytest.approx(0.5 * np.exp(-0.3 / T), rel=1e-9)
    H, numbers, some = sr.hessian(run, "pin.angle", names[:2]), written_numbers(model), names[:2]
    for name in some:
        h = 1e-4 * numbers[name]
        models = [with_numbers(model, {name: numbers[name] + s * h}) for s in (-1, 1)]
        low, high = (direct_and_adjoint(one, "pin.angle", some, 0.3, 1e-11)[1] for one in models)
        assert [H[name, other] for other in some] == pytest.approx((high - low) / (2 * h), rel=1e-5, abs=1e-7)


@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.slow
def test_derivatives_of_a_run_from_a_state_keep_the_followed_states_there() -> None:
    """The lag does not depend on the motion of the driver: against runs with other numbers from the same state."""
    model, names = crank(), ["turn.motion.1", "lag.gain"]
    state = sr.simulate(sr.System(model), until=0.3, **TIGHT).final
    run = sr.simulate(sr.System(model), state, until=0.4, store="steps", method=sr.Radau(rtol=1e-11))
    numbers, h = written_numbers(model), 1e-5
    for output in ("lag", "pin.angle"):
        found = sr.sensitivity(run, sr.Final(output), wrt=names)
        for name in names:
            models = [with_numbers(model, {name: numbers[name] + s * h}) for s in (-1, 1)]
            low, high = (
                value(sr.simulate(sr.System(one), state, until=0.4, **TIGHT), output)[-1] for one in models
            )
            assert found[name] == pytest.approx((high - low) / (2 * h), rel=1e-6, abs=1e-8)


FILTER = sr.TransferFunction(
    "filter", numerator=[1.0], denominator=[0.01, 0.2, 1.0], input="step(t, 0, 0, 0.1, 1)"
)
STATE = sr.StateVariable("lag", rate=lambda x, t: (2 * t - x) / T, initial=X0)


@pytest.mark.slow
def test_a_chain_of_states_is_followed_by_its_output() -> None:
    """Two poles at -10/s: against the same filter that no driver follows."""
    run = sr.simulate(sr.System(crank(FILTER, motion="filter.output")), until=1.0, **TIGHT)
    free = sr.simulate(sr.System(arm(FILTER)), until=1.0, t_eval=run.t, **TIGHT)
    assert value(run, "pin.angle") == pytest.approx(value(free, "filter.output"), abs=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("motion", ["0.5*lag + 0.1*sin(t)", lambda o: 0.5 * o["lag"] + 0.1 * np.sin(o.t)])
@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_states_and_motions_are_formulas_or_functions(motion: Any) -> None:
    run = sr.simulate(sr.System(crank(STATE, motion=motion)), until=1.0, **TIGHT)
    assert value(run, "pin.angle")[-1] == pytest.approx(angle(1.0), abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["lag*u", lambda o: o["lag"] * o["u"]])
@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_a_motion_of_states_may_use_an_input_with_a_law_over_time(motion: Any) -> None:
    system = sr.System(crank(LAG, sr.Input("u", 1.5), motion=motion))
    run = sr.simulate(system, until=0.3, store="steps", **TIGHT)
    assert value(run, "pin.angle") == pytest.approx(1.5 * value(run, "lag"), abs=1e-9)
    by = sr.sensitivity(run, sr.Final("pin.angle"), wrt=["u.value"])["u.value"]
    assert by == pytest.approx(value(run, "lag")[-1], rel=1e-9)
    run = sr.simulate(system, until=0.3, inputs={"u": lambda t: 1 + t}, **TIGHT)
    assert value(run, "pin.angle") == pytest.approx((1 + run.t) * value(run, "lag"), abs=1e-9)
    with pytest.raises(sr.SarrusError, match="drivers follow the input u"):
        sr.Stepper(system, step=0.1, inputs=["u"])


@pytest.mark.slow
def test_a_rate_may_depend_on_positions() -> None:
    """ẋ = (θ - x)/T of a free pendulum, which another driver follows without effect on it."""
    other = sr.Body("other", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(2.5, 0, 0))
    swing = sr.Revolute("swing", sr.ground, other, point=(2, 0, 0), axis=(0, 0, 1))
    seen = sr.FirstOrderLag("seen", input="swing.angle", time=0.3, unit="rad")
    model = arm(seen)
    whole = replace(
        model,
        bodies=[*model.bodies, other],
        joints=[*model.joints, swing],
        drivers=[sr.AngleDriver("turn", "pin", "seen")],
    )
    runs = [sr.simulate(sr.System(one), until=1.0, **TIGHT) for one in (whole, replace(whole, drivers=[]))]
    driven, free = ([value(run, name)[-1] for name in ("swing.angle", "seen")] for run in runs)
    assert driven == pytest.approx(free, abs=1e-9)
    assert value(runs[0], "pin.angle")[-1] == pytest.approx(free[1], abs=1e-9)


def slider(driver: Callable[[sr.Body], sr.Driver]) -> sr.Model:
    block = sr.Body("block", mass=3.0, inertia=(0.1, 0.1, 0.1), position=(1.0 + X0, 0, 0))
    slide = sr.Translational("slide", sr.ground, block, point=(1.0 + X0, 0, 0), axis=(1, 0, 0))
    return sr.Model("slider", [block], [slide], [LAG], drivers=[driver(block)])


DRIVERS: dict[str, Callable[[sr.Body], sr.Driver]] = {
    "displacement": lambda b: sr.DisplacementDriver("push", "slide", "lag - 0.1"),
    "point": lambda b: sr.PointDriver("push", b.point(0, 0, 0), x="1 + lag"),
    "distance": lambda b: sr.DistanceDriver("push", sr.ground.point(0, 0, 0), b.point(0, 0, 0), "1 + lag"),
    "coordinate": lambda b: sr.CoordinateDriver("push", b, "x", "1 + lag"),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", DRIVERS)
def test_every_driver_follows_states(kind: str) -> None:
    """The force is 3 kg times the acceleration of the lag."""
    run = sr.simulate(sr.System(slider(DRIVERS[kind])), until=1.0, **TIGHT)
    x = 2 * (run.t - T) + (X0 + 2 * T) * np.exp(-run.t / T)
    assert value(run, "block.x") == pytest.approx(1 + x, abs=1e-9)
    assert value(run, "push.force.x") == pytest.approx(3 * (X0 + 2 * T) / T**2 * np.exp(-run.t / T), abs=1e-6)


FILE = """
name: two arms
include: [{file: arm.yaml, prefix: a_}]
bodies:
  arm: {mass: 2, inertia: [0.1, 0.15, 0.2], position: [0.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, arm], point: [0, 0, 0], axis: [0, 0, 1]}
drivers:
  turn: {type: angle, joint: pin, motion: MOTION}
forces:
  u: {type: input, value: 1}
  lag: {type: first_order_lag, input: 2*t, time: 0.2, initial: 0.1, unit: rad}
parameters: {gain: 0.5, other: 2*gain, speed: 2 rad/s, arm_length: 2 m}
"""


def _loaded(folder: Path, motion: str) -> sr.System:
    """Two arms of a file, and of one that it includes."""
    (folder / "arm.yaml").write_text(
        FILE.replace("MOTION", "gain*lag").replace("include: [{file: arm.yaml, prefix: a_}]", "")
    )
    (folder / "two.yaml").write_text(FILE.replace("MOTION", motion))
    return sr.System(sr.load(folder / "two.yaml"))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_names_of_a_motion_in_a_file_are_states_or_numbers_of_the_file(tmp_path: Path) -> None:
    """gain*lag with another value of the parameter; the included arm follows the lag that has its prefix."""
    run = sr.simulate(
        _loaded(tmp_path, "other*lag + 0.1 rad/s^2 * lag.time*t"), until=0.2, store="steps", **TIGHT
    )
    assert value(run, "pin.angle") == pytest.approx(value(run, "lag") + 0.02 * run.t, abs=1e-9)
    assert value(run, "a_pin.angle") == pytest.approx(0.5 * value(run, "a_lag"), abs=1e-9)
    by = sr.sensitivity(run, sr.Final("a_pin.angle"), wrt=["a_gain"])["a_gain"]
    assert by == pytest.approx(value(run, "a_lag")[-1], rel=1e-9)


FILE_ERRORS = {
    "gain*lug": 'motion uses the unknown name "lug"',
    "lag + pin.angle": 'motion uses "pin.angle", which is no state',
    "3 mm * t": "motion expects rad",
    "lug": 'motion uses the unknown name "lug". Did you mean "lag"',
    "command": 'motion uses the unknown name "command". Choose from t, u, lag, .*gain',
    "2*lug": 'motion uses the unknown name "lug". Did you mean "lag"',
    "lag + speed": ".*speed. combines rad and rad s.-1",
    "u + speed": "motion expects rad, but .* is in rad s",
    "2*speed + lag": "motion expects rad, but .* is in rad s",
    "gain*u": "motion uses the input u in a formula",
}


@pytest.mark.parametrize(
    "motion",
    ["speed*t + 0.5*lag", "0.5*lag + 0.1*sin(t)", "u*lag/2", "0.1 + 0.1*sin(2*pi*t)", "lag*arm_length/2 m"],
)
@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_units_of_parameters_fit_motions_of_states_in_a_file(motion: str, tmp_path: Path) -> None:
    assert _loaded(tmp_path, motion).model.drivers


@pytest.mark.parametrize("motion", FILE_ERRORS)
def test_other_names_of_a_motion_in_a_file_are_refused(motion: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=rf'yaml:9: driver "turn": {FILE_ERRORS[motion]}'):
        _loaded(tmp_path, motion)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_a_system_with_followed_states_has_exact_operators() -> None:
    system = sr.System(crank())
    assert system.check_derivatives().ok
    assert system.counts()["degrees_of_freedom"] == 0


@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_states_that_are_followed_are_no_degrees_of_freedom() -> None:
    """A driven arm alone, and with a further arm that swings freely."""
    driven = crank()
    other = sr.Body("other", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(2.5, 0, 0))
    swing = sr.Revolute("swing", sr.ground, other, point=(2, 0, 0), axis=(0, 0, 1))
    both = replace(driven, bodies=[*driven.bodies, other], joints=[*driven.joints, swing])
    for model, count in ((driven, 0), (both, 1)):
        found = sr.mobility(sr.System(model))
        assert found.degrees_of_freedom == found.finite == count
        assert found.motions.shape == (found.coordinates, count)
        assert found.configuration_dimension is None


def test_blocks_of_followed_states_are_no_bodies_without_a_joint_to_the_ground() -> None:
    """Two bodies in space whose joint follows the last of many states are one free group, named by its first body."""
    one, two = (
        sr.Body(name, mass=1.0, inertia=(1, 1, 1), position=(x, 0, 0)) for name, x in (("a", 0), ("b", 1))
    )
    pin = sr.Revolute("pin", one, two, point=(1, 0, 0), axis=(0, 0, 1))
    states = [sr.StateVariable(f"s{k}", rate=f"0*a.x - s{k}", initial=0.0) for k in range(9)]
    drivers = [sr.AngleDriver("turn", "pin", "0.2*s8")]
    system = sr.System(sr.Model("free", [one, two], [pin], forces=states, drivers=drivers))
    names = "pin.angle", "a.x", "a.y", "a.z", "a.e1", "a.e2", "a.e3"
    assert of_joints(system, system.q0) == names


def test_a_rolling_wheel_beside_a_driven_arm_has_more_positions_than_velocities() -> None:
    parts = upright().model
    model = crank(motion="lag - 0.1")
    whole = replace(model, bodies=[*model.bodies, *parts.bodies], joints=[*model.joints, *parts.joints])
    found, alone = (sr.mobility(sr.System(one)) for one in (whole, parts))
    names = "degrees_of_freedom", "configuration_dimension"
    assert [getattr(found, name) for name in names] == [getattr(alone, name) for name in names] == [2, 4]


def test_a_saved_run_has_followed_states_without_its_system(tmp_path: Path) -> None:
    run = sr.simulate(sr.System(slider(DRIVERS["displacement"])), until=0.1)
    run.save(tmp_path / "run.sarrus")
    loaded = replace(sr.load_run(tmp_path / "run.sarrus"), system=None, joints=None)
    assert loaded["lag"] == pytest.approx(run["lag"], rel=1e-14)
    assert loaded.output("lag", rate=True).values == pytest.approx(run.output("lag", rate=True).values)


@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_a_model_file_has_motions_by_states(tmp_path: Path) -> None:
    crank().save(tmp_path / "crank.yaml")
    system = sr.System(sr.load(tmp_path / "crank.yaml"))
    run = sr.simulate(system, until=1.0, **TIGHT)
    assert value(run, "pin.angle")[-1] == pytest.approx(angle(1.0), abs=1e-9)


JUMPING = sr.FirstOrderLag("lag", input="step(t - 1)", time=T)
MOVING = sr.FirstOrderLag("lag", input="pin.rate", time=T)
REFUSED: dict[str, tuple[tuple[Any, ...], Any, str]] = {
    "a jump": ((JUMPING,), "lag", r'force "lag": input jumps, but the driver turn follows lag, .* Use step\(t, t0'),
    "a rate": ((MOVING,), "lag", 'force "lag": input uses "pin.rate", .* Replace the driver by a force'),
    "a jump of the motion": ((LAG,), "lag*step(t - 1)", 'driver "turn": motion jumps'),
    "an output": ((LAG,), "lag + pin.rate", 'driver "turn": motion uses "pin.rate", which is no state'),
    "an unknown name": ((LAG,), "2*lug", 'driver "turn": motion .*unknown name.* outputs other than states'),
    "another unit": ((LAG,), "lag + 3 mm", 'driver "turn": motion .*3 mm'),
    "two arguments": ((LAG,), lambda t, o: o["lag"], 'motion must be .*lambda t: .*, or of .*lambda o: .* t, o'),
    "degrees": ((replace(LAG, unit="deg"),), "lag", "motion uses lag in deg, but .* Give lag in rad, or omit its unit"),
    "degrees in a function": ((replace(LAG, unit="deg"),), lambda o: o["lag"], "motion uses lag in deg"),
    "revolutions": ((replace(LAG, unit="rev"),), "0.5*lag + t", "motion uses lag in rev"),
    "an output in mm": ((replace(FILTER, unit="mm"),), "filter.output", "motion uses filter.output in mm"),
    "an input in %": ((LAG, sr.Input("u", 1.5, unit="%")), "u*lag", "motion uses u in %"),
    "an argument": ((LAG,), lambda lag: 2 * lag, 'driver "turn": motion is a function of lag, a state'),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_drivers_cannot_follow_is_refused(case: str) -> None:
    forces, motion, message = REFUSED[case]
    with pytest.raises(ModelError, match=message):
        sr.System(crank(*forces, motion=motion))


ANALYSES: dict[str, Callable[[sr.System], Any]] = {
    "equilibrium": sr.equilibrium,
    "kinematics": lambda system: sr.kinematics(system, [0.0, 1.0]),
    "linearize": lambda system: sr.linearize(system, system.q0),
    "modes": lambda system: sr.modes(system, system.q0),
}


@pytest.mark.parametrize("analysis", ANALYSES)
def test_analyses_of_positions_are_refused(analysis: str) -> None:
    with pytest.raises(sr.SarrusError, match=f"arm: {analysis} is .* states.* Simulate"):
        ANALYSES[analysis](sr.System(crank()))


def test_inputs_of_followed_states_cannot_be_stepped() -> None:
    lag = sr.FirstOrderLag("lag", input="u", time=T)
    system = sr.System(crank(sr.Input("u", 0.5), lag, motion="lag"))
    with pytest.raises(sr.SarrusError, match="drivers follow the input u"):
        sr.Stepper(system, step=0.1, inputs=["u"])
    with pytest.raises(sr.SarrusError, match="drivers follow the input u"):
        sr.simulate(system, until=1.0, controllers=[sr.Controller(lambda t, o: {"u": 1.0}, period=0.1)])


@pytest.mark.parametrize("unit", ["", "1", "-", "rad", "m/m", "N m/(N·m)"])
@pytest.mark.filterwarnings("ignore:.*assembly changed")
def test_motions_use_outputs_in_units_of_the_si(unit: str) -> None:
    assert sr.System(crank(replace(LAG, unit=unit), motion="0.5*lag")).model.forces[0].unit == unit
