"""Errors of derivatives late in chaotic motions, by a change of the parameters that moves the run as its errors do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.accuracy.equivalent_change import EquivalentChange, moved_along
from sarrus.analyses.sensitivity.accuracy.estimate import Effects
from sarrus.analyses.sensitivity.chain.chain import Chain
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.results import StepsTaken


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


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()])
def test_derivatives_of_moved_steps_are_changed_by_the_hessian(method: Any) -> None:
    """A run of Radau moves with its stages, one of HHT with the ends of its steps."""
    system, names = pendulum(1.2, 0.5), ["a.mass", "b.mass", "b.inertia.zz"]
    run = sr.simulate(system, until=3.0, method=method, rtol=1e-7, store_steps=True)
    steps, direction = run.steps, np.array([0.3, -0.2, 0.1])
    assert isinstance(steps, StepsTaken)
    parameters, place = Parameters(system, names, start=steps.start), run.coordinate_names.index("b.r.x")
    moved, small = moved_along(Chain(system, steps), parameters, direction)
    changes = parameters.along(np.eye(len(names)))
    before, after = (Chain(system, own).along(*changes).q[-1, place] for own in (steps, moved))
    product = sr.hessian_product(run, "b.x", dict(zip(names, direction, strict=True)), names)
    assert before == pytest.approx(sr.sensitivity(run, "b.x", names).matrix[0], rel=1e-9)
    assert (after - before) / small == pytest.approx(product, rel=1e-3, abs=1e-3 * abs(product).max())


def test_errors_of_one_direction_are_an_equivalent_change() -> None:
    of_sums, noise = np.outer([3.0, -1.0, 2.0], [1.0, 0.5]) * 1e6, np.zeros(3)
    weights, change = np.array([2.0, 1.0]), np.array([1e-8, 5e-9])
    found = EquivalentChange.of(Effects((of_sums @ change)[None], noise), of_sums, weights)
    assert found is not None
    assert found.rest < 1e-9
    assert of_sums @ found.direction * found.multiple == pytest.approx(
        abs(of_sums @ change) * np.sign(of_sums[:, 0])
    )
    other = EquivalentChange.of(Effects(np.array([[1.0, 3.0, 0.0]]), noise), of_sums, weights)
    assert other is not None
    assert other.rest == pytest.approx(1.0)
    lost = EquivalentChange.of(Effects((of_sums @ change)[None] * 1e9, noise), of_sums, weights)
    assert lost is not None  # errors as large as the motion
    assert np.linalg.norm(of_sums @ lost.direction * lost.multiple) == pytest.approx(np.sqrt(3))
    nothing = np.zeros((3, 2))
    assert EquivalentChange.of(Effects(np.ones((1, 3)), noise), nothing, weights) is None


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
