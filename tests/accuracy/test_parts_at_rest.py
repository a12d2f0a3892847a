"""Derivatives of parts at rest: steps suit a motion that there is none of, but not what parameters change in it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sarrus as sr

MESSAGE = "as some steps suit the motion, but not its changes by parameters."
WARNED = pytest.mark.filterwarnings("ignore:.*derivatives have")
METHODS = {"radau": sr.Radau(), "hht": sr.HHT()}
BY = pytest.mark.parametrize("by", METHODS.values(), ids=METHODS)


def resting(k: float, c: float = 1.0, beside: bool = False) -> sr.System:
    """1 kg at rest on a spring, perhaps beside a pendulum that swings."""
    body = sr.Body("m", 1.0, (1e-3,) * 3)
    swinging = sr.Body("p", 2.0, (0.1,) * 3, position=(1, 5, 0))
    joints = [
        sr.Translational("g", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0)),
        sr.Revolute("pin", sr.ground, swinging, point=(0, 5, 0), axis=(0, 0, 1)),
    ]
    spring = sr.TSDA("s", sr.ground.point(-1, 0, 0), body.point(0, 0, 0), k=k, c=c, length=1.0)
    bodies = [body, swinging] if beside else [body]
    return sr.System(sr.Model("rest", bodies, joints[: len(bodies)], [spring], gravity=(0, -9.81, 0)))


def by_length(k: float, until: float, c: float = 1.0) -> float:
    """The derivative of the place by the length of the spring, with the roots r, s of λ² + c λ + k = 0."""
    r, s = np.roots([1.0, c, k]).astype(complex)
    return float((1 + (s * np.exp(r * until) - r * np.exp(s * until)) / (r - s)).real)


CASES = [(100.0, 1.0, False), (100.0, 1.5, False), (1e3, 1.0, False), (1e4, 1.0, True), (1e6, 1.0, True)]


@WARNED
@BY
@pytest.mark.parametrize(("k", "until", "beside"), CASES)
def test_wrong_derivatives_of_a_mass_at_rest_are_known(k: float, until: float, beside: bool, by: Any) -> None:
    """By every route, with an estimate of the size of the error."""
    run = sr.simulate(resting(k, beside=beside), until=until, method=by, store_steps=True)
    found = sr.sensitivity(run, "m.x", ["s.length"], error=True)
    error = abs(found.matrix[0, 0] / by_length(k, until) - 1.0)
    assert error > 0.03
    true = abs(found.matrix[0, 0] - by_length(k, until)) / abs(found.matrix[0, 0])
    assert true / 10 < found.relative_errors[0] < 10 * true
    every = [
        found,
        sr.sensitivity(run, "m.x", ["s.length"]),
        sr.sensitivity(run, "m.x", ["s.length"], method="direct"),
        sr.hessian(run, "m.x", ["s.length"]),
        *([sr.state_derivatives(run, ["s.length"])] if error > 0.1 else ()),
        sr.sensitivity_by_checkpoints(resting(k, beside=beside), "m.x", ["s.length"], until=until, method=by),
    ]
    assert all(any(MESSAGE in one for one in own.warnings) for own in every)


@BY
@pytest.mark.parametrize("c", [300.0, 3e3, 1e5])
def test_no_warning_where_the_oscillation_is_damped_out(c: float, by: Any) -> None:
    """Steps are as long as before, but the stiff part follows its spring, and derivatives are right."""
    run = sr.simulate(resting(1e6, c, beside=True), until=1.0, method=by, store_steps=True)
    found = sr.sensitivity(run, "m.x", ["s.length"], error=True)
    assert found.matrix[0, 0] == pytest.approx(by_length(1e6, 1.0, c), rel=3e-3)
    assert found.relative_errors[0] < 0.01
    assert not found.warnings


@pytest.mark.parametrize(("by", "max_step"), [(sr.Radau(), 0.02), (sr.HHT(), 1e-3)], ids=METHODS)
def test_no_warning_where_steps_are_short(by: Any, max_step: float) -> None:
    run = sr.simulate(resting(100.0), until=1.0, method=by, max_step=max_step, store_steps=True)
    found = sr.sensitivity(run, "m.x", ["s.length"], error=True)
    assert found.matrix[0, 0] == pytest.approx(by_length(100.0, 1.0), rel=3e-3)
    assert found.relative_errors[0] < 3e-3
    assert not found.warnings


@WARNED
@BY
def test_pendulum_that_hangs_at_rest(by: Any) -> None:
    """A horizontal force at its end turns it by (1 - cos ωt) F/mg."""
    body = sr.Body("a", 2.0, (0.1,) * 3, position=(0, -1, 0))
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    push = sr.PointForce("f", body.point(0, 0, 0), (1, 0, 0), factor=0.0)
    system = sr.System(sr.Model("hanging", [body], [pin], [push], gravity=(0, -9.81, 0)))
    run = sr.simulate(system, until=5.0, method=by, store_steps=True)
    found = sr.sensitivity(run, "pin.angle", ["f.factor"], error=True)
    exact = (1 - np.cos(np.sqrt(2 * 9.81 / 2.1) * 5.0)) / (2 * 9.81)
    error = abs(found.matrix[0, 0] - exact) / abs(found.matrix[0, 0])
    assert error > 0.1
    assert error / 10 < found.relative_errors[0] < 10 * error
    assert any(MESSAGE in one for one in found.warnings)


@WARNED
@pytest.mark.parametrize("length", [1.0, 1e6])
def test_a_vibration_beside_a_large_motion_is_known_in_any_unit(length: float) -> None:
    """A rod on a torsional spring, whose free angle changes together with the force that moves a body far away."""
    rod, body = (
        sr.Body(name, 1.0, (length**2,) * 3, position=(0, y * length, 0)) for name, y in (("a", 0), ("b", 5))
    )
    joints = [
        sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Translational("rail", sr.ground, body, point=(0, 5 * length, 0), axis=(1, 0, 0)),
    ]
    spring = sr.RSDA("spring", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1), k=100.0 * length**2)
    push = sr.PointForce("push", body.point(0, 0, 0), (1, 0, 0), factor=100.0 * length)
    run = sr.simulate(
        sr.System(sr.Model("beside", [rod, body], joints, [spring, push])), until=1.0, store_steps=True
    )

    def moved(d: Any) -> dict[str, Any]:
        return {"spring.angle": d["x"], "push.factor": 100.0 * length * (1 + d["x"])}

    found = sr.sensitivity(run, "pin.angle", design={"x": 0.0}, formula=moved, error=True)
    error = abs(found.matrix[0, 0] / (1 - np.cos(10.0)) - 1)
    assert 0.1 < error < found.relative_errors[0] < 4 * error
    assert any(MESSAGE in one for one in found.warnings)
