"""Extremes of a sampled output: the vertex of a parabola, a corner at a kink, and a mean of all peaks."""

from __future__ import annotations

from functools import reduce
from operator import add
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...model.laws.tape import Tape, Traced
from .panels import Panels
from .sampling import lagrange

SHARPNESS = (
    1000.0  # of the mean of peaks, over the range of the output: 0.28 / SHARPNESS is its largest deviation
)
NEAR = (
    0.1  # of the range below the highest sample: peaks farther below it weigh exp(-100), whatever their sag
)


class Vertex(NamedTuple):
    """Of a parabola through three samples, or one sample, or the corner between two samples at one time.

    near : which samples
    basis, slopes : their Lagrange polynomials and slopes at the vertex
    bend : the parabola's second derivative; 0 for others
    before : from each of them to the vertex [s]
    """

    near: slice
    basis: Array
    slopes: Array
    bend: float
    before: Array

    def placed(self, values: Array, count: int) -> Array:
        """Zeros but for these samples (count,)."""
        whole = np.zeros(count)
        whole[self.near] = values
        return whole

    @property
    def by_times(self) -> Array:
        """The derivatives of its value by the times of these samples."""
        return np.asarray(self.basis * self.bend * self.before)

    def moved(self, g_dot: Array) -> Array:
        """The change of the basis with that of the output (nt,)."""
        along = -(self.slopes @ g_dot[self.near]) / self.bend if self.bend else 0.0
        return np.asarray(along * self.slopes)


def vertex_of(g: Array, t: Array, n: int, panels: Panels | None = None) -> Vertex:
    """The extreme about sample n; sample n alone at an end, or beside an event, where a time stands twice."""
    if 0 < n < len(g) - 1 and t[n - 1] < t[n] < t[n + 1]:
        near = slice(n - 1, n + 2)
        a, c = (float(x) for x in t[[n - 1, n + 1]] - t[n])
        bend_of = 2 / np.array([a * (a - c), a * c, c * (c - a)])  # of the three polynomials
        slope_of = -0.5 * bend_of * np.array([c, a + c, a])  # at sample n
        bend, slope = float(bend_of @ g[near]), float(slope_of @ g[near])
        if bend:
            u = -slope / bend
            basis = np.array([0.0, 1.0, 0.0]) + slope_of * u + bend_of * u**2 / 2
            return Vertex(near, basis, slope_of + bend_of * u, bend, u - np.array([a, 0.0, c]))
    joint = next((k for k in (n, n - 1) if panels is not None and k in panels.joints), None)
    if panels is not None and joint is not None:
        return _corner(g, t, n, joint, panels)
    return _sample(n)


def _sample(n: int) -> Vertex:
    return Vertex(slice(n, n + 1), np.ones(1), np.zeros(1), 0.0, np.zeros(1))


def _corner(g: Array, t: Array, n: int, joint: int, panels: Panels) -> Vertex:
    """The extreme at a kink, where the output rises on one side and falls on the other.

    Its time moves, as the kink does: the mean of both sides whose slope is zero does not change with the time, so that
    its derivative at a fixed time is that of the extreme.
    """
    sides = panels.before(joint), panels.behind(joint)
    left, right = (float((lagrange((t[side] - t[joint])[None])[1] @ g[side])[0]) for side in sides)
    if not left * right < 0:
        return _sample(n)
    share = right / (right - left)
    return Vertex(slice(joint, joint + 2), np.array([share, 1 - share]), np.zeros(2), 0.0, np.zeros(2))


class Peaks:
    """The mean of all peaks of an output, weighted with exp(s peak), s being `SHARPNESS` over the output's range."""

    def __init__(self, g: Array, t: Array, panels: Panels | None) -> None:
        self._count, self._low = len(g), int(np.argmin(g))
        self._vertices, self._tape = _peaks(g, t, panels), Tape()
        tops = [self._tape.variable(float(v.basis @ g[v.near])) for v in self._vertices]
        low = self._tape.variable(float(g[self._low]))
        self._at = [*(top.at for top in tops), low.at]
        self._mean = _mean(tops, low)

    @property
    def value(self) -> float:
        """The mean."""
        return float(self._mean.value)

    def weights(self) -> Array:
        """Its derivatives by the output (nt,)."""
        return self._spread(self._slopes)

    def by_times(self) -> Array:
        """Its derivatives by the times (nt,)."""
        pairs = zip(self._slopes, self._vertices, strict=False)
        return np.asarray(sum(slope * v.placed(v.by_times, self._count) for slope, v in pairs))

    def weights_along(self, g_dot: Array) -> Array:
        """The change of its derivatives with that of the output (nt,)."""
        moved = [float(v.basis @ g_dot[v.near]) for v in self._vertices]
        dots = self._tape.along(dict(zip(self._at, [*moved, float(g_dot[self._low])], strict=True)))
        _, change = self._tape.gradient_along({self._mean.at: 1.0}, {}, dots)
        bases = zip(self._slopes, self._vertices, strict=False)
        turned = sum(slope * v.placed(v.moved(g_dot), self._count) for slope, v in bases)
        return np.asarray(self._spread([float(change[n]) for n in self._at]) + turned)

    @property
    def _slopes(self) -> list[float]:
        """The derivatives of the mean by the peaks, and by the least value."""
        found = self._tape.gradient({self._mean.at: 1.0})
        return [float(found[n]) for n in self._at]

    def _spread(self, slopes: list[float]) -> Array:
        """Derivatives by the peaks as those by the output."""
        found = np.zeros(self._count)
        found[self._low] = slopes[-1]
        for slope, vertex in zip(slopes, self._vertices, strict=False):
            found[vertex.near] += slope * vertex.basis
        return found


def _peaks(g: Array, t: Array, panels: Panels | None) -> list[Vertex]:
    """Those that are not far below the highest sample."""
    rises = np.append(True, (np.diff(g) >= 0) | (np.diff(t) == 0))
    falls = np.append((np.diff(g) < 0) | (np.diff(t) == 0), True)
    high = g >= g.max() - NEAR * np.ptp(g)
    every = [vertex_of(g, t, int(n), panels) for n in np.flatnonzero(rises & falls & high)]
    joints = set() if panels is None else {*panels.joints, *(panels.joints + 1)}
    found = {(v.near.start, v.near.stop): v for v in every if len(v.basis) > 1 or v.near.start not in joints}
    return list(found.values()) or [vertex_of(g, t, int(np.argmax(g)), panels)]


def _mean(tops: list[Traced], low: Traced) -> Traced:
    highest = max(tops, key=lambda top: float(top.value))
    if not highest.value > low.value:
        return highest
    shares = [np.exp(SHARPNESS * (top - highest) / (highest - low)) for top in tops]
    total: Traced = reduce(add, (w * top for w, top in zip(shares, tops, strict=True))) / reduce(add, shares)
    return total
