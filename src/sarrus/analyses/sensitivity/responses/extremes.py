"""Extremes of a sampled output: where its polynomial is stationary, or a corner at a kink."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from ....algebra import Array
from ..sampling.sampling import lagrange
from .panels import EPS, Layout


class Curve:
    """The polynomial through some samples of an output, about a time.

    Its derivative by a sample is the Lagrange polynomial l of it, and that by the sample's time is -l times the slope
    there.

    Attributes
    ----------
    shares, slope, bend : the Lagrange polynomials there (samples,), the slope and the second derivative
    slopes : at the samples (samples,)
    """

    def __init__(self, g: Array, t: Array, time: float) -> None:
        ahead = t - time
        self._D = lagrange(t - t[:, None])[1]
        self.shares, self._share_slopes = (x[0] for x in lagrange(ahead[None])[:2])
        self.slopes = self._D @ g
        self.slope, self.bend = float(self.shares @ self.slopes), float(self._share_slopes @ self.slopes)
        self._bends = self._D @ self.slopes

    def derivatives(self) -> Array:
        """Those of its value there by the samples and by their times (2, samples)."""
        return np.array([self.shares, -self.slopes * self.shares])

    def moved(self, dots: Array) -> tuple[float, float]:
        """The changes of the value and of the slope there, at the same time."""
        by_samples = dots[0] - self.slopes * dots[1]
        return float(self.shares @ by_samples), float(self._share_slopes @ by_samples)

    def change(self, dots: Array, time_dot: float) -> Array:
        """The change of the derivatives, where the time changes, too (2, samples)."""
        g_dot, t_dot = dots
        shares_dot = self._share_slopes * time_dot - (self.shares * t_dot) @ self._D
        slopes_dot = self._D @ (g_dot - self.slopes * t_dot) + self._bends * t_dot
        return np.array([shares_dot, -slopes_dot * self.shares - self.slopes * shares_dot])


class StationaryValue(Curve):
    """Of a polynomial whose slope is zero at a time."""

    def turned(self, dots: Array) -> Array:
        """The change of its derivatives with those of the samples and of their times (2, samples)."""
        return self.change(dots, -self.moved(dots)[1] / self.bend)


class Corner:
    """The value where the polynomials through the samples on both sides of a kink intersect, which is at a time.

    It is the mean of both whose slope is zero. As many samples are of the side before the kink as of that behind it.
    """

    def __init__(self, g: Array, t: Array, time: float) -> None:
        count = len(g) // 2
        self._sides = [Curve(g[side], t[side], time) for side in (slice(count), slice(count, None))]
        before, behind = self._sides
        steeper = behind.slope - before.slope
        self._parts = behind.slope / steeper, -before.slope / steeper

    def derivatives(self) -> Array:
        """Those of the value by the samples and by their times (2, samples)."""
        pairs = zip(self._parts, self._sides, strict=True)
        return np.concatenate([part * side.derivatives() for part, side in pairs], axis=1)

    def turned(self, dots: Array) -> Array:
        """Their change with those of the samples and of their times (2, samples)."""
        (before, behind), own = self._sides, np.split(dots, 2, axis=1)
        (left, left_dot), (right, right_dot) = (
            side.moved(x) for side, x in zip(self._sides, own, strict=True)
        )
        steeper = behind.slope - before.slope
        time_dot = (left - right) / steeper
        left_dot, right_dot = left_dot + before.bend * time_dot, right_dot + behind.bend * time_dot
        part_dot = (before.slope * right_dot - behind.slope * left_dot) / -(steeper**2)
        changes = zip(self._parts, (part_dot, -part_dot), self._sides, own, strict=True)
        parts = [dot * side.derivatives() + part * side.change(x, time_dot) for part, dot, side, x in changes]
        return np.concatenate(parts, axis=1)


class Vertex(NamedTuple):
    """Extreme of a polynomial through samples, one sample, or the corner at a kink.

    near : which samples
    basis, by_times : the derivatives of its value by them, and by their times
    of : None for one sample
    """

    near: slice
    basis: Array
    by_times: Array
    of: StationaryValue | Corner | None = None

    def placed(self, values: Array, count: int) -> Array:
        """Zeros but for these samples (count,)."""
        whole = np.zeros(count)
        whole[self.near] = values
        return whole

    def moved(self, g_dot: Array, t_dot: Array) -> Array:
        """The changes of its derivatives with those of the output and of the times (nt,)."""
        if self.of is None:
            return np.zeros((2, len(self.basis)))
        return self.of.turned(np.array([g_dot[self.near], t_dot[self.near]]))


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
        extreme = kind(g[self.near], t[self.near], self.time)
        basis, by_times = extreme.derivatives()
        return Vertex(self.near, basis, by_times, extreme)


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
