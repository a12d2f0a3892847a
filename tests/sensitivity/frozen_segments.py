"""Runs with events simulated once more with the same lengths of steps: what their derivatives are compared with."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq
from tests.sensitivity.frozen import values

import sarrus as sr
from sarrus.analyses.dynamics.dense_output.sampler import Sampler
from sarrus.analyses.dynamics.events.events import Watch
from sarrus.analyses.dynamics.integrators.differentiable import differentiable
from sarrus.analyses.dynamics.stepping.nodes import Nodes
from sarrus.analyses.dynamics.stepping.stepper import Settings
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances
from sarrus.results import Segments, StepsTaken


def taken_again(system: sr.System, steps: StepsTaken, method: object, t: float, q: object, v: object):
    """The steps of one segment from another state and time on, with all that interpolation and events need."""
    tolerances = Tolerances.of(system, steps.rtol, steps.atol)
    begin = replace(sr.assemble(system), q=q, v=v)
    stepper = differentiable(method).stepper(
        system, begin, Settings(tolerances, store_steps=True, given=steps.h)
    )
    end = t + float(np.sum(steps.h))
    stepper.restart(t, q, v, end)
    while len(stepper.steps()) < len(steps):
        stepper.advance(end, len(steps) - len(stepper.steps()))
    return stepper


def struck(
    system: sr.System, stepper: object, event: sr.Event
) -> tuple[float, np.ndarray, np.ndarray, object]:
    """The event within the last step: its time, the state before, and that from which the motion goes on."""
    steps = stepper.steps()
    memory = np.concatenate([steps.memory[-1:], steps.memory[-1:]])
    nodes = Nodes(*(getattr(steps, name)[-2:] for name in ("t", "q", "v", "a", "lam")), memory)
    sampler = Sampler(system, stepper.independence, stepper.b, stepper.host, stepper.apart)
    watch = Watch(system, event)

    def value(t: float) -> float:
        state = sampler.states(nodes, np.array([t]))
        return float(watch.function(t, state.q[0], state.v[0]))

    h = nodes.t[1] - nodes.t[0]
    t = brentq(value, nodes.t[0] - h, nodes.t[1] + h, xtol=1e-15, rtol=1e-15)  # or where the step would go on
    state = sampler.states(nodes, np.array([t]))
    q, v = state.q[0], state.v[0]
    after = watch.after(t, q, v, sampler)
    return t, q, v, (after, sampler.state_at(t, q, after, memory[0]))


def again(system: sr.System, run: sr.Trajectory, method: object, event: sr.Event) -> Segments:
    """The run of another system, with the same lengths of steps between its events."""
    start, segments, turns, old = sr.assemble(system), [], [], run.steps
    t, q, v = 0.0, start.q, start.v
    for p, segment in enumerate(old.segments):
        stepper = taken_again(system, segment, method, t, q, v)
        segments.append(stepper.steps())
        if p < len(old.event_steps):
            t, q_e, v_e, (after, state) = struck(system, stepper, event)
            e = getattr(event.reset, "restitution", None)
            turns.append(replace(old.event_steps[p], t=t, q=q_e, v=v_e, after=after, restitution=e))
            q, v = state.q[0], state.v[0]
    ended = len(old.event_steps) == len(old.segments)
    segments[0] = replace(segments[0], start=start)
    return Segments(segments=tuple(segments), event_steps=tuple(turns), until=t if ended else old.until)


def solved(run: sr.Trajectory, method: object, event: sr.Event) -> sr.Trajectory:
    """The run with its steps solved to round-off, as those taken again are."""
    return replace(run, steps=again(run.system, run, method, event))


def differenced(
    run: sr.Trajectory, responses: Sequence[object], method: object, size: float,
    moved: Callable[[float], tuple[sr.System, sr.Event]],
) -> np.ndarray:  # fmt: skip
    """Richardson's extrapolation of central differences of whole simulations (r,); `moved` by a change of a number."""

    def slope(e: float) -> np.ndarray:
        there = [at(run, responses, method, moved(d)) for d in (e, -e)]
        return (there[0] - there[1]) / (2 * e)

    return (4 * slope(size / 2) - slope(size)) / 3


def at(run: sr.Trajectory, responses: Sequence[object], method: object, moved: tuple[sr.System, sr.Event]):
    """Responses of a changed run."""
    system, event = moved
    return values(system, again(system, run, method, event), responses)
