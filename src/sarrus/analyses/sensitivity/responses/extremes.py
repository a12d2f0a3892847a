"""Extremes of a sampled output: where its polynomial is stationary, or a corner at a kink."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from ....algebra import Array
from ....model.tape import Tape, Tracer
from .panels import EPS, Layout


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
    """Extreme of a polynomial through samples, one sample, or the corner at a kink.

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
    real = roots[roots.imag == 0].real
    with np.errstate(divide="ignore", invalid="ignore"):  # at double roots, which are no extremes
        for _ in range(2):  # they have few digits where the leading coefficient almost vanishes
            real = real - of(real) / of.deriv()(real)
    return [x for x in real.tolist() if low < x < high]
