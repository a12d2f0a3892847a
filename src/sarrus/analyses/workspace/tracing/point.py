"""A point of a candidate curve with all that is watched along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....algebra import Array
from .newton import Tally, Tangent, tangent
from .stratum import Linear, Stratum


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
        """The tangent."""
        return self.tangent.t

    @property
    def speed(self) -> float:
        """The speed of the outputs, with a sign that changes at cusps."""
        return float(self.c[0] * self.u_s[1] - self.c[1] * self.u_s[0])


def point_at(stratum: Stratum, x: Array, linear: Linear, along: Array, tally: Tally) -> Point:
    """The point with its tangent along a direction."""
    return point_with(stratum, x, linear, tangent(stratum, x, linear, along, tally), tally)


def point_with(stratum: Stratum, x: Array, linear: Linear, found: Tangent, tally: Tally) -> Point:
    """The point with a tangent that is known."""
    p, n = stratum.problem, stratum.n
    outputs, limited = p.m + p.outputs, p.m + p.limited
    U, alpha = linear.J[outputs], found.t[:n]
    bends = linear.J @ found.turn[:n] + p.second_along(x[:n], alpha)
    inward = np.array([1.0, -1.0])
    tally.points += 1
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
