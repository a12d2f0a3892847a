"""A point of a candidate curve with all that is watched along it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ....algebra import Array
from .stratum import Stratum, Tangent, Tangents, tangent


@dataclass(frozen=True)
class Point:
    """A point of a curve.

    Attributes
    ----------
    x : unknowns of its stratum
    tangent : of the curve, by its arc length s
    u, u_s, u_ss : outputs (k,) with derivatives by s, free of units
    c : normal to the outputs' curve
    margins, margins_s, margins_ss : of the limits (count, 2) and their derivatives by s
    """

    x: Array
    tangent: Tangent
    u: Array
    u_s: Array
    u_ss: Array
    margins: Array
    margins_s: Array
    margins_ss: Array
    c: Array

    @property
    def t(self) -> Array:
        return self.tangent.t

    @property
    def speed(self) -> float:
        """The speed of the outputs, with a sign that changes at cusps."""
        return float(self.c[0] * self.u_s[1] - self.c[1] * self.u_s[0])


def point_at(stratum: Stratum, x: Array, linear: Tangents, along: Array) -> Point:
    """The point with its tangent along a direction."""
    return point_with(stratum, x, linear, tangent(stratum, x, linear, along))


def point_with(stratum: Stratum, x: Array, linear: Tangents, found: Tangent) -> Point:
    """The point with a tangent that is known."""
    p, n = stratum.problem, stratum.n
    outputs, limited = p.m + p.outputs, p.m + p.limited
    U, alpha = linear.J[outputs], found.t[:n]
    bends = linear.J @ found.turn[:n] + p.second_along(x[:n], alpha)
    inward = np.array([1.0, -1.0])
    return Point(
        x,
        found,
        linear.values[outputs],
        U @ alpha,
        bends[outputs],
        p.margins(linear.values),
        (linear.J[limited] @ alpha)[:, None] * inward,
        bends[limited][:, None] * inward,
        x[n + stratum.count :],
    )


class Step:
    """Two neighbouring points of a curve.

    Attributes
    ----------
    a, b : the points
    length : distance of b from a along a's tangent
    """

    def __init__(self, a: Point, b: Point) -> None:
        self.a, self.b = a, b
        self.length = float(a.t @ (b.x - a.x))
        self._rate = float(a.t @ b.t)
        self._bend = float(a.t @ b.tangent.turn)

    def quintic(self) -> Array:
        """Coefficients (6, 2) of the outputs as a polynomial in tau = 0 ... 1."""
        a, b = self.a, self.b
        return self._between((a.u, a.u_s, a.u_ss), (b.u, b.u_s, b.u_ss))

    def doubt(self) -> float:
        """How far the outputs' quintic is from a cubic in the middle: much where the bend changes quickly."""
        low = self.cubic(self.a.u, self.a.u_s, self.b.u, self.b.u_s)
        return float(np.linalg.norm(0.5 ** np.arange(6) @ self.quintic() - 0.5 ** np.arange(4) @ low))

    def margins(self) -> Array:
        """Coefficients (6, count, 2) of the limits' margins."""
        a, b = self.a, self.b
        return self._between((a.margins, a.margins_s, a.margins_ss), (b.margins, b.margins_s, b.margins_ss))

    def unknowns(self) -> Array:
        """Coefficients (6, size) of all unknowns."""
        a, b = self.a, self.b
        return self._between((a.x, a.t, a.tangent.turn), (b.x, b.t, b.tangent.turn))

    def x(self, tau: float) -> Array:
        """The unknowns in between, nearly."""
        return np.asarray(tau ** np.arange(6) @ self.unknowns())

    def _between(self, a: tuple[Array, Array, Array], b: tuple[Array, Array, Array]) -> Array:
        """Coefficients (6, ...) of the quintic through a function's values with their two derivatives by arc length.

        Second derivatives that are not known, where curves cross, are those of a polynomial of lower degree.
        """
        h, rate = self.length, self._rate
        f, f1, f2 = a[0], h * a[1], h * h * a[2]
        g, g1, g2 = b[0], h * b[1] / rate, h * h * (b[2] * rate - b[1] * self._bend) / rate**3
        d = g - f
        if not self.a.tangent.bends and not self.b.tangent.bends:
            f2, g2 = 6 * d - 4 * f1 - 2 * g1, 2 * f1 + 4 * g1 - 6 * d
        elif not self.a.tangent.bends:
            f2 = 12 * d - 6 * f1 - 6 * g1 + g2
        elif not self.b.tangent.bends:
            g2 = 6 * f1 + 6 * g1 + f2 - 12 * d
        d, e, c = d - f1 - 0.5 * f2, g1 - f1 - f2, g2 - f2
        last = (10 * d - 4 * e + 0.5 * c, -15 * d + 7 * e - c, 6 * d - 3 * e + 0.5 * c)
        return np.array([f, f1, 0.5 * f2, *last])

    def cubic(self, f_a: Array, f_a_s: Array, f_b: Array, f_b_s: Array) -> Array:
        """Coefficients (4, ...) of a function whose values and derivatives by arc length are known."""
        h = self.length
        first, last = h * f_a_s, h * f_b_s / self._rate
        d = f_b - f_a
        return np.array([f_a, first, 3 * d - 2 * first - last, -2 * d + first + last])


@cache
def gauss(count: int = 8) -> tuple[Array, Array]:
    """Nodes and weights on 0 ... 1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (nodes + 1), 0.5 * weights
