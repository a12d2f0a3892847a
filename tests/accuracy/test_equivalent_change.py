"""Errors of derivatives late in chaotic motions, by a change of the parameters that moves the run as its errors do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.accuracy.test_derivative_errors import on_stops

import sarrus as sr
from sarrus.analyses.sensitivity.accuracy.derivatives.equivalent_change import EquivalentChange, moved_along
from sarrus.analyses.sensitivity.accuracy.state_errors import SumErrors
from sarrus.analyses.sensitivity.derivatives import differentiated
from sarrus.analyses.sensitivity.events.chains import chain_of
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.results import Pieces, StepsTaken


def pendulum(*lengths: float) -> sr.System:
    """Bodies in a row, from the horizontal."""
    bodies, pins, x = list[sr.Body](), [], 0.0
    before: Any = sr.ground
    for name, length, mass, inertia in zip("abc", lengths, (1.5, 2.0, 1.6), (0.05, 0.3, 0.09), strict=False):
        body = sr.Body(name, mass, (inertia,) * 3, position=(x + length / 2, 0, 0))
        pins.append(sr.Revolute(f"pin_{name}", before, body, point=(x, 0, 0), axis=(0, 0, 1)))
        bodies, x, before = [*bodies, body], x + length, body
    return sr.System(sr.Model("pendulum", bodies, pins, gravity=(0, -9.81, 0)))


def swinging_spring() -> sr.System:
    """A mass on a soft spring swings far."""
    body = sr.Body("b", 1.0, (0.1,) * 3, position=(1.6, 0.1, 0))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 0), body.point(0, 0, 0), k=20.0, length=1.0)
    return sr.System(sr.Model("swinging spring", [body], [], [spring], gravity=(0, -9.81, 0)))


EVENTS = {
    "none": (),
    "new velocities": sr.Event("a.x", reset=lambda t, q, v: 0.99 * v),
    "end": sr.Event("b.x", terminal=True),
}


@pytest.mark.one_in(6)
@pytest.mark.parametrize("events", EVENTS)
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()])
def test_derivatives_of_moved_steps_are_changed_by_the_hessian(method: Any, events: str) -> None:
    """A run of Radau moves with its stages, one of HHT with the ends of its steps; events move in time, too."""
    system, names = pendulum(1.2, 0.5), ["a.mass", "b.mass", "b.inertia.zz"]
    given = {"method": method, "rtol": 1e-8, "events": EVENTS[events]}
    check_moved(sr.simulate(system, until=3.0, store_steps=True, **given), "b.y", names)


@pytest.mark.slow
def test_moved_steps_meet_stops_and_grounds_at_other_times() -> None:
    names = ["stop.stiffness", "mass.mass"]
    check_moved(sr.simulate(on_stops(), until=0.3, method=sr.HHT(), store_steps=True), "mass.x", names)
    ball = sr.Body("ball", 1.0, (1e-3,) * 3, position=(0, 0, 1))
    system = sr.System(sr.Model("bouncing", bodies=[ball], gravity=(0, 0, -9.81)))
    floor = sr.Event("ball.z", direction=-1, reset=sr.Impact(0.9))
    check_moved(sr.simulate(system, until=2.0, events=floor, store_steps=True), "ball.z", ["ball.position.z"])


def check_moved(run: sr.Trajectory, output: str, names: list[str]) -> None:
    system, steps = run.system, run.steps
    assert system is not None
    assert isinstance(steps, StepsTaken | Pieces)
    parameters = Parameters(system, names, start=steps.start, restitutions=run.restitutions)
    direction = np.array([0.3, -0.2, 0.1])[: len(names)] * parameters.values
    moved, small = moved_along(chain_of(system, steps, run.restitutions), parameters, direction)
    before, after = (
        differentiated(system, own, [sr.Final(output)], parameters).matrix[0] for own in (steps, moved)
    )
    product = sr.hessian_product(run, output, dict(zip(names, direction, strict=True)), names)
    assert (after - before) / small == pytest.approx(product, rel=3e-3, abs=3e-3 * abs(product).max())


def test_errors_of_one_direction_are_an_equivalent_change() -> None:
    of_sums, noise = np.outer([3.0, -1.0, 2.0], [1.0, 0.5]) * 1e6, np.zeros(3)
    weights, change = np.array([2.0, 1.0]), np.array([1e-8, 5e-9])
    found = EquivalentChange.of(SumErrors(of_sums @ change, noise), of_sums, weights)
    assert found is not None
    assert found.rest < 1e-9
    assert of_sums @ found.direction * found.multiple == pytest.approx(
        abs(of_sums @ change) * np.sign(of_sums[:, 0])
    )
    other = EquivalentChange.of(SumErrors(np.array([1.0, 3.0, 0.0]), noise), of_sums, weights)
    assert other is not None
    assert other.rest == pytest.approx(1.0)
    lost = EquivalentChange.of(SumErrors(of_sums @ change * 1e9, noise), of_sums, weights)
    assert lost is not None  # errors as large as the motion
    assert np.linalg.norm(of_sums @ lost.direction * lost.multiple) == pytest.approx(np.sqrt(3))
    nothing = np.zeros((3, 2))
    assert EquivalentChange.of(SumErrors(np.ones(3), noise), nothing, weights) is None


@pytest.mark.filterwarnings("ignore:.*(derivatives have|errors have grown)")
def test_a_parameter_may_be_tiny() -> None:
    """A relative change of it would move the steps by less than round-off, and squares of its effect would vanish."""
    bodies, joints = (getattr(pendulum(1.2, 0.5).model, name) for name in ("bodies", "joints"))
    found = list[float]()
    for k in (0.0, 1e-30, 1e-200):
        spring = sr.TSDA("s", sr.ground.point(0, 3, 0), bodies[0].point(0, 0, 0), k=k, length=1.0)
        system = sr.System(sr.Model("p", bodies, joints, [spring], gravity=(0, -9.81, 0)))
        run = sr.simulate(system, until=8.0, rtol=1e-6, store_steps=True)
        found += sr.sensitivity(run, "b.x", ["s.k"], error=True).relative_errors
    assert found == pytest.approx(found[:1] * 3, rel=1e-3)


@pytest.mark.filterwarnings("ignore:.*errors have grown")
def test_derivatives_that_are_zero_have_no_errors() -> None:
    """A free body turns about its middle axis, which is unstable, and its centre rests."""
    body = sr.Body("b", 1.0, (1.0, 2.0, 3.0), angular_velocity=(1e-3, 5.0, 0.0))
    run = sr.simulate(sr.System(sr.Model("spinning", [body])), until=10.0, store_steps=True)
    for method in ("adjoint", "direct"):
        found = sr.sensitivity(run, "b.x", ["b.inertia.xx", "b.inertia.yy"], method=method, error=True)
        assert not found.matrix.any()
        assert found.relative_errors == (0.0,)
        assert not found.warnings


K = 5.0


def beside_chaos(loop: bool = False) -> sr.System:
    """An oscillator beside a chaotic pendulum, which nothing connects, and perhaps a planar four-bar."""
    model = pendulum(1.2, 0.5).model
    body = sr.Body("d", 1.0, (0.1,) * 3, position=(0, 5, 0))
    guide = sr.Translational("g", sr.ground, body, point=(0, 5, 0), axis=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(-3, 5, 0), body.point(0, 0, 0), k=K, length=2.5)
    bodies, joints, before = [*model.bodies, body], [*model.joints, guide], sr.ground
    points = np.array([(5, 0, 0), (5, 1, 0), (7, 1.5, 0), (7, 0, 0)])
    for name, start, end in zip("efh", points, points[1:], strict=False) if loop else ():
        bar = sr.Body(name, 1.0, (0.1,) * 3, position=tuple((start + end) / 2))
        joints.append(sr.Revolute(f"pin_{name}", before, bar, point=tuple(start), axis=(0, 0, 1)))
        bodies, before = [*bodies, bar], bar
    if loop:
        joints.append(sr.Revolute("last", before, sr.ground, point=tuple(points[-1]), axis=(0, 0, 1)))
    return sr.System(sr.Model("beside", bodies, joints, [spring], gravity=(0, -9.81, 0)))


def oscillated(until: float) -> float:
    """The derivative of its place by the stiffness."""
    return float(-0.25 * until / np.sqrt(K) * np.sin(np.sqrt(K) * until))


@pytest.mark.one_in(2)
@pytest.mark.filterwarnings("ignore:.*errors have grown")
@pytest.mark.parametrize("loop", [False, True])
def test_derivatives_of_a_regular_part_have_its_own_errors(loop: bool) -> None:
    """Asked for alone or together with a part that is chaotic: parameters, Hessians, states and by checkpoints."""
    until, system = 12.0, beside_chaos(loop)
    run = sr.simulate(system, until=until, rtol=1e-6, store_steps=True)
    for outputs in (["d.x"], ["b.x", "d.x"]):
        found = sr.sensitivity(run, outputs, ["s.k"], error=True)
        error = abs(found.matrix[-1, 0] / oscillated(until) - 1)
        assert error / 10 < found.relative_errors[-1] < 10 * error
        assert error < 1e-6
        assert set(found.relative_errors[:-1]) <= {0.0}
        assert not found.warnings
    assert not sr.state_derivatives(run, ["s.k"]).warnings
    assert not sr.sensitivity_by_checkpoints(system, "d.x", ["s.k"], until=until, rtol=1e-6).warnings
    second = sr.hessian(run, "d.x", ["s.k"], error=True)
    assert second.relative_error is not None
    assert second.relative_error < 1e-6


LATE = [
    ((1.2, 0.5), "b.x", 25.0, 1e-9), ((1.2, 0.5), "b.x", 29.0, 1e-11), ((1.2, 0.5), "b.x", 30.0, 1e-11),
    ((0.7, 1.6), "b.x", 20.0, 1e-9), ((0.7, 1.6), "b.x", 25.0, 1e-9), ((0.7, 1.6), "b.x", 30.0, 1e-11),
    ((1.0, 0.8, 0.6), "c.x", 10.0, 1e-9), ((), "b.x", 40.0, 1e-9),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*(derivatives have|errors have grown)")
@pytest.mark.parametrize(("lengths", "output", "until", "rtol"), LATE)
def test_late_in_chaos(lengths: tuple[float, ...], output: str, until: float, rtol: float) -> None:
    """Relative errors of derivatives are 1 to 200 times the errors of the states, and are known to a factor of 2."""
    system = pendulum(*lengths) if lengths else swinging_spring()
    names = ["a.mass", "b.mass"] if lengths else ["s.k", "b.mass"]
    runs = (sr.simulate(system, until=until, rtol=own, store_steps=True) for own in (1e-13, rtol))
    truth, found = (sr.sensitivity(run, output, names, error=True) for run in runs)
    error = np.linalg.norm(found.matrix - truth.matrix) / np.linalg.norm(truth.matrix)
    assert error / 2 < found.relative_errors[0] < 2 * error


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*(derivatives have|errors have grown)")
def test_all_kinds_of_derivatives_warn_late_in_chaos() -> None:
    """After 30 s derivatives are off by 20 %, although the states are off by 0.1 % of the motion."""
    run = sr.simulate(pendulum(1.2, 0.5), until=30.0, rtol=1e-11, store_steps=True)
    assert not run.warnings
    names = ["a.mass"]
    kinds = (
        sr.sensitivity(run, "b.x", names), sr.sensitivity(run, "b.x", names, method="direct"),
        sr.hessian(run, "b.x", names), sr.state_derivatives(run, names),
    )  # fmt: skip
    for found in kinds:
        assert any("the adjoint grows" in message for message in found.warnings)
