"""States of a run with events at given times, and at its nodes; events move the nodes that follow.

The steps of a segment have their lengths whatever happens: its nodes move in time with the event that it begins with,
τ_p, and only the last state, at the event that ends it, moves within its step. A state at a fixed time is met sooner
within a segment that begins later.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....outputs.recording import Angles, Key
from ....results import EventStep, Segments, StepsTaken
from ....system import System
from ..chain.chain import Nodes
from .sampling import HIGH, NoSample, Sampling, Span, by_kind, refuse_outside

LOW = 3  # nodes of a polynomial in time for accelerations and multipliers, of methods of order two


class Instants(NamedTuple):
    """Times, the segments in which they lie, and how much of the change of the event at its end moves each.

    `part` is 0 at a node, 1 at the event itself, between them within the step that it ends; not a number for a time
    that is fixed.
    """

    t: Array
    segment: Array
    part: Array


class SegmentSampling(Sampling):
    """The states at some times of a run with events."""

    moves = True

    def __init__(self, steps: Segments, where: Instants) -> None:
        self._all, self._steps = steps, steps.segments[0]
        self._times, self._segment, self._part = where

    @property
    def t(self) -> Array:
        """The times (nt,). [s]"""
        return np.asarray(self._times)

    @property
    def segment(self) -> Array:
        """The segments in which they lie (nt,)."""
        return self._segment

    @property
    def between_nodes(self) -> Array:
        """Return which times are between nodes, also after a change of event times (nt,)."""
        return np.asarray(super().between_nodes | self._local.any(axis=1))

    def _raw(self, name: str) -> Array:
        return self._all.nodes(name)

    def _remembered(self) -> Array:
        pairs = ((segment.memory, segment.memory[-1:]) for segment in self._all.segments)
        return np.concatenate([rows for pair in pairs for rows in pair])

    @property
    def _spans(self) -> Iterator[Span]:
        """The times in each segment."""
        for p, (segment, begin) in enumerate(zip(self._all.segments, self._all.first, strict=True)):
            yield Span(self._segment == p, begin, segment.t)

    @cached_property
    def _local(self) -> Array:
        """Return the change of each time within its segment by the events (nt, segments + 1)."""
        found = np.zeros((len(self.t), len(self._all.segments) + 1))
        rows, fixed = np.arange(len(self.t)), np.isnan(self._part)
        found[rows, self._segment] -= np.where(fixed, 1.0, self._part)
        found[rows, self._segment + 1] += np.where(fixed, 0.0, self._part)
        return found

    @cached_property
    def _global(self) -> Array:
        """Return the change of the times by the events."""
        found, fixed = self._local.copy(), np.isnan(self._part)
        found[np.arange(len(self.t)), self._segment] += 1.0
        found[fixed] = 0.0
        return found

    @property
    def _width(self) -> int:
        """The nodes of a polynomial in time, so many that its slope is good, too."""
        return LOW if self._apart else HIGH

    def _within(self, kind: str, places: Array, order: int, nodes: Nodes | None = None) -> Array:
        """A derivative of coordinates within their step, or of their change with that of the nodes (nt, places)."""

        def at(name: str) -> Array:
            return self._array(name)[:, places] if nodes is None else getattr(nodes, name)[:, places, 0]

        return np.asarray(sum(own @ at(name) for name, own in self._map(kind, order).items()))

    def spread(self, kind: str, places: Array, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradients by some coordinates of a kind, to those by the nodes and by the times of the events."""
        super().spread(kind, places, bar, nodes, column)
        nodes.shift[:, column] += self._local.T @ np.sum(bar * self._within(kind, places, 1), axis=1)

    def spread_along(self, bars: Mapping[Key, Array], dots: Nodes, nodes: Nodes) -> None:
        """Add the changes of gradients, given at the times, by nodes that change as times move in their steps."""
        moved = (self._local @ dots.shift[:, 0])[:, None]
        for kind, (places, bar) in by_kind(bars).items():
            for name, own in self._map(kind, 1).items():
                getattr(nodes, name)[:, places, 0] += own.T @ (bar * moved)
            bend = self._within(kind, places, 1, dots) + self._within(kind, places, 2) * moved
            nodes.shift[:, 0] += self._local.T @ np.sum(bar * bend, axis=1)

    def gathered(self, kind: str, places: Array, nodes: Nodes, column: int) -> Array:
        """The changes of some coordinates of a kind: the transpose of `spread`."""
        moved = self._within(kind, places, 1) * (self._local @ nodes.shift[:, column])[:, None]
        return np.asarray(super().gathered(kind, places, nodes, column) + moved)

    def spread_time(self, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by the times themselves."""
        nodes.shift[:, column] += self._global.T @ bar

    def gathered_time(self, nodes: Nodes, column: int) -> Array:
        """The change of the times."""
        return np.asarray(self._global @ nodes.shift[:, column])


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


def within(course: Course, parts: Sequence[float] | Array = (0.0,)) -> Instants:
    """All steps at these parts, and the ends of segments.

    Such an end occurs as often as there are parts, as a step of no length; that of the run occurs once.
    """
    found, last, shares = list[Instants](), len(course.t) - 1, np.array(parts)
    for p, t in enumerate(course.t):
        inner = t[:-1, None] + np.diff(t)[:, None] * shares
        part = np.zeros(inner.shape)
        part[-1] = shares
        ends = len(parts) if p < last else 1
        at = np.append(inner, np.full(ends, t[-1]))
        found.append(Instants(at, np.full(len(at), p), np.append(part, np.ones(ends))))
    return Instants._make(np.concatenate(x) for x in zip(*found, strict=True))


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
    NotThere
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


def sampling_of(steps: StepsTaken | Segments) -> Sampling:
    """All nodes of a run with or without events."""
    return (
        SegmentSampling(steps, within(course_of(steps))) if isinstance(steps, Segments) else Sampling(steps)
    )


def angles_of(system: System, steps: StepsTaken | Segments) -> Angles:
    """The joints' coordinates along a run, with the revolutions that it started with."""
    joints, start = system.joint_coordinates, steps.start
    first = joints.with_revolutions(joints.Phi(start.q), start.revolutions)
    return Angles(system, sampling_of(steps).states, lambda: first)
