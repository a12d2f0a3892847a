"""A user's part that adds a block of five amplitudes to a body: in all analyses as what moves."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root
from tests.registries import kinds_of_forces_here

import sarrus as sr
from sarrus import elements
from sarrus.analyses.equations.minimum_norm import left_out
from sarrus.elements.element import RIGID, Kind, Scalar, Vec3, modal
from sarrus.model.coordinates import CoordinateBlock
from sarrus.model.primitive import Primitive
from sarrus.model.words import describe
from sarrus.views.motion import same_signs

FIVE = modal(5)


class Modes(elements.InertiaElement, bodies=2, derivatives="automatic", registered=False):
    """T = m/2 ẇ·ẇ + c/2 (w₁ ẇ₂)² + c ẇ₁ ż of amplitudes w on a body."""

    m: Scalar
    c: Scalar

    @classmethod
    def owners(cls) -> tuple[tuple[Kind, ...], ...]:
        return RIGID, (FIVE,)

    def M(self, x: Any) -> Any:
        w, across = x[2], np.zeros((3, 5), dtype=object)
        across[2, 0] = self.c
        own = np.diag([self.m, self.m + self.c * w[0] * w[0], self.m, self.m, self.m])
        return (None, None, across), (None, None, None), (across.T, None, own)

    def S(self, x: Any, v: Any) -> Any:
        w, rates = x[2], v[2]
        by_1 = self.c * w[0] * rates[1] * rates[1]
        return None, None, np.array([by_1, -2 * self.c * w[0] * rates[0] * rates[1], 0, 0, 0])


class Stiffness(elements.Force, bodies=2, derivatives="automatic", registered=False):
    """V = k/2 (w·w + 2 w₅ w₁ x + 4 w₂² e₂ + w₃ e₂ + (w·w)²/2)."""

    k: Scalar

    @classmethod
    def owners(cls) -> tuple[tuple[Kind, ...], ...]:
        return RIGID, (FIVE,)

    def potential(self, x: Any) -> Any:
        r, p, w = x
        square = w @ w
        bent = 2 * w[0] * w[4] * r[0] + 4 * w[1] * w[1] * p[2] + w[2] * p[2]
        return 0.5 * self.k * (square + bent + 0.5 * square * square)


class Decay(elements.Force, bodies=1, derivatives="automatic", registered=False):
    """Q = -d ẇ on the block alone."""

    d: Scalar
    s: Vec3  # a name of points of bodies, of which it has none

    @classmethod
    def owners(cls) -> tuple[tuple[Kind, ...], ...]:
        return ((FIVE,),)

    def Q(self, x: Any, v: Any, t: Any) -> Any:
        return (-self.d * self.s[0] * v[0],)


@dataclass(frozen=True, eq=False)
class Flexible(sr.Force):
    """Modes of a body."""

    body: sr.Body
    k: float = 40.0
    d: float = 0.3
    m: float = 0.5
    start: tuple[float, ...] = (0.1, 0.05, 0.0, 0.02, -0.1)

    def blocks(self) -> Iterator[CoordinateBlock]:
        yield CoordinateBlock(f"{self.name}.modes", (FIVE,), self.start, (0.0, 0.4, 0.0, 0.0, 0.0))

    def primitives(self, poses: Any) -> Iterator[Primitive]:
        both = (self.body.name, f"{self.name}.modes")
        yield Primitive(Modes, both, (self.m, 0.2), "inertia")
        yield Primitive(Stiffness, both, (self.k,), "stiffness")
        yield Primitive(Decay, both[1:], (self.d, (1, 0, 0)), "damping")


def flexible(**numbers: Any) -> sr.Model:
    """A pendulum with modes, and a motor, whose current is a state behind them."""
    arm = sr.Body("arm", mass=2.0, inertia=(0.2, 0.3, 0.4), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, arm, point=(0, 0, 0), axis=(0, 1, 0))
    spring = sr.Torque("stop", "pin", value="-30*pin.angle - pin.rate")
    motor = sr.DCMotor("motor", "pin", voltage=1.0, resistance=2.0, inductance=0.05, constant=0.4)
    forces = [spring, motor, Flexible("skin", arm, **numbers)]
    return sr.Model("flexible pendulum", [arm], [pin], forces=forces, gravity=(0, 0, -9.81))


REACH, J, MASS, K, D, M, C = 0.5, 0.2 + 0.1 + 2.0 * 0.25, 2.0, 40.0, 0.3, 0.5, 0.2
TIGHT = sr.Radau(rtol=1e-11)
WRT = ["skin.k", "skin.m", "motor.constant"]
END = sr.Final("skin.modes.w1")


def reduced(t: float, y: Any) -> Any:
    """Rates of the angle θ, w, their rates and the current: x = L cos θ, z = -L sin θ, e₂ = sin(θ/2)."""
    angle, w, speed, rates, current = y[0], y[1:6], y[6], y[7:12], y[12]
    x, z_1, z_2 = REACH * np.cos(angle), -REACH * np.cos(angle), REACH * np.sin(angle)
    e2, e2_1 = np.sin(angle / 2), np.cos(angle / 2) / 2
    x_1, square = -REACH * np.sin(angle), w @ w
    by_w = K * (1 + square) * w + K * np.array([w[4] * x, 4 * w[1] * e2, e2 / 2, 0, w[0] * x])
    by_angle = K * (w[0] * w[4] * x_1 + (2 * w[1] ** 2 + w[2] / 2) * e2_1) + MASS * 9.81 * z_1
    inertia = np.diag([J, M, M + C * w[0] ** 2, M, M, M])
    inertia[0, 1] = inertia[1, 0] = C * z_1
    across = np.array(
        [C * w[0] * rates[1] ** 2 - C * z_2 * speed**2, -2 * C * w[0] * rates[0] * rates[1], 0, 0, 0]
    )
    force = np.concatenate([[-by_angle - 30 * angle - speed + 0.4 * current], across - by_w - D * rates])
    gained = (1.0 - 2.0 * current - 0.4 * speed) / 0.05
    return np.concatenate([[speed], rates, np.linalg.solve(inertia, force), [gained]])


def test_where_the_block_is() -> None:
    """Behind bodies, before states; all operators with their derivatives."""
    system = sr.System(flexible())
    assert system.coordinate_names[7:12] == [f"skin.modes.w{n}" for n in range(1, 6)]
    assert system.moving == 12
    assert system.counts()["degrees_of_freedom"] == 6
    assert system.check_derivatives()


@pytest.mark.parametrize(("method", "error"), [(TIGHT, 1e-8), (sr.HHT(rtol=1e-8), 1e-5)])
def test_a_run_is_that_of_reduced_equations(method: Any, error: float, tmp_path: Path) -> None:
    """A run, saved and loaded."""
    system = sr.System(flexible())
    run = sr.simulate(system, until=1.0, method=method)
    w = np.array([0.1, 0.05, 0, 0.02, -0.1])
    start = np.concatenate([[0], w, [0, 0, 0.4, 0, 0, 0], [0]])
    end = solve_ivp(reduced, (0, 1), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    names = ["pin.angle", *(f"skin.modes.w{n}" for n in range(1, 6)), "skin.modes.w2.rate", "motor.current"]
    found = [run.output(name).values[-1] for name in names]
    assert found == pytest.approx(end[[0, 1, 2, 3, 4, 5, 8, 12]], abs=error)
    assert not run.warnings
    run.save(tmp_path / "run.sarrus")
    again = sr.load_run(tmp_path / "run.sarrus", system)
    assert again.output("skin.modes.w5").values[-1] == found[5]


def test_derivatives_of_runs() -> None:
    """Both directions with each other and with differences of runs; second derivatives with those of gradients."""

    def of(k: float, method: Any = TIGHT) -> Any:
        return sr.simulate(sr.System(flexible(k=k)), until=0.5, method=method, store="steps")

    for method in (TIGHT, sr.HHT(rtol=1e-7)):
        run = of(K, method)
        adjoint, direct = (
            sr.sensitivity(run, END, wrt=WRT, method=way).matrix for way in ("adjoint", "direct")
        )
        assert np.ravel(adjoint) == pytest.approx(np.ravel(direct), rel=1e-9)
    h, run = 1e-3, of(K)
    ends = [of(k) for k in (K + h, K - h)]
    slope = np.subtract(*(one.output("skin.modes.w1").values[-1] for one in ends)) / (2 * h)
    gradients = [np.ravel(sr.sensitivity(one, END, wrt=WRT).matrix) for one in (*ends, run)]
    assert gradients[2][0] == pytest.approx(slope, rel=1e-6)
    hessian = np.squeeze(sr.hessian(run, END, wrt=WRT).matrix)
    assert hessian[0] == pytest.approx((gradients[0] - gradients[1]) / (2 * h), rel=1e-5)


def test_statics_and_modes() -> None:
    """The equilibrium and its eigenvalues are those of the reduced equations."""
    rest = sr.equilibrium(sr.System(flexible()))
    assert rest.success
    system = sr.System(flexible())
    y = root(lambda x: reduced(0, np.concatenate([x[:6], np.zeros(6), x[6:]]))[6:], np.zeros(7), tol=1e-13).x
    assert rest.q[7:12] == pytest.approx(y[1:6], abs=1e-9)
    found, state, h = sr.modes(system, rest), np.concatenate([y[:6], np.zeros(6), y[6:]]), 1e-6
    columns = [(reduced(0, state + h * e) - reduced(0, state - h * e)) / (2 * h) for e in np.eye(13)]
    wanted = np.linalg.eigvals(np.array(columns).T)
    for s in found.eigenvalues:
        assert abs(wanted - s).min() < 1e-6 * abs(s)
    assert "skin.modes" in str(found)
    plant = sr.linearize(system, rest, inputs=[], outputs=["skin.modes.w3"])
    for s in wanted:
        assert abs(np.linalg.eigvals(plant.A) - s).min() < 1e-6 * abs(s)


def test_a_model_without_states_is_described_drawn_and_balanced(tmp_path: Path) -> None:
    """Amplitudes are degrees of freedom, and neither bodies nor positions of mechanisms."""
    whole = flexible()
    model = sr.Model("bare", whole.bodies, whole.joints, forces=whole.forces[::2], gravity=(0, 0, -9.81))
    system = sr.System(model)
    text = describe(model)
    assert "6 × 1 + 5 − 5 = 6" in text
    assert "2 kg in all, centre of mass at (0.5, 0, 0) m" in text
    run = sr.simulate(system, until=0.5, method=TIGHT, store="dense")
    energy = run.output("energy.total").values - run.output("energy.supplied").values
    assert np.ptp(energy) < 1e-9 < np.ptp(run.output("energy.total").values)
    sr.view(system)
    sr.animate(run)
    run.plot("skin.modes.w1")
    assert "0.3" in run._repr_html_()
    assert same_signs(-run.q, 1)[:, 7:] == pytest.approx(-run.q[:, 7:])
    with pytest.raises(sr.SarrusError, match=r"coordinates of skin\.modes follow from forces"):
        sr.workspace_range(system, "pin.angle")


def test_start_of_amplitudes_as_a_parameter() -> None:
    """Derivatives by the amplitude at the start, by differences of the reduced equations."""

    def end(first: float) -> Any:
        y = np.concatenate([[0, first, 0.05, 0, 0.02, -0.1], [0, 0, 0.4, 0, 0, 0], [0]])
        return solve_ivp(reduced, (0, 0.5), y, "DOP853", rtol=1e-12, atol=1e-13).y[1, -1]

    run = sr.simulate(sr.System(flexible()), until=0.5, method=TIGHT, store="steps")
    gradient = sr.sensitivity(run, END, wrt=["skin.start.x", "start.q.skin.modes.w1"])
    assert np.ravel(gradient.matrix) == pytest.approx(2 * [(end(0.101) - end(0.099)) / 0.002], rel=1e-5)
    assert "0.1 m " in str(gradient)


def test_what_is_refused() -> None:
    """An element on the wrong kind of owner, a name that is another's, and numbers that are too few."""
    with pytest.raises(sr.ModelError, match="Give 5 numbers for"):
        sr.System(flexible(start=(0.1, 0.2)))
    model = flexible()
    again = Flexible("skin", model.bodies[0])
    object.__setattr__(again, "body", sr.Body("skin.modes", mass=1.0, inertia=(1, 1, 1)))
    with pytest.raises(
        sr.ModelError, match=r"is for blocks of position \(3\) and rotation \(4\), but those of"
    ):
        sr.System(sr.Model("wrong", model.bodies, model.joints, [again]))


@dataclass(frozen=True, eq=False)
class Misnamed(Flexible):
    """Modes with the name of a joint."""

    def blocks(self) -> Iterator[CoordinateBlock]:
        yield next(super().blocks())._replace(name="pin")


@dataclass(frozen=True, eq=False)
class Wrong(sr.Force):
    """Blocks of some kinds."""

    of: tuple[Kind, ...]

    def blocks(self) -> Iterator[CoordinateBlock]:
        size = sum(len(kind.parts) for kind in self.of)
        yield CoordinateBlock(self.name, self.of, [0.0] * size, [0.0] * size)

    def primitives(self, poses: Any) -> Iterator[Primitive]:
        yield from ()


def test_a_block_has_the_name_of_its_part() -> None:
    """With a dot behind it, or without."""
    model = flexible()
    with pytest.raises(sr.ModelError, match=r'must begin with its own\. Write "skin", or "skin\.modes"'):
        sr.System(sr.Model("wrong", model.bodies, model.joints, [Misnamed("skin", model.bodies[0])]))


@pytest.mark.parametrize("kinds", [RIGID[:1], ()])
def test_kinds_that_a_block_cannot_have(kinds: tuple[Kind, ...]) -> None:
    """Coordinates of bodies, and none."""
    model = flexible()
    with pytest.raises(sr.ModelError, match="Blocks of new must be amplitudes"):
        sr.System(sr.Model("wrong", model.bodies, model.joints, [Wrong("new", kinds)]))


class Held(elements.Primitive, rows=2, bodies=2, derivatives="automatic", registered=False):
    """w₄ + w₅ + 0.08 + (x - 0.5) = 0, w₃ = 0."""

    @classmethod
    def owners(cls) -> tuple[tuple[Kind, ...], ...]:
        return RIGID, (FIVE,)

    def Phi(self, x: Any) -> Any:
        return np.array([x[2][3] + x[2][4] + 0.08 + x[0][0] - REACH, x[2][2]])


@dataclass(frozen=True, eq=False)
class Holding(Flexible):
    """Modes with constraints."""

    def primitives(self, poses: Any) -> Iterator[Primitive]:
        yield from super().primitives(poses)
        yield Primitive(Held, (self.body.name, f"{self.name}.modes"), (), "held")


_kinds = kinds_of_forces_here("flexible", "misnamed", "wrong", "holding")


def test_constraints_on_amplitudes_and_redundant_joints() -> None:
    """Two equal pins bear half of what one does, with derivatives of their reactions."""
    model = flexible()
    arm, forces = model.bodies[0], [*model.forces[:2], Holding("skin", model.bodies[0])]
    second = sr.Revolute("second", sr.ground, arm, point=(0, 0, 0), axis=(0, 1, 0))
    ends, slopes = [], []
    for joints in (model.joints, [*model.joints, second]):
        system = sr.System(sr.Model("held", [arm], joints, forces, gravity=(0, 0, -9.81)))
        assert sr.mobility(system).degrees_of_freedom == 4
        omitted = left_out(system, None)
        assert omitted.apart[:, 0].max() < len(omitted.weight) == len(omitted.force)  # of compiled code
        run = sr.simulate(system, until=0.5, method=TIGHT, store="steps")
        assert run.q[-1] @ np.eye(system.nq)[10] + run.q[-1, 11] + 0.08 + run.q[-1, 0] == pytest.approx(REACH)
        ends.append(run.output("pin.force.z").values[-1])
        slopes.append(
            [
                np.ravel(sr.sensitivity(run, sr.Final("pin.force.z"), wrt=WRT, method=way).matrix)
                for way in ("adjoint", "direct")
            ]
        )
    assert ends[1] == pytest.approx(ends[0] / 2, rel=1e-8)
    assert slopes[0][0] == pytest.approx(slopes[0][1], rel=1e-7)
    assert slopes[1][0] == pytest.approx(slopes[0][0] / 2, rel=1e-6)
    assert slopes[1][0] == pytest.approx(slopes[1][1], rel=1e-7)
