"""Methods of users: their orders, closed forms, events, dense output, redundant constraints, refusals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.analyses.test_descriptions import OWN
from tests.prescribed_steps import run_of
from tests.sensitivity.frozen import solved
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.integrators.alpha import HHT, generalized_alpha
from sarrus.analyses.dynamics.integrators.differentiable import differentiable
from sarrus.analyses.dynamics.methods.collocation import radau
from sarrus.analyses.dynamics.methods.leading_error import leading_errors
from sarrus.analyses.dynamics.stepping.stepper import Settings
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances

MIDPOINT, BDF2 = (method.description for method in OWN.values())
K, C, MASS = 40.0, 0.6, 2.0
A = np.array([[0.0, 1.0], [-K / MASS, -C / MASS]])  # of (x, x')
every = pytest.mark.parametrize("method", OWN.values(), ids=OWN)


def oscillator() -> sr.System:
    mass = sr.Body("mass", mass=MASS, inertia=(1, 1, 1), position=(1.3, 0, 0), velocity=(0.2, 0, 0))
    slide = sr.Translational("slide", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), mass.point(0, 0, 0), k=K, c=C, length=1.0)
    return sr.System(sr.Model("oscillator", bodies=[mass], joints=[slide], forces=[spring]))


def pendulum() -> sr.System:
    rod = sr.Body("rod", mass=2.0, inertia=(0.01, 1 / 6, 1 / 6), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("pendulum", bodies=[rod], joints=[pin], gravity=(0, -9.81, 0)))


def prescribed(system: sr.System, method: Any, h: Any) -> Any:
    """The steps of a run with steps of these lengths."""
    ends = np.array([0.0, np.sum(h)])
    run = run_of(
        differentiable(method),
        system,
        sr.assemble(system),
        ends,
        rtol=1e-6,
        atol=1e-8,
        store_steps=True,
        given=np.asarray(h),
    )
    assert run.success, run.message
    return run.steps


def midpoint(y: Any, h: float, before: Any, ratio: float) -> Any:
    one = np.eye(2)
    return np.linalg.solve(one - h / 2 * A, (one + h / 2 * A) @ y)


def bdf2(y: Any, h: float, before: Any, ratio: float) -> Any:
    """In the form of textbooks: y₁ - (1 + ω)²/(1 + 2 ω) y₀ + ω²/(1 + 2 ω) y₋₁ = (1 + ω)/(1 + 2 ω) h f₁."""
    w, divisor = ratio, 1 + 2 * ratio
    right = ((1 + w) ** 2 * y - w**2 * before) / divisor
    return np.linalg.solve(np.eye(2) - (1 + w) / divisor * h * A, right)


@pytest.mark.parametrize(("method", "recurrence"), [(MIDPOINT, midpoint), (BDF2, bdf2)], ids=OWN)
def test_steps_are_those_of_the_closed_recurrence(method: Any, recurrence: Callable[..., Any]) -> None:
    """Of a linear oscillator, with steps of unequal lengths; BDF2 begins with a step before along v₀ and a₀."""
    h = 0.03 * (1 + 0.5 * np.sin(np.arange(40)))
    steps = prescribed(oscillator(), method, h)
    y = np.array([0.3, 0.2])
    before = y - h[0] * (A @ y)
    for n, length in enumerate(h):
        y, before = recurrence(y, length, before, length / h[n - 1] if n else 1.0), y
        assert np.allclose([steps.q[n + 1, 0] - 1.0, steps.v[n + 1, 0]], y, rtol=0, atol=1e-11), n


@every
def test_equal_and_unequal_steps_have_order_two(method: Any) -> None:
    """Errors of positions, velocities and multipliers of a slider-crank, against Radau with 1e-12."""
    system = slider_crank()
    exact = sr.simulate(system, until=0.3, t_eval=[0.3], method=sr.Radau(rtol=1e-12, atol=1e-13))
    for pattern in (np.ones(2), np.array([0.7, 1.3])):
        errors = []
        for count in (60, 120, 240):
            steps = prescribed(system, method, np.tile(pattern * 0.3 / count, count // 2))
            wanted = exact.q[0], exact.v[0], exact.lam[0]
            errors.append(
                [abs(x[-1] - y).max() for x, y in zip((steps.q, steps.v, steps.lam), wanted, strict=True)]
            )
        slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
        assert np.all(abs(slopes - 2) < 0.15), slopes


@every
def test_errors_follow_the_tolerance(method: Any) -> None:
    system = slider_crank()
    exact = sr.simulate(system, until=0.5, t_eval=[0.2, 0.5], method=sr.Radau(rtol=1e-10, atol=1e-12))
    for tolerance in (1e-4, 1e-6):
        run = sr.simulate(
            system,
            until=0.5,
            t_eval=[0.2, 0.5],
            method=replace(method, rtol=tolerance, atol=0.01 * tolerance),
        )
        assert run.success
        assert abs(run.q - exact.q).max() < 20 * tolerance**0.9
        assert run.violation.max() < 1e-12


@every
def test_events_and_dense_output(method: Any) -> None:
    """A rod that falls against a stop: times of impacts and states in between are those of Radau."""
    stop = sr.Event("rod.x", direction=-1, reset=sr.Impact(0.6), name="stop")
    settings = {"until": 2.0, "events": stop, "store": "dense"}
    run = sr.simulate(pendulum(), method=replace(method, rtol=1e-7, atol=1e-9), **settings)
    exact = sr.simulate(pendulum(), method=sr.Radau(rtol=1e-10, atol=1e-12), **settings)
    assert len(run.events) == len(exact.events) == 2
    assert [e.t for e in run.events] == pytest.approx([e.t for e in exact.events], abs=5e-5)
    t = np.linspace(0, 2, 101)
    assert abs(run.sol(t).q - exact.sol(t).q).max() < 2e-4


def test_the_implicit_midpoint_rule_keeps_the_energy() -> None:
    """Over 60 swings, with equal steps: without an error, all are the longest."""
    equal = replace(MIDPOINT, error=sr.Estimate(2, 0.0, lambda h, ratio: {}))
    run = sr.simulate(
        pendulum(), until=100.0, method=sr.DescribedMethod(equal, first_step=0.05, max_step=0.05)
    )
    damped = sr.simulate(pendulum(), until=100.0, method=sr.HHT(step=0.05))
    assert run.nsteps == damped.nsteps == 2000
    energy, lost = run.total_energy, damped.total_energy
    assert abs(energy[-200:].mean() - energy[:200].mean()) < 0.002
    assert lost[-200:].mean() - lost[:200].mean() < -1.0


@every
def test_redundant_constraints_are_left_out(method: Any) -> None:
    """A rod on two coaxial pins moves as on one."""
    rod = sr.Body("rod", mass=2.0, inertia=(0.01, 1 / 6, 1 / 6), position=(0.5, 0, 0))
    pins = [sr.Revolute(f"pin_{n}", sr.ground, rod, point=(0, 0, 0.1 * n), axis=(0, 0, 1)) for n in range(2)]
    twice = sr.System(sr.Model("twice", bodies=[rod], joints=pins, gravity=(0, -9.81, 0)))
    h = np.full(50, 0.01)
    one, two = (prescribed(system, method, h) for system in (pendulum(), twice))
    assert np.allclose(one.q, two.q, rtol=0, atol=1e-9)
    gradients = []
    for system in (pendulum(), twice):
        run = sr.simulate(system, until=0.5, method=replace(method, rtol=1e-8, atol=1e-8), store="steps")
        gradients.append(sr.sensitivity(run, sr.Final("rod.y"), ["rod.inertia.zz", "gravity.y"]).matrix)
    assert np.allclose(*gradients, rtol=1e-5)


@every
def test_going_on_from_a_saved_state_gives_the_same_bits(method: Any) -> None:
    system = slider_crank()
    start, settings = sr.assemble(system), Settings(Tolerances.of(system, 1e-6, 1e-8))
    first, second = (differentiable(method).stepper(system, start, settings) for _ in range(2))
    first.restart(0.0, start.q, start.v, 2.0)
    first.advance(2.0, 40)
    second.resume({name: np.array(value) for name, value in first.state().items()})
    ahead, again = (stepper.advance(2.0, 40) for stepper in (first, second))
    assert len(ahead.t) == 41
    assert all(np.array_equal(x, y) for x, y in zip(ahead, again, strict=True))


@pytest.mark.parametrize(
    ("described", "method"),
    [(generalized_alpha(*HHT().scheme()), sr.HHT()), (radau(3), sr.Radau())],
    ids=["HHT", "Radau"],
)
def test_descriptions_of_the_built_in_methods_run_as_these(described: sr.Description, method: Any) -> None:
    """With the same lengths of steps their states are the same to what Newton's method leaves."""
    system = slider_crank()
    steps = solved(
        sr.simulate(
            system, until=0.3, t_eval=[0.3], method=replace(method, rtol=1e-6, atol=1e-8), store="steps"
        ),
        method,
    ).steps
    again = prescribed(system, described, steps.h)
    assert np.allclose(again.q, steps.q, rtol=0, atol=1e-10)
    assert np.allclose(again.v, steps.v, rtol=0, atol=1e-9)
    assert np.allclose(again.lam, steps.lam, rtol=0, atol=1e-6 * abs(steps.lam).max())


@pytest.mark.parametrize("stages", [1, 2, 3])
def test_the_leading_error_of_radau_methods_is_known(stages: int) -> None:
    """R(z) - e^z = C z^2s + ... of the subdiagonal Padé approximation, C = (-1)^s s! (s-1)! / ((2s-1)! (2s)!)."""
    from math import factorial as f

    first, later = leading_errors(replace(radau(stages), error=None))
    wanted = f(stages) * f(stages - 1) / (f(2 * stages - 1) * f(2 * stages))
    assert first.exponent == later.exponent == 2 * stages
    assert later.constant == pytest.approx(wanted, rel=0.02)


def wrong(**changes: Any) -> sr.Description:
    return replace(MIDPOINT, **changes)


def stepped(change: Callable[[Any], Any]) -> Callable[[Any, Any], Any]:
    return lambda h, ratio: change(MIDPOINT.step(h, ratio))


@pytest.mark.parametrize(
    ("method", "kind", "message"),
    [
        (wrong(step=stepped(lambda s: None)), TypeError, "step must return a sarrus.Step, got NoneType"),
        (wrong(step=stepped(lambda s: s._replace(equations=s.equations[:3]))), ValueError, "Give as many of both"),
        (wrong(step=stepped(lambda s: s._replace(update={"q": s.update["q"]}))), ValueError, "the update has no v"),
        (wrong(unknowns={**MIDPOINT.unknowns, "Q": "nq"}), ValueError, 'Give "coordinates" or "constraints"'),
        (wrong(extra={"old": {"v": 1.0}}), ValueError, "the update has no old"),
        (
            wrong(step=stepped(lambda s: s._replace(update={**s.update, "v": {"q": 1.0}}))),
            ValueError, "the method does not converge",
        ),
        (
            wrong(step=stepped(lambda s: s._replace(update={**s.update, "v": {"W": 1.0}}))),
            ValueError, "uses W, which is no block. Choose from q, v",
        ),
        (wrong(step=lambda h, ratio: MIDPOINT.step(h if h > 0 else -h, ratio)), TypeError, "must not branch"),
    ],
)  # fmt: skip
def test_wrong_descriptions_are_refused(method: sr.Description, kind: type, message: str) -> None:
    with pytest.raises(kind, match=message):
        sr.simulate(pendulum(), until=0.1, method=method)
