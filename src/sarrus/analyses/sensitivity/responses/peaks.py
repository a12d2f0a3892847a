"""Extremes of a sampled output: where its polynomial is stationary, a corner at a kink, and a mean of all peaks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from ....algebra import Array
from ....model.tape import Tape, Tracer
from .panels import EPS, Layout

# Of the mean of peaks, over the range of the output: 0.28 / SHARPNESS is its largest deviation
SHARPNESS = 1000.0
# Of the range below the highest sample: peaks farther below it weigh exp(-100), whatever their sag
NEAR = 0.1


class Extreme:
    """An extreme value, recorded as a function of some samples of an output, and of their times."""

    _value: Tracer

    def __init__(self, g: Array, t: Array) -> None:
        self._tape, self._count = Tape(), len(g)
        self._g, self._t = ([self._tape.variable(float(x)) for x in row] for row in (g, t))

    def derivatives(self) -> Array:
        """Return the derivatives by the outputs and by the times (2, samples)."""
        return self._by_samples(self._tape.gradient({self._value.at: 1.0}))

    def change(self, dots: Array) -> Array:
        """Their change with changes of the outputs and of the times (2, samples)."""
        along = self._tape.along(dict(enumerate(dots.ravel().tolist())))
        return self._by_samples(self._tape.gradient_along({self._value.at: 1.0}, {}, along)[1])

    def _by_samples(self, found: Sequence[Any]) -> Array:
        return np.array(found[: 2 * self._count]).reshape(2, self._count)


class Parabola(Extreme):
    """The value at the vertex of a parabola through three samples.

    Attributes
    ----------
    slopes : at the samples
    """

    def __init__(self, g: Array, t: Array) -> None:
        super().__init__(g, t)
        (g0, g1, g2), (t0, t1, t2) = self._g, self._t
        a, c = t0 - t1, t2 - t1
        first, middle, last = g0 / (a * (a - c)), g1 / (a * c), g2 / (c * (c - a))
        bend = 2 * (first + middle + last)
        slope = -(first * c + middle * (a + c) + last * a)  # at the middle sample
        self.is_straight = not bend.value
        self.slopes = tuple(float((slope + bend * (t - t1)).value) for t in self._t)
        if not self.is_straight:
            self._value = g1 - slope * slope / (2 * bend)


class StationaryValue(Extreme):
    """The value of the polynomial through some samples where its slope is zero, which is at a `time` now.

    One step of Newton's method from there, whose first and second derivatives are those of the extreme.
    """

    def __init__(self, g: Array, t: Array, time: float) -> None:
        super().__init__(g, t)
        value, slope, half_bend = _taylor(self._g, self._t, time)
        self._value = value - slope * slope / (4 * half_bend)


def _taylor(g: Array | Sequence[Any], t: Array | Sequence[Any], time: float) -> tuple[Any, Any, Any]:
    """The value, the slope and half of the second derivative of the polynomial through some samples at a time."""
    known = list(g)  # divided differences
    for order in range(1, len(known)):
        for k in range(len(known) - 1, order - 1, -1):
            known[k] = (known[k] - known[k - 1]) / (t[k] - t[k - order])
    value, slope, half_bend = known[-1], 0.0 * known[-1], 0.0 * known[-1]
    for one, x in zip(known[-2::-1], t[-2::-1], strict=True):
        half_bend = half_bend * (time - x) + slope
        slope, value = slope * (time - x) + value, value * (time - x) + one
    return value, slope, half_bend


class Corner(Extreme):
    """The value where the polynomials through the samples on both sides of a kink intersect, which is at a `time` now.

    A mean of both whose slope is zero there is that value to the third order, at a time that is right to the second.
    As many samples are of the side before the kink as of that behind it.
    """

    def __init__(self, g: Array, t: Array, time: float) -> None:
        super().__init__(g, t)
        count = len(g) // 2
        sides = [(self._g[side], self._t[side]) for side in (slice(count), slice(count, None))]
        (before, left, _), (behind, right, _) = (_taylor(*side, time) for side in sides)
        left, right = float(left.value), float(right.value)
        later = time + (before - behind) / (right - left)
        before, behind = (_taylor(*side, later)[0] for side in sides)
        self._value = (right * before - left * behind) / (right - left)


class Vertex(NamedTuple):
    """Extreme of a parabola through three samples, one sample, or the corner at a kink.

    near : which samples
    basis, by_times : the derivatives of its value by them, and by their times
    recorded : None for one sample
    """

    near: slice
    basis: Array
    by_times: Array
    recorded: Extreme | None = None

    @classmethod
    def of(cls, extreme: Extreme, near: slice) -> Vertex:
        basis, by_times = extreme.derivatives()
        return cls(near, basis, by_times, extreme)

    def placed(self, values: Array, count: int) -> Array:
        """Zeros but for these samples (count,)."""
        whole = np.zeros(count)
        whole[self.near] = values
        return whole

    def moved(self, g_dot: Array, t_dot: Array) -> Array:
        """The changes of its derivatives with those of the output and of the times (nt,)."""
        if self.recorded is None:
            return np.zeros((2, len(self.basis)))
        return self.recorded.change(np.array([g_dot[self.near], t_dot[self.near]]))


class Top(NamedTuple):
    """Value of an extreme, its time, none if it is a sample, and the samples on which it depends."""

    value: float
    time: float | None
    near: slice
    is_corner: bool = False

    def vertex(self, g: Array, t: Array) -> Vertex:
        if self.time is None:
            return Vertex(self.near, np.ones(1), np.zeros(1))
        kind = Corner if self.is_corner else StationaryValue
        return Vertex.of(kind(g[self.near], t[self.near], self.time), self.near)


def top_of(g: Array, t: Array, sign: int, layout: Layout) -> Top:
    """The extreme of the polynomials through the samples of each panel, by the roots of their slopes; or at a kink.

    `sign` is 1 for a maximum, -1 for a minimum.
    """
    if not np.isfinite(g).all():
        return Top(np.nan, None, slice(0, 1))
    size, corners = layout.size, layout.joints.tolist()
    tops = [Top(float(g[n]), float(t[n]), slice(n + 1 - size, n + 1 + size), is_corner=True) for n in corners]
    for first in range(0, len(g), size):
        near, ends = slice(first, first + size), (first, first + size - 1)
        curve = Polynomial.fit(t[near], g[near], size - 1)
        bend = curve.deriv(2)
        roots = (x for x in _zeros(curve.deriv(), *t[[*ends]]) if sign * bend(x) < 0)
        tops += [Top(float(curve(x)), x, near) for x in roots]
        smooth = (n for n in ends if not {n, n - 1}.intersection(corners))
        tops += [Top(float(g[n]), None, slice(n, n + 1)) for n in smooth]
    return max(tops, key=lambda top: sign * top.value)


def _zeros(of: Polynomial, low: float, high: float) -> list[float]:
    """The real roots of a polynomial between two times, rising."""
    roots = of.trim(EPS * abs(of.coef).max()).roots()
    return [x for x in roots[roots.imag == 0].real.tolist() if low < x < high]


def vertex_of(g: Array, t: Array, n: int) -> Vertex:
    """The extreme about sample n; at an end, or beside an event, where a time occurs twice, on one side of it."""
    if parabola := _parabola(g, t, n):
        return Vertex.of(parabola, slice(n - 1, n + 2))
    return _beside(g, t, n)


def _parabola(g: Array, t: Array, n: int) -> Parabola | None:
    """The parabola through sample n and its neighbours, if all have different times."""
    if not (0 < n < len(g) - 1 and t[n - 1] < t[n] < t[n + 1]):
        return None
    parabola = Parabola(g[n - 1 : n + 2], t[n - 1 : n + 2])
    return None if parabola.is_straight else parabola


def _beside(g: Array, t: Array, n: int) -> Vertex:
    """The extreme between sample n, with which the output begins or ends, and the sample beside it; or sample n."""
    for inner, end in ((n - 1, 2), (n + 1, 0)):
        if (parabola := _parabola(g, t, inner)) and (g[n] - g[inner]) * parabola.slopes[end] * (end - 1) < 0:
            return Vertex.of(parabola, slice(inner - 1, inner + 2))
    return Vertex(slice(n, n + 1), np.ones(1), np.zeros(1))


class Peaks:
    """The mean of all peaks of an output, weighted with exp(s peak), s being `SHARPNESS` over the output's range."""

    def __init__(self, g: Array, t: Array) -> None:
        self._count, self._low = len(g), int(np.argmin(g))
        self.vertices, self._tape = _peaks(g, t), Tape()
        tops = [self._tape.variable(float(v.basis @ g[v.near])) for v in self.vertices]
        low = self._tape.variable(float(g[self._low]))
        self._at = [*(top.at for top in tops), low.at]
        self._mean = _mean(tops, low)

    @property
    def value(self) -> float:
        return float(self._mean.value)

    def weights(self) -> Array:
        """Its derivatives by the output (nt,)."""
        return self._spread(self._slopes)

    def by_times(self) -> Array:
        """Its derivatives by the times (nt,)."""
        pairs = zip(self._slopes, self.vertices, strict=False)
        return np.asarray(sum(slope * v.placed(v.by_times, self._count) for slope, v in pairs))

    def along(self, g_dot: Array, t_dot: Array) -> tuple[Array, Array]:
        """The changes of its derivatives by the output, and by the times, with those of both (nt,)."""
        moved = [float(v.basis @ g_dot[v.near] + v.by_times @ t_dot[v.near]) for v in self.vertices]
        dots = self._tape.along(dict(zip(self._at, [*moved, float(g_dot[self._low])], strict=True)))
        _, change = self._tape.gradient_along({self._mean.at: 1.0}, {}, dots)
        slope_dots = [float(change[n]) for n in self._at]
        by_output, by_times = self._spread(slope_dots), np.zeros(self._count)
        for slope, slope_dot, v in zip(self._slopes, slope_dots, self.vertices, strict=False):
            basis_dot, times_dot = v.moved(g_dot, t_dot)
            by_output[v.near] += slope * basis_dot
            by_times[v.near] += slope_dot * v.by_times + slope * times_dot
        return by_output, by_times

    @property
    def _slopes(self) -> list[float]:
        """The derivatives of the mean by the peaks, and by the least value."""
        found = self._tape.gradient({self._mean.at: 1.0})
        return [float(found[n]) for n in self._at]

    def _spread(self, slopes: list[float]) -> Array:
        """Derivatives by the peaks as those by the output."""
        found = np.zeros(self._count)
        found[self._low] = slopes[-1]
        for slope, vertex in zip(slopes, self.vertices, strict=False):
            found[vertex.near] += slope * vertex.basis
        return found


def _peaks(g: Array, t: Array) -> list[Vertex]:
    """Return the peaks that are not far below the highest sample."""
    rises = np.append(True, (np.diff(g) >= 0) | (np.diff(t) == 0))
    falls = np.append((np.diff(g) < 0) | (np.diff(t) == 0), True)
    high = g >= g.max() - NEAR * np.ptp(g)
    every = [vertex_of(g, t, int(n)) for n in np.flatnonzero(rises & falls & high)]
    return list({(v.near.start, v.near.stop): v for v in every}.values())


def _mean(tops: list[Tracer], low: Tracer) -> Tracer:
    highest = max(tops, key=lambda top: float(top.value))
    if not highest.value > low.value:
        return highest
    shares = [np.exp(SHARPNESS * (top - highest) / (highest - low)) for top in tops]
    total: Tracer = reduce(add, (w * top for w, top in zip(shares, tops, strict=True))) / reduce(add, shares)
    return total
