"""Errors by vibrations that the steps of a run do not resolve, against closed forms and an explicit integration."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.accuracy.test_error_estimates import stored
from tests.accuracy.test_stiff_steps import on_a_pendulum

import sarrus as sr
from sarrus.analyses.sensitivity.accuracy.lost_vibrations import lost_modes
from sarrus.analyses.sensitivity.combined import Outer
from sarrus.analyses.sensitivity.events.chains import chain_of
from sarrus.results import ErrorEstimate, StepsTaken

FORCE = 20.0
LOOSE = {"rtol": 1e-4, "store_steps": True}


def pushed(k: float, c: float, compressed: float = 0.0) -> sr.System:
    """Two masses of 1 kg on one rail, between them a stiff spring-damper, and a force on the first one."""
    places = {"first": 0.0, "second": 1.0}
    bodies = [sr.Body(name, 1.0, (1e-3,) * 3, position=(x, 0, 0)) for name, x in places.items()]
    rails = [
        sr.Translational(f"{own.name}_rail", sr.ground, own, point=(0, 0, 0), axis=(1, 0, 0))
        for own in bodies
    ]
    first, second = (own.point(0, 0, 0) for own in bodies)
    spring = sr.TSDA("spring", first, second, k=k, c=c, length=1.0 + compressed)
    return sr.System(sr.Model("pushed", bodies, rails, [spring, sr.PointForce("push", first, (FORCE, 0, 0))]))


def exact(k: float, c: float, t: float, rate: float = 0.0) -> dict[str, float]:
    """After t from rest, but for a rate of the spring's length."""
    omega, mean = np.sqrt(2 * k - c**2), -FORCE / (2 * k)
    cos, sin = np.exp(-c * t) * np.cos(omega * t), np.exp(-c * t) * np.sin(omega * t)
    part = (rate - c * mean) / omega
    stretch = mean - mean * cos + part * sin
    speed = (rate - 2 * c * mean) * cos + (omega * mean - c * part) * sin
    return {
        "second.x": 1 + FORCE * t**2 / 4 + stretch / 2,
        "second.velocity.x": FORCE * t / 2 + speed / 2,
        "spring.tension": k * stretch + c * speed,
    }


@pytest.mark.parametrize(("k", "c"), [(1e6, 0.0), (1e8, 1.0)])
def test_vibration_with_little_damping(k: float, c: float) -> None:
    """The method damps it at once. By the adjoint alone, errors were estimated a million times too small."""
    run, known = sr.simulate(pushed(k, c), until=1.0, **LOOSE), exact(k, c, 1.0)
    for found, value in zip(run.error([*known]), known.values(), strict=True):
        assert 0.3 < found.error / abs(found.value - value) < 5, found
        assert found.error > 1e4 * abs(found.estimate)


def test_vibration_by_a_method_of_order_two() -> None:
    """It damps the vibration from step to step: the velocity had an estimate of a sixtieth of the error."""
    run = sr.simulate(pushed(1e6, 0.0), until=1.0, method=sr.HHT(), store_steps=True)
    found = run.error("second.velocity.x")
    true = found.value - exact(1e6, 0.0, 1.0)["second.velocity.x"]
    assert 0.3 < found.error / abs(true) < 5, (found, true)


def test_vibration_that_has_decayed() -> None:
    """By e^-30 at the end, but by half at 0.02 s."""
    k, c = 1e8, 30.0
    run, name = sr.simulate(pushed(k, c), until=1.0, **LOOSE), "second.velocity.x"
    early, late = run.error([sr.At(name, time=0.0201), name])
    assert 0.3 < early.error / abs(early.value - exact(k, c, 0.0201)[name]) < 5
    assert late.vibrations < abs(late.estimate) < 1e-8
    assert late.value == pytest.approx(exact(k, c, 1.0)[name], abs=1e-8)


def test_vibration_of_a_run_with_checkpoints() -> None:
    system, name = pushed(1e6, 0.0), "second.velocity.x"
    whole = sr.simulate(system, until=1.0, **LOOSE).error(name)
    with pytest.warns(sr.SarrusWarning, match="derivatives have no correct digit"):
        long = sr.sensitivity_by_checkpoints(system, name, ["spring.k"], until=1.0, rtol=1e-4, error=True)
    assert long.errors[0].vibrations == pytest.approx(whole.vibrations, rel=1e-6)
    assert whole.vibrations > 1e-3


def test_motion_without_vibration() -> None:
    """The spring has the compression from the start that the force causes."""
    k = 1e8
    found = sr.simulate(pushed(k, 0.0, FORCE / (2 * k)), until=1.0, **LOOSE).error("second.velocity.x")
    assert (
        found.vibrations
        < 1e-3 * sr.simulate(pushed(k, 0.0), until=1.0, **LOOSE).error("second.velocity.x").vibrations
    )


def test_vibration_by_an_event() -> None:
    """The second mass becomes faster by 1 cm/s after 0.3 s, in a system that did not vibrate before."""
    k, rate = 1e8, 1e-2
    hit = sr.Event(lambda t, q, v: t - 0.3, reset=lambda t, q, v: v + rate * np.eye(len(v))[7])
    system = pushed(k, 0.0, FORCE / (2 * k))
    run = sr.simulate(system, until=0.5, events=hit, **LOOSE)
    found, omega = run.error("second.velocity.x"), np.sqrt(2 * k)
    true = found.value - (FORCE * 0.25 + rate / 2 + rate / 2 * np.cos(omega * 0.2))
    assert 0.3 < found.error / abs(true) < 5, (found, true)


def test_direction_that_turns() -> None:
    """A mass on a spring along a pendulum: estimates were down to 0.0005 of the errors."""
    k, c, t = 1e6, 1.0, 1.0

    def rates(_: float, y: np.ndarray) -> list[float]:
        r, angle, v, w = y
        radial = r * w * w - 9.81 * np.sin(angle) - k * (r - 1) - c * v
        return [v, w, radial, (-2 * r * v * w - 9.81 * np.cos(angle) * (0.5 + r)) / (0.36 + r * r)]

    r, angle, v, w = solve_ivp(rates, (0, t), [1, 0, 0, 3], "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    known = {
        "spring.length": r,
        "spring.tension": k * (r - 1) + c * v,
        "mass.velocity.x": v * np.cos(angle) - r * w * np.sin(angle),
        "pin.angle.rate": w,
    }
    run = sr.simulate(on_a_pendulum(k, c), until=t, **LOOSE)
    for found, value in zip(run.error([*known]), known.values(), strict=True):
        assert 0.3 < found.error / abs(found.value - value) < 5, found


def test_vibrations_of_a_combined_response() -> None:
    outer = Outer(sr.Combined(lambda x, y: 3 * x + 4 * y, [sr.Final("a.x"), sr.Final("b.x")], name="sum"))
    (found,) = outer.errors([ErrorEstimate(name, 1.0, 1e-9, 1e-9, 0.0, vibrations=1e-4) for name in "ab"])
    assert found.vibrations == pytest.approx(5e-4)
    assert found.error == found.vibrations
    assert found.digits == pytest.approx(np.log10(7 / 5e-4))


def launched() -> sr.System:
    """1 kg at rest in a field of 100 N that ends after some 0.01 m."""
    body = sr.Body("m", 1.0, (1e-3,) * 3)
    rail = sr.Translational("rail", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    force = sr.PointForce("field", body.point(0, 0, 0), force=("100*exp(-100*m.x)", 0, 0))
    return sr.System(sr.Model("launched", [body], [rail], [force]))


def test_stiffness_of_the_start_that_the_motion_leaves() -> None:
    """Later steps are longer than vibrations of the start would be, but there are none: x = ln(cosh(τ)²) w."""
    run, t = sr.simulate(launched(), until=3.0, store_steps=True), 3.0
    w, rate = 0.01, 0.5 * np.sqrt(2 * 100.0 * 0.01) / 0.01
    found = run.error(["m.x", "m.velocity.x"])
    exact = 2 * w * (rate * t - np.log(2.0)), 2 * w * rate
    for one, known in zip(found, exact, strict=True):
        assert 0.5 < one.error / abs(one.value - known) < 2, one


@pytest.mark.parametrize("memory", [2e5, 1e8])
def test_stiffness_that_the_motion_leaves_by_checkpoints(memory: float) -> None:
    long = sr.sensitivity_by_checkpoints(launched(), "m.x", ["m.mass"], until=3.0, memory=memory, error=True)
    assert long.errors[0].error < 1e-7


@pytest.mark.parametrize("first_step", [1e-5, 1e-7])
def test_round_off_of_a_short_first_step_is_no_vibration(first_step: float) -> None:
    """Two masses at rest on their spring: differences within the first step had errors of up to 0.8 m."""
    system = pushed(1e2, 0.0)
    calm = sr.System(sr.Model("calm", system.model.bodies, system.model.joints, system.model.forces[:1]))
    run = sr.simulate(calm, until=1.0, first_step=first_step, store_steps=True)
    assert run.error("second.x").error < 1e-8


def test_a_prescribed_motion_is_no_vibration() -> None:
    """Of a driven rotor beside a free body: its derivatives are those of the given angle. No stiffness is looked at."""
    run, _ = stored("driven rotor")

    def later() -> Iterator[StepsTaken]:
        raise AssertionError("its stiffness is asked for")
        yield

    assert lost_modes(chain_of(run.system, run.steps, {}), run.steps.t, later()) is None
