"""Panels of a run, with the samples of an output in each: the steps, or the parts of steps between its kinks.

`np.abs`, `np.maximum`, `np.minimum`, `np.clip` are absolute values of something (`model.tape`), which notes them. A
step is split where such an argument has another sign at the next sample. The kink moves with the design, but as the
output is continuous, the integral does not change with its place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ..sampling.segments import Course, Instants

# [-] of a step: the first inner point of Lobatto's rule, as far from the start as the other from the end. There the
# polynomial that has q, v and a at both ends of a step has accelerations of one order more than elsewhere
INNER = 0.5 - 0.5 / np.sqrt(5)
EPS = float(np.finfo(float).eps)
SAME = float(np.sqrt(EPS))  # [-] of a step: an integral changes with the square of a kink's error
# Lobatto's rule: relative positions of the samples of a panel, [-] of its length
PARTS = np.array([0.0, INNER, 1 - INNER, 1.0])
# and the weights of four; of both ends, where a result has no states between them
SHARES = {4: np.array([1, 5, 5, 1]) / 12, 2: np.array([0.5, 0.5])}
ABOUT = 0.5 - 0.5 * np.cos(np.pi * np.arange(9) / 8)  # Chebyshev's, of a panel beside an extreme


class Steps(NamedTuple):
    """All steps of a run: begin and end [s], the segment between events, whether an event moves their end."""

    begin: Array
    end: Array
    segment: Array
    last: Array

    @classmethod
    def of(cls, course: Course) -> Steps:
        begin, end = (np.concatenate([t[part] for t in course.t]) for part in (slice(-1), slice(1, None)))
        counts = [len(t) - 1 for t in course.t]
        segment = np.repeat(np.arange(len(counts)), counts)
        return cls(begin, end, segment, np.append(np.diff(segment) > 0, True))

    def where(self, step: Array, part: Array) -> Instants:
        """Times within them, at parts of their lengths."""
        begin, end = self.begin[step], self.end[step]
        t = np.where(part == 1, end, begin + part * (end - begin))
        return Instants(t, self.segment[step], np.where(self.last[step], part, 0.0))

    def about(self, sample: int) -> Panels:
        """The panels from a sample of all steps to those before and behind it, in its segment."""
        step, n = divmod(sample, len(PARTS))
        found = [(step, PARTS[k], PARTS[k + 1]) for k in (n - 1, n) if 0 <= k < len(PARTS) - 1]
        if n == 0 and step and self.segment[step - 1] == self.segment[step]:
            found.insert(0, (step - 1, PARTS[-2], PARTS[-1]))
        if n == len(PARTS) - 1 and step + 1 < len(self.end) and self.segment[step + 1] == self.segment[step]:
            found.append((step + 1, PARTS[0], PARTS[1]))
        return Panels(*map(np.array, zip(*found, strict=True)))


class Panels(NamedTuple):
    """Panels in the order of time: their steps, and the parts of these at which they begin and end (panels,)."""

    step: Array
    low: Array
    high: Array

    @classmethod
    def some(cls, chosen: slice) -> Panels:
        """Some steps."""
        step = np.arange(chosen.start, chosen.stop)
        return cls(step, np.zeros(len(step)), np.ones(len(step)))

    def halves(self) -> Panels:
        middle = 0.5 * (self.low + self.high)
        ends = (np.column_stack(x).ravel() for x in ([self.low, middle], [middle, self.high]))
        return Panels(np.repeat(self.step, 2), *ends)

    def where(self, steps: Steps, parts: Array = PARTS) -> Instants:
        """Samples at these parts of each panel."""
        part = self.low[:, None] + (self.high - self.low)[:, None] * parts
        part[:, parts == 1] = self.high[:, None]  # not low + (high - low)
        return steps.where(np.repeat(self.step, len(parts)), part.ravel())


class Layout(NamedTuple):
    """Samples of an output in panels, one after another; where two panels meet, both have a sample.

    Attributes
    ----------
    joints : (kinks,) the last sample before each kink
    size : samples of a panel
    """

    joints: Array = np.zeros(0, np.int64)
    size: int = len(PARTS)

    def weights(self, t: Array) -> Array:
        """The weights of the samples in an integral over time (nt,)."""
        ends = t.reshape(-1, self.size)[:, [0, -1]]
        return np.outer(ends[:, 1] - ends[:, 0], SHARES[self.size]).ravel()

    def by_times(self, g: Array) -> Array:
        """The derivatives by the times of the integral of an output (nt,)."""
        means = g.reshape(-1, self.size) @ SHARES[self.size]
        found = np.zeros((len(means), self.size))
        found[:, 0], found[:, -1] = -means, means
        return found.ravel()


Arguments = Callable[[Instants], Sequence[Array]]


def between_kinks(
    steps: Steps, panels: Panels, values: Sequence[Array], parts: Array, arguments: Arguments
) -> Panels:
    """Panels split where an argument of an absolute value has another sign at the next sample.

    Parameters
    ----------
    values : of all arguments at samples of the panels
    parts : of a panel, where they are
    arguments : their values anywhere
    """
    x = np.reshape(values, (len(values), -1, len(parts)))
    kink, panel, n = np.nonzero((x[..., 1:] > 0) != (x[..., :-1] > 0))
    if not len(panel):
        return panels
    step, low, h = panels.step[panel], panels.low[panel], (panels.high - panels.low)[panel]
    rows = np.arange(len(step))

    def at(part: Array) -> Array:
        return np.array(arguments(steps.where(step, part)))[kink, rows]

    ends = low + h * parts[n], low + h * parts[n + 1]
    part = _roots(at, *ends, x[kink, panel, n], x[kink, panel, n + 1])
    every = np.arange(len(panels.step))
    panel, part = np.concatenate([every, panel, every]), np.concatenate([panels.low, part, panels.high])
    order = np.lexsort((part, panel))
    panel, part = panel[order], part[order]
    whole = (panel[1:] == panel[:-1]) & (np.diff(part) > SAME)
    return Panels(panels.step[panel[:-1]][whole], part[:-1][whole], part[1:][whole])


def _roots(of: Callable[[Array], Array], low: Array, high: Array, at_low: Array, at_high: Array) -> Array:
    """The roots of functions between points where their signs differ, all at once, by the Illinois method."""
    root, before = 0.5 * (low + high), low
    while np.any(abs(root - before) > SAME):
        before, root = root, (low * at_high - high * at_low) / (at_high - at_low)
        here = of(root)
        same = (here > 0) == (at_high > 0)
        low, at_low = np.where(same, low, high), np.where(same, 0.5 * at_low, at_high)
        high, at_high = root, here
    return root
