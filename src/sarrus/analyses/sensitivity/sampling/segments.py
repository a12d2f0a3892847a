"""Times of a run with events: the nodes of its segments, and where responses are sampled.

The steps of a segment have their lengths whatever happens: its nodes move in time with the event that it begins with,
τ_p, and only the last state, at the event that ends it, moves within its step. A state at a fixed time is met sooner
within a segment that begins later.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results import EventStep, Segments, StepsTaken


class NoSample(ValueError):
    """A run that does not have a time or an event at which a response is taken."""


def refuse_outside(times: Iterable[float], begin: float, end: float) -> None:
    """Refuse times [s] that are before the start of a run or after its end.

    Raises
    ------
    NoSample
    """
    round_off = 2e-12 * abs(end)  # steps begin just behind a jump at the start
    wrong = next((t for t in times if not begin - round_off <= t <= end + round_off), None)
    if wrong is not None:
        message = (
            f"times must be between {begin:g} and {end:g} s, the start and the end of the run, but one is"
        )
        raise NoSample(f"{message} {wrong:g} s. Give another time, or another end.")


class Instants(NamedTuple):
    """Times, the segments in which they lie, and how much of the change of the event at its end moves each.

    `part` is 0 at a node, 1 at the event itself, between them within the step that it ends; not a number for a time
    that is fixed.
    """

    t: Array
    segment: Array
    part: Array


class Course(NamedTuple):
    """The nodes of each segment of a run, the last one at the event that ends it, and these events."""

    t: Sequence[Array]
    event_steps: Sequence[EventStep]

    @property
    def ends(self) -> Array:
        """The time at which each segment ends [s]."""
        return np.array([t[-1] for t in self.t])

    @property
    def times(self) -> Array:
        """All nodes, segment after segment [s]."""
        return np.concatenate(self.t)


def course_of(steps: StepsTaken | Segments) -> Course:
    """Return the course of stored steps."""
    if not isinstance(steps, Segments):
        return Course([steps.t], ())
    ends = zip(steps.segments, steps.ends, strict=True)
    return Course([np.append(segment.t[:-1], end) for segment, end in ends], steps.event_steps)


def nodes_of(course: Course) -> Instants:
    """All nodes, the last of each segment at the event that ends it."""
    sizes = [len(t) for t in course.t]
    part = np.zeros(sum(sizes))
    part[np.cumsum(sizes) - 1] = 1.0
    return Instants(course.times, np.repeat(np.arange(len(sizes)), sizes), part)


def fixed(course: Course, times: Array) -> Instants:
    """Fixed times; the end of the run is its last state, wherever an event puts it."""
    t, ends = np.asarray(times, dtype=float), course.ends
    last = float(ends[-1])
    refuse_outside(t, course.t[0][0], last)
    segment = np.searchsorted(ends[:-1], t, side="right")
    return Instants(t, segment, np.where(t >= last, 1.0, np.nan))


def at_event(course: Course, name: str, number: int, after: bool) -> Instants:
    """Just before or just after an event, the n-th of its name.

    Raises
    ------
    NoSample
    """
    named = [(p, event_step.name) for p, event_step in enumerate(course.event_steps) if event_step.named]
    own = [p for p, known in named if known == name]
    if not 1 <= number <= len(own):
        known = ", ".join(dict.fromkeys(known for _, known in named)) or "none"
        raise NoSample(
            f"the run has {len(own)} events {name!r} that change velocities or end it, not {number}; it has {known}"
        )
    p = own[number - 1]
    if after and p == len(course.t) - 1:
        raise NoSample(f"the run ends with the event {name!r}: nothing is after it")
    return Instants(course.ends[[p]], np.array([p + after]), np.array([0.0 if after else 1.0]))
