"""Every built-in implicit method has every derivative, over everything that a run can have.

Gradients forwards and backwards, Hessian products and Hessians, which are those of differenced gradients of runs with
the same steps.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.analyses.test_descriptions import METHODS
from tests.sensitivity import frozen, frozen_segments, test_curves, test_event_kinds
from tests.sensitivity import test_redundant_reactions as redundant
from tests.sensitivity.test_events import STOP, pendulum
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity.derivatives import differentiated
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.sampling.settled import settled
from sarrus.model.written import with_numbers

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*assembly changed"),  # states here are drawn roughly
    pytest.mark.filterwarnings("ignore:.*spline through the table"),  # of the force of `driven`
]
HIT = test_event_kinds.EVENTS["formula"]
RATES = {"pin": 1.5}


class Subject(NamedTuple):
    """A model, what is simulated, a response to it, and parameters with a direction."""

    system: Callable[[], sr.System]
    until: float
    response: Any
    direction: Mapping[str, float]
    event: sr.Event | None = None
    rates: Mapping[str, float] | None = None


SUBJECTS = {
    "smooth motion": Subject(
        slider_crank, 0.3, sr.Integral("energy.kinetic"), {"crank.mass": 0.1, "spring.k": 0.5, "gravity.z": 0.5}
    ),
    "reactions": Subject(slider_crank, 0.2, sr.Final("pin.force.z"), {"crank.mass": 0.1, "spring.k": 0.5}),
    "table values and formula constants": Subject(
        lambda: sr.System(test_curves.arm()), 0.4, sr.Final("tip.x"),
        {"motor.motion.2": 0.02, "motor.motion.3": 0.1, "load.factor.2.y": 0.2, "spring.k.2.y": 0.3},
    ),
    "given rates": Subject(
        slider_crank, 0.2, sr.Final("slider.x"), {"pin.axis.y": 0.02, "pin.point.z": 0.02, "rod.mass": 0.1}, None, RATES
    ),
    "impact": Subject(
        pendulum, 1.0, sr.Final("bob.x"), {"gravity.y": 0.3, "bob.angular_velocity.z": 0.1, "stop.restitution": 0.1},
        STOP,
    ),
    "impact of a mechanism": Subject(
        slider_crank, 0.4, sr.Integral("slider.x"), {"spring.k": 0.5, "rod.mass": 0.1, "hit.restitution": 0.1}, HIT
    ),
    "velocities by a function": Subject(
        slider_crank, 0.4, sr.Final("slider.x"), {"spring.k": 0.5, "rod.mass": 0.1},
        test_event_kinds.EVENTS["both functions"],
    ),
    "time of an event": Subject(
        slider_crank, 0.4, sr.AtEvent("t", event="hit"), {"spring.k": 0.5, "rod.mass": 0.1},
        test_event_kinds.EVENTS["function that ends"],
    ),
    "output at an event": Subject(
        slider_crank, 0.4, sr.AtEvent("slider.velocity.x", event="hit", after=True), {"spring.k": 0.5, "rod.mass": 0.1},
        HIT,
    ),
    "time-dependent motion after a stop": Subject(
        lambda: test_event_kinds.driven({}), 1.2, sr.Final("tip.x"),
        {"motor.motion.1": 0.02, "load.factor.3.y": 0.1, "tip.mass": 0.05, "stop.restitution": 0.05},
        test_event_kinds.ELBOW,
    ),
    "redundant reactions": Subject(
        lambda: redundant.subject("parallel_cranks").system, 0.2, sr.Final("foot_1.force.y"),
        {"coupler.mass": 0.1, "spring.k": 1.0, "gravity.y": 0.3},
    ),
}  # fmt: skip
every = pytest.mark.parametrize(("method", "name"), [(m, n) for m in METHODS for n in SUBJECTS])


@cache
def run(method: str, name: str) -> sr.Trajectory:
    one = SUBJECTS[name]
    system, more = one.system(), {"events": one.event} if one.event else {}
    start = sr.assemble(system, rates=one.rates) if one.rates else None
    found = sr.simulate(
        system,
        start,
        until=one.until,
        t_eval=[0.0, one.until],
        method=replace(METHODS[method], rtol=1e-5, atol=1e-7),
        **more,
        store="steps",
    )
    assert bool(found.events) == bool(one.event)
    if one.event:
        return frozen_segments.solved(found, METHODS[method], one.event)
    return replace(found, steps=frozen.again(system, found.steps, METHODS[method], {}, one.rates)[1])


def moved(method: str, name: str, e: float) -> tuple[sr.System, Any, Parameters]:
    """A run with other parameters and the same lengths of steps."""
    one, there, names = SUBJECTS[name], run(method, name), [*SUBJECTS[name].direction]
    at = Parameters(there.system, names, restitutions=there.restitutions).values
    numbers = {n: float(x + e * d) for (n, d), x in zip(one.direction.items(), at, strict=True)}
    struck, event = dict(there.restitutions), one.event
    for key in [*struck]:
        struck[key] = numbers.pop(key, struck[key])
        event = sr.Event(event.function, direction=event.direction, name=event.title,
                         reset=sr.Impact(struck[key], along=event.reset.along))  # fmt: skip
    if event is None:
        system, steps = frozen.again(there.system, there.steps, METHODS[method], numbers, one.rates)
    else:
        system = sr.System(with_numbers(there.system.model, numbers))
        steps = frozen_segments.again(system, there, METHODS[method], event)
    return system, steps, Parameters(system, names, start=steps.start, restitutions=struck)


def gradient(method: str, name: str, e: float) -> np.ndarray:
    """That of a run with other parameters and the same lengths of steps."""
    system, steps, parameters = moved(method, name, e)
    return differentiated(system, steps, [SUBJECTS[name].response], parameters).matrix[0]


def states(method: str, name: str, e: float) -> list[np.ndarray]:
    """q, v, a and λ of such a run, at the times of the run itself and of the same segments."""
    system, steps, _ = moved(method, name, e)
    then, now = (getattr(one, "segments", (one,)) for one in (run(method, name).steps, steps))
    times = np.split(run(method, name).steps.t, np.cumsum([len(segment.t) for segment in then])[:-1])
    found = [settled(system, segment, t) for segment, t in zip(now, times, strict=True)]
    return [np.concatenate([getattr(x, field) for x in found]) for field in ("q", "v", "a", "lam")]


@pytest.mark.one_in(32)
@every
def test_forward_and_backward_agree(method: str, name: str) -> None:
    one, names = SUBJECTS[name], [*SUBJECTS[name].direction]
    back, forward = (
        sr.sensitivity(run(method, name), one.response, names, method=way).matrix
        for way in ("adjoint", "direct")
    )
    assert np.all(np.isfinite(back))
    assert forward == pytest.approx(back, rel=0, abs=1e-8 * abs(back).max())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "name"), [(m, n) for m in METHODS for n in SUBJECTS if n != "redundant reactions"]
)
def test_hessians_are_those_of_differenced_gradients(method: str, name: str) -> None:
    one, there = SUBJECTS[name], run(method, name)
    found = sr.hessian(there, one.response, [*one.direction])
    product = sr.hessian_product(there, one.response, one.direction)
    assert found.asymmetry < 1e-8
    assert product == pytest.approx(
        found.matrix @ [*one.direction.values()], rel=0, abs=1e-10 * abs(product).max()
    )
    slopes = [(gradient(method, name, e) - gradient(method, name, -e)) / (2 * e) for e in (1e-2, 5e-3)]
    wanted = (4 * slopes[1] - slopes[0]) / 3
    assert product == pytest.approx(wanted, rel=0, abs=1e-6 * abs(wanted).max())


@pytest.mark.one_in(32)
@every
def test_derivatives_of_states_are_those_of_differenced_runs(method: str, name: str) -> None:
    """At fixed times, on both sides of events; but for the end that an event moves."""
    there, direction = run(method, name), SUBJECTS[name].direction
    found = sr.state_derivatives(there, [*direction])
    assert np.array_equal(found.t, there.steps.t)
    high, low, higher, lower = (states(method, name, e) for e in (1e-3, -1e-3, 5e-4, -5e-4))
    rows = slice(0, -1 if there.status == "event" else None)
    by = (
        found.q_b,
        found.v_b,
        found.a_b,
        found.lam_b,
    )  # λ is along axes f, g, which a moved axis chooses anew
    for n, derivative in enumerate(by[:3] if "pin.axis.y" in direction else by):
        coarse, fine = (high[n] - low[n]) / 2e-3, (higher[n] - lower[n]) / 1e-3
        along = derivative @ np.array([*direction.values()])
        assert along[rows] == pytest.approx(
            ((4 * fine - coarse) / 3)[rows], rel=0, abs=1e-5 * abs(along).max()
        )


@pytest.mark.one_in(32)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", [name for name, one in SUBJECTS.items() if one.event])
def test_derivatives_of_outputs_over_events_are_those_of_responses(method: str, name: str) -> None:
    there, names = run(method, name), [*SUBJECTS[name].direction]
    outputs = [f"{there.bodies[-1]}.{word}" for word in ("x", "velocity.y", "acceleration.x")]
    found, jumps = sr.state_derivatives(there, names), np.flatnonzero(np.diff(there.steps.t) == 0)
    rows = {0, 1, *(jumps - 1), *(jumps + 1), len(found.t) - 2, len(found.t) - 1} - {*jumps}
    responses = [sr.At(output, time=float(found.t[row])) for row in rows for output in outputs]
    every = sr.sensitivity(there, responses, names).matrix.reshape(len(rows), len(outputs), len(names))
    values = [found.output(output) for output in outputs]
    for row, wanted in zip(rows, every, strict=True):
        for value, one in zip(values, wanted, strict=True):
            assert value[row] == pytest.approx(one, rel=1e-8, abs=1e-8 * abs(wanted).max()), row


def test_restarted_designs_have_the_same_hessians() -> None:
    """Of a search, which simulates each design again."""
    one = SUBJECTS["impact"]
    names = [*one.direction]
    problem = sr.Problem(
        pendulum(), one.response, names, until=one.until, events=STOP, method=sr.Radau(rtol=1e-5, atol=1e-7),
    )  # fmt: skip
    direction = np.array([*one.direction.values()])
    wanted = sr.hessian_product(run("Radau", "impact"), one.response, one.direction)
    left = 1e-4 * abs(wanted).max()  # by Newton's method, whose steps are not the same
    assert problem.hvp(problem.x0, direction) == pytest.approx(wanted, abs=left)
