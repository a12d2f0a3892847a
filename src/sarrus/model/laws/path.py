"""The quintic spline through points of a plane, over the length of the lines between them.

Derivatives by the points are exact: lengths move with the points, and with them the knots of the spline. Its
coefficients are computed in arithmetic of any kind, and refer to knots that are plain numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import Any, NamedTuple, TypeAlias

from ...functions import sqrt
from ..tape import value_of
from .curve import Cubic, Curve

Pair: TypeAlias = tuple[Any, Any]
# y''' h³ and y'''' h⁴ at the begin and at the end of a piece, as sums of Δ, Σ and Γ, see `_piece`
BEGIN_3, BEGIN_4, END_3, END_4 = (60, -24, 3), (-360, 168, -24), (60, -36, 9), (360, -192, 36)


class Quintic(NamedTuple):
    """A piecewise quintic y(u): its terms up to the third power about the knots, and the factors of the others."""

    cubic: Curve
    fourth: Curve
    fifth: Curve

    def offset(self) -> Curve:
        """The distance from the last knot as a function of u."""
        return _curve(self.cubic.knots, [(0.0, 0.0, 1.0, 0.0)] * len(self.cubic.cubics))

    def second(self) -> Curve:
        """The second derivative of the terms up to the third power, as a curve whose own derivatives exist."""
        return _curve(self.cubic.knots, [(0.0, 0.0, 6 * c3, 2 * c2) for c3, c2, _, _ in self.cubic.cubics])


def lengths(points: Sequence[Sequence[Any]]) -> list[Any]:
    """The length of the lines up to each point."""
    return [
        0.0,
        *accumulate(sqrt((c - a) * (c - a) + (d - b) * (d - b)) for (a, b), (c, d) in pairwise(points)),
    ]


def spline(u: Sequence[Any], y: Sequence[Any]) -> Quintic:
    """The quintic spline y(u), continued by straight lines.

    It is four times continuously differentiable between the ends, and three times at them, where y'' = y''' = 0.
    """
    h, at = [b - a for a, b in pairwise(u)], _slopes_and_bends(u, y)
    (first, _), (last, _) = at[0], at[-1]
    knots = [u[0] - value_of(h[0]), *u, u[-1] + value_of(h[-1])]
    straight = [0.0] * 4
    pieces = [
        [*straight, first, y[0] + first * (knots[0] - u[0])],
        *(_piece(*one) for one in zip(h, pairwise(y), pairwise(at), strict=True)),
        [*straight, last, y[-1]],
    ]
    numbers = tuple(float(value_of(knot)) for knot in knots)
    shifted = [
        _shifted(piece, number - knot) for piece, number, knot in zip(pieces, numbers, knots, strict=False)
    ]
    fifth, fourth = (_curve(numbers, [(0.0, 0.0, 0.0, piece[n]) for piece in shifted]) for n in (0, 1))
    return Quintic(_curve(numbers, [(c3, c2, c1, c0) for _, _, c3, c2, c1, c0 in shifted]), fourth, fifth)


def _curve(knots: tuple[float, ...], cubics: Sequence[Cubic]) -> Curve:
    """A term of a quintic, which jumps at knots where the quintic does not."""
    return Curve(knots, tuple(cubics), passed=True)


def _piece(h: Any, y: Pair, at: tuple[Pair, Pair]) -> list[Any]:
    """The coefficients c5 to c0 of the quintic with values y, and slopes and second derivatives at both ends."""
    (y0, y1), ((s0, m0), (s1, m1)) = y, at
    delta, sigma, gamma = y1 - y0 - h * (s0 + h * m0 / 2), h * (s1 - s0 - h * m0), h * h * (m1 - m0)
    fifth, fourth = 6 * delta - 3 * sigma + gamma / 2, -15 * delta + 7 * sigma - gamma
    third, cube = 10 * delta - 4 * sigma + gamma / 2, h * h * h
    return [fifth / (cube * h * h), fourth / (cube * h), third / cube, m0 / 2, s0, y0]


def _shifted(coefficients: Sequence[Any], shift: Any) -> list[Any]:
    """The coefficients of a polynomial about a knot that is further by a shift, by Horner's scheme."""
    found = [*coefficients]
    for end in range(len(found), 1, -1):
        for k in range(1, end):
            found[k] = found[k] + found[k - 1] * shift
    return found


def _slopes_and_bends(u: Sequence[Any], y: Sequence[Any]) -> list[Pair]:
    """The slope s and the second derivative m at each knot.

    By elimination of pairs (s, m): y'''' and y''' are continuous at knots, where these are the largest factors of s and
    of m, and y''' = m = 0 at the ends.
    """
    h = [b - a for a, b in pairwise(u)]
    eliminated: list[
        tuple[list[Pair], Pair]
    ] = []  # Q by columns and P of (s, m) = P - Q (s, m) at the next knot
    for k in range(len(u)):
        first, second = [0] * 7, [0] * 7  # factors of s and m at three knots, and what their sum is
        if 0 < k < len(h):
            for row, begin, end, power in ((first, BEGIN_4, END_4, 4), (second, BEGIN_3, END_3, 3)):
                _add(row, 0, end, h[k - 1], y[k] - y[k - 1], 1 / h[k - 1] ** power)
                _add(row, 2, begin, h[k], y[k + 1] - y[k], -1 / h[k] ** power)
        else:
            n = min(k, len(h) - 1)
            _add(first, 0 if k else 2, END_3 if k else BEGIN_3, h[n], y[n + 1] - y[n], 1)
            second[3] = 1
        for row in (first, second) if k else ():
            (q_s, q_m), P = eliminated[-1]
            row[2:] = [
                row[2] - row[0] * q_s[0] - row[1] * q_s[1],
                row[3] - row[0] * q_m[0] - row[1] * q_m[1],
                *row[4:6],
                row[6] - row[0] * P[0] - row[1] * P[1],
            ]
        (a, b, *of_first), (c, d, *of_second) = first[2:], second[2:]
        unit = a * d - b * c
        q_s, q_m, P = (
            ((d * x - b * z) / unit, (a * z - c * x) / unit) for x, z in zip(of_first, of_second, strict=True)
        )
        eliminated.append(([q_s, q_m], P))
    found: list[Pair] = [eliminated[-1][1]]
    for (q_s, q_m), P in eliminated[-2::-1]:
        s, m = found[-1]
        found.append((P[0] - q_s[0] * s - q_m[0] * m, P[1] - q_s[1] * s - q_m[1] * m))
    return found[::-1]


def _add(row: list[Any], first: int, factors: tuple[int, int, int], h: Any, rise: Any, weight: Any) -> None:
    """Add a derivative at an end of a piece, times a weight, to an equation of the pairs at both ends of the piece."""
    of_delta, of_sigma, of_gamma = (weight * factor for factor in factors)
    row[first] -= h * (of_delta + of_sigma)
    row[first + 1] -= h * h * (of_delta / 2 + of_sigma + of_gamma)
    row[first + 2] += h * of_sigma
    row[first + 3] += h * h * of_gamma
    row[6] -= of_delta * rise
