"""The same mechanisms in other units: the same steps and the same digits, with default settings.

Lengths are 1e-9 to 1e6 of those in SI units, masses 1e-12 to 1e12, times 1e-6 to 1e4. Units that differ by powers of
two change no digit of a model's numbers: whatever differs was decided by a number with a unit. Powers of ten change
the last digit: whatever differs was decided by that, or by a scale that is rounded.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.position.initial_state import is_off
from sarrus.functions import sin

Z = (0, 0, 1)
END = 1.0  # [s] of runs, in SI units


class Units(NamedTuple):
    """SI units in those of a model, and numbers in these."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    def __call__(self, value: float, length: float = 0, mass: float = 0, time: float = 0) -> float:
        return float(value * self.length**length * self.mass**mass * self.time**time)

    def coordinates(self, count: int) -> np.ndarray:
        """The unit of each coordinate."""
        return np.tile(np.repeat([self(1, 1), 1.0], (3, 4)), count // 7)


SCALES = [
    (1e-9, 1, 1), (1e6, 1, 1), (1, 1e-12, 1), (1, 1e12, 1), (1, 1, 1e-6), (1, 1, 1e4), (1e-9, 1e-12, 1e-6),
    (1e6, 1e12, 1e4),
]  # fmt: skip
OTHERS = [Units(*(2.0 ** round(float(np.log2(x))) for x in one)) for one in SCALES]
EXTREMES, DECIMAL = OTHERS[-2:], [Units(*one) for one in SCALES]


def rod(u: Units, name: str, p: tuple[float, float], q: tuple[float, float], mass: float) -> sr.Body:
    d, middle = np.subtract(q, p), np.add(q, p) / 2
    J = mass * float(d @ d) / 12
    return sr.Body(
        name, u(mass, 0, 1), (u(0.01 * J, 2, 1), u(J, 2, 1), u(J, 2, 1)),
        position=(u(middle[0], 1), u(middle[1], 1), 0), orientation=sr.AxisAngle(Z, float(np.arctan2(d[1], d[0]))),
    )  # fmt: skip


def pin(u: Units, name: str, i: sr.Body, j: sr.Body, at: tuple[float, float]) -> sr.Revolute:
    return sr.Revolute(name, i, j, point=(u(at[0], 1), u(at[1], 1), 0), axis=Z)


def weight(u: Units) -> tuple[float, float, float]:
    return (0, u(-9.81, 1, 0, -2), 0)


def slider_crank(u: Units, *drivers: sr.AngleDriver) -> sr.Model:
    C, S = (0.06, 0.08), (0.06 + np.sqrt(0.3**2 - 0.08**2), 0.0)
    crank, coupler = rod(u, "crank", (0, 0), C, 0.5), rod(u, "rod", C, S, 0.8)
    slider = sr.Body("slider", u(1.2, 0, 1), (u(1e-3, 2, 1),) * 3, position=(u(S[0], 1), 0, 0))
    joints = [
        pin(u, "O", sr.ground, crank, (0, 0)), pin(u, "C", crank, coupler, C), pin(u, "S", coupler, slider, S),
        sr.Translational("guide", sr.ground, slider, point=(0, 0, 0), axis=(1, 0, 0)),
    ]  # fmt: skip
    return sr.Model("slider-crank", [crank, coupler, slider], joints, drivers=[*drivers], gravity=weight(u))


def driven(u: Units) -> sr.Model:
    second = u(1, 0, 0, 1)

    def angle(t):  # type: ignore[no-untyped-def]
        return 3.0 * (t / second) + 0.2 * sin(5.0 * (t / second))

    return slider_crank(u, sr.AngleDriver("motor", "O", angle))


def four_bar(u: Units) -> sr.Model:
    A, B, C, D = (0.0, 0.0), (0.2, 0.9), (1.6, 1.1), (1.5, 0.0)
    bodies = [rod(u, "crank", A, B, 1.3), rod(u, "coupler", B, C, 2.1), rod(u, "rocker", C, D, 1.7)]
    joints = [
        pin(u, "A", sr.ground, bodies[0], A), pin(u, "B", bodies[0], bodies[1], B),
        pin(u, "C", bodies[1], bodies[2], C), pin(u, "D", sr.ground, bodies[2], D),
    ]  # fmt: skip
    return sr.Model("four-bar", bodies, joints, gravity=weight(u))


def double_pendulum(u: Units) -> sr.Model:
    A, B, C = (0.0, 0.0), (0.7, -0.3), (1.1, 0.4)
    upper, lower = rod(u, "upper", A, B, 1.3), rod(u, "lower", B, C, 0.6)
    spring = sr.TSDA(
        "spring", sr.ground.point(u(0.9, 1), u(0.2, 1), 0), lower.point(u(0.1, 1), 0, 0),
        k=u(120.0, 0, 1, -2), c=u(2.5, 0, 1, -1), length=u(0.6, 1),
    )  # fmt: skip
    joints = [pin(u, "A", sr.ground, upper, A), pin(u, "B", upper, lower, B)]
    return sr.Model("double pendulum", [upper, lower], joints, [spring], gravity=weight(u))


def sliding_ball(u: Units) -> sr.Model:
    """A ball falls on the ground, slides and rolls; beside it a pendulum with friction in its pin."""
    ball = sr.Body(
        "ball",
        u(0.7, 0, 1),
        (u(0.003, 2, 1),) * 3,
        position=(0, 0, u(0.16, 1)),
        velocity=(u(0.8, 1, 0, -1), 0, 0),
    )
    floor = sr.SphereContact(
        "floor", ball.point(0, 0, 0), sr.ground.frame((0, 0, 0)), radius=u(0.1, 1), stiffness=u(2e3, 0, 1, -2),
        exponent=1.0, damping=u(0.5, -1, 0, 1), rounding=u(1e-3, 1), mu=0.3, creep=u(1e-2, 1, 0, -1),
    )  # fmt: skip
    arm = rod(u, "arm", (2.0, 0.0), (2.3, 0.4), 0.9)
    friction = sr.AngleFriction(
        "friction", sr.ground, arm, point=(u(2.0, 1), 0, 0), axis=Z,
        load=u(6.0, 1, 1, -2), mu=0.2, creep=u(1e-2, 1, 0, -1),
        stribeck=u(2e-2, 1, 0, -1),
        radius=u(0.01, 1),
    )  # fmt: skip
    pins = [pin(u, "pin", sr.ground, arm, (2.0, 0.0))]
    return sr.Model(
        "ball", [ball, arm], pins, [floor, friction], gravity=(0, 0.5 * weight(u)[1], weight(u)[1])
    )


def leaning_coin(u: Units) -> sr.Model:
    """It rolls without slip: of its equations, two restrict velocities only."""
    R, lean, speed = 0.3, 0.2, 2.0
    axis = np.array([0, np.cos(lean), np.sin(lean)])
    coin = sr.Body(
        "coin", u(2, 0, 1), (u(0.045, 2, 1), u(0.09, 2, 1), u(0.045, 2, 1)), position=(0, 0, u(R * np.cos(lean), 1)),
        orientation=sr.AxisAngle((1, 0, 0), lean), velocity=(u(speed, 1, 0, -1), 0, 0),
        angular_velocity=u(1, 0, 0, -1) * speed / R * axis,
    )  # fmt: skip
    plane = sr.ground.frame((0, 0, 0))
    rolls = sr.RollingDisc("rolls", center=coin.point(0, 0, 0), plane=plane, radius=u(R, 1), axis=axis)
    return sr.Model("coin", [coin], [rolls], gravity=(0, 0, weight(u)[1]))


MODELS = [slider_crank, driven, four_bar, double_pendulum, sliding_ball, leaning_coin]
Maker = Callable[[Units], sr.Model]


@cache
def run(make: Maker, u: Units, method: str) -> tuple[tuple[int, ...], np.ndarray, np.ndarray]:
    """Counts of a run with default settings; coordinates and velocities in SI units."""
    system = sr.System(make(u))
    found = sr.simulate(system, until=u(END, 0, 0, 1), method=getattr(sr, method)())
    assert found.success, found.message
    unit = u.coordinates(system.nq)
    counts = found.nsteps, found.nrejected, found.nfev, found.njev
    return counts, found.q / unit, found.v / unit * u(1, 0, 0, 1)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("u", OTHERS)
@pytest.mark.parametrize("make", MODELS)
def test_a_run_takes_the_same_steps(make: Maker, u: Units) -> None:
    same_runs(make, u, "Radau")


@pytest.mark.one_in(4)
@pytest.mark.parametrize("u", EXTREMES)
@pytest.mark.parametrize("make", MODELS)
def test_a_run_by_the_method_of_order_two(make: Maker, u: Units) -> None:
    same_runs(make, u, "HHT")


@pytest.mark.one_in(4)
@pytest.mark.parametrize("u", DECIMAL)
@pytest.mark.parametrize("make", [slider_crank, driven, four_bar, double_pendulum])
def test_a_run_in_decimal_units_takes_the_same_steps(make: Maker, u: Units) -> None:
    """Round-off grows by what it is magnified by in the motion."""
    counts, q, v = run(make, Units(), "Radau")
    others, r, w = run(make, u, "Radau")
    assert others == counts
    assert abs(r - q).max() <= 3e-11 * abs(q).max()
    assert abs(w - v).max() <= 3e-10 * abs(v).max()


@pytest.mark.one_in(4)
@pytest.mark.parametrize("u", DECIMAL)
def test_a_run_with_contact_in_decimal_units(u: Units) -> None:
    """Round-off changes lengths of steps by 1e-4, and with them what a step into the contact does: see decision 042."""
    counts, q, _ = run(sliding_ball, Units(), "Radau")
    others, r, _ = run(sliding_ball, u, "Radau")
    assert abs(others[0] - counts[0]) <= 0.02 * counts[0]
    assert abs(r[-1] - q[-1]).max() <= 1e-7 * abs(q).max()


@pytest.mark.parametrize(("time", "gap"), [(1.0, 1e-11), (2.0**-20, 5e-6), (2.0**-30, 1e-3)])
def test_impacts_one_after_the_other(time: float, gap: float) -> None:
    """The second one made the first ball fall through the floor, if it came so soon, but after this one's."""
    u, falls = Units(time=time), np.array([1.0, 1.0 + gap])
    heights = 9.81 / 2 * falls**2
    balls = [
        sr.Body(n, 1.0, (1, 1, 1), position=(x, h, 0)) for n, x, h in zip("ab", (0, 9), heights, strict=True)
    ]
    events = [sr.Event(f"{ball.name}.y", reset=sr.Impact(0.8)) for ball in balls]
    system = sr.System(sr.Model("balls", balls, gravity=weight(u)))
    found = sr.simulate(system, until=u(3.0, 0, 0, 1), events=events)
    assert [event.name for event in found.events] == ["a.y", "b.y"] * 2
    times = np.array([event.t for event in found.events]) / u(1.0, 0, 0, 1)
    assert times == pytest.approx([*falls, *2.6 * falls], abs=1e-12)


def same_runs(make: Maker, u: Units, method: str) -> None:
    counts, q, v = run(make, Units(), method)
    others, r, w = run(make, u, method)
    assert others == counts
    assert abs(r - q).max() <= 1e-13 * abs(q).max()
    assert abs(w - v).max() <= 1e-12 * abs(v).max()


@pytest.mark.parametrize("u", EXTREMES)
@pytest.mark.parametrize("make", [slider_crank, four_bar, double_pendulum])
def test_equilibria_and_modes(make: Maker, u: Units) -> None:
    found = []
    for units in (Units(), u):
        system = sr.System(make(units))
        rest = sr.equilibrium(system)
        assert rest.success, rest.message
        found.append(
            (rest.q / units.coordinates(system.nq), sr.modes(system, rest).eigenvalues * units(1, 0, 0, 1))
        )
    (q, values), (r, others) = found
    assert abs(r - q).max() < 1e-10
    assert abs(others - values).max() < 1e-8 * abs(values).max()


@cache
def corrected(make: Maker, u: Units) -> tuple[int, int, list[np.ndarray]]:
    """Counts and, in SI units, states of an assembly and of a short run from a start that contradicts constraints."""
    system, random = sr.System(make(u)), np.random.default_rng(3)
    unit = u.coordinates(system.nq)
    q, v = system.q0 + 0.05 * unit * random.normal(size=system.nq), unit * random.normal(size=system.nq)
    start = sr.assemble(system, q, v * u(1, 0, 0, -1))
    run = sr.simulate(system, start, until=u(0.02, 0, 0, 1))
    assert run.success, run.message
    rates = [x / unit * u(1, 0, 0, 1) for x in (start.v, run.v[-1])]
    return start.iterations, run.nsteps, [start.q / unit, run.q[-1] / unit, *rates]


@pytest.mark.filterwarnings("ignore:.*assembly changed")
@pytest.mark.parametrize(
    ("u", "error"),
    [*((u, 0.0) for u in EXTREMES), *((u, 1e-12) for u in (Units(100.0), Units(1e-8, 1e-12, 1e-6)))],
)
@pytest.mark.parametrize("make", [four_bar, double_pendulum])
def test_a_start_that_contradicts_the_constraints(make: Maker, u: Units, error: float) -> None:
    """It is corrected alike in all units, and so is the motion from it."""
    *counts, states = corrected(make, Units())
    *others, found = corrected(make, u)
    assert others == counts
    for x, y in zip(states, found, strict=True):
        assert abs(y - x).max() <= error * abs(x).max()


@pytest.mark.parametrize("u", [Units(), *EXTREMES])
def test_a_state_that_is_off_its_constraints(u: Units) -> None:
    """States of runs may be off by the tolerances of solvers, but not by 1e-5 of the mechanism."""
    system, random = sr.System(four_bar(u)), np.random.default_rng(3)
    change = 1e-5 * u.coordinates(system.nq) * random.normal(size=system.nq)
    q, v = system.q0, sr.assemble(system, rates={"A": u(1, 0, 0, -1)}).v
    for part, off in ((0.0, False), (1e-3, False), (1.0, True)):
        assert is_off(system, q + part * change, v, 0.0) is off
        assert is_off(system, q, v + part * change * u(1, 0, 0, -1), 0.0) is off
