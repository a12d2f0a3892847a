"""Shortest path from one point to another around a circle or sphere, or through a ring: its length and directions.

The points are p and q, relative to the centre, in the plane of the circle; for a sphere, this is the plane through its
centre. With |p| = d₁, t₁ = √(d₁² - r²), β₁ = atan(t₁/r), and the same for q, a path with the angle α on the circle
has the length

    t₁ + t₂ + r α,    α = θ - β₁ - β₂  or  2π - θ - β₁ - β₂,

for the shorter and the longer way around, θ being the angle between p and q. The path is straight where it does not
reach the circle. A path through a ring touches it from inside, at the point that divides θ into ψ₁ and ψ₂ and where the
path is reflected,

    ψ = i - asin(r/d sin i),    ψ₁ + ψ₂ = θ,

with the same angle of incidence i on both sides. Because the length is stationary, its derivatives to p and q are the
directions of the path at its ends.
"""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

from ....algebra import Array, cross
from ....functions import atan2, cos, nearest, positive, sin, sqrt

TINY = 1e-60  # [m⁴, m²] keeps derivatives finite where a length is zero
FINENESS = 2.0**30  # of the cotangents at which Newton's method is continued with derivatives
STEPS = 5, 2  # of Newton's method: up to 1e-8 from any start, and two more, exact up to third derivatives


class Way(NamedTuple):
    """A path: its length, and its directions at the first and at the last point."""

    length: Any
    first: Array
    last: Array

    def where(self, chosen: Any, other: Way) -> Way:
        """Return this path where `chosen` is 1, and the other where it is 0."""
        return Way(*(chosen * a + (1 - chosen) * b for a, b in zip(self, other, strict=True)))


class Corner(NamedTuple):
    """The points p and q about the centre of a circle, with all that both kinds of paths need.

    Attributes
    ----------
    n
        The unit normal of the plane, about which q is less than half a revolution ahead of p.
    angle
        θ.
    squares, tangents
        d² and t of both, replaced by others where a point is in the circle.
    reached
        1 where both are outside of the circle, else 0.
    turn
        θ - β₁ - β₂: positive where the straight line meets the circle.
    """

    p: Array
    q: Array
    n: Array
    angle: Any
    radius: Any
    squares: tuple[Any, Any]
    tangents: tuple[Any, Any]
    reached: Any
    turn: Any

    @classmethod
    def of(cls, p: Array, q: Array, radius: Any, axis: Array | None = None) -> Corner:
        """Return the points p and q about a circle, whose axis also determines n where they are on opposite sides."""
        across = cross(p, q)
        if axis is None:
            size = sqrt(across @ across + TINY)
            n = across / size
        else:
            sense = 2 * positive(across @ axis) - 1
            size, n = sense * (across @ axis) + TINY**0.5, sense * axis
        outside = [positive(one @ one - radius * radius) for one in (p, q)]
        squares = [
            o * (one @ one) + (1 - o) * (2 * radius * radius) for o, one in zip(outside, (p, q), strict=True)
        ]
        t = [sqrt(square - radius * radius) for square in squares]
        angle = atan2(size, p @ q)
        turn = angle - atan2(t[0], radius) - atan2(t[1], radius)
        return cls(
            p, q, n, angle, radius, (squares[0], squares[1]), (t[0], t[1]),
            outside[0] * outside[1], turn,
        )  # fmt: skip

    def straight(self) -> Way:
        """Return the straight path."""
        d = self.q - self.p
        length = sqrt(d @ d + TINY)
        return Way(length, d / length, d / length)

    def around(self, side: Array | None = None) -> Way:
        """Return the path around the circle, straight where this is possible.

        Parameters
        ----------
        side
            The path goes around the centre the same way as the straight lines from p to this point and on to q; without
            it, the shorter way.
        """
        longer = 0 if side is None else self._is_longer(side)
        touches = 1 - (1 - positive(self.turn)) * (1 - longer)
        return self._turned(1 - 2 * longer).where(self.reached * touches, self.straight())

    def through(self) -> Way:
        """Return the path through the ring, straight where the straight line passes through it."""
        ratios = [self.radius / sqrt(square) for square in self.squares]
        cotangent = self._cotangent(ratios)
        psi = _part(ratios[0], cotangent)
        e = self.p / sqrt(self.p @ self.p + TINY)
        touch = self.radius * (cos(psi) * e + sin(psi) * cross(self.n, e))
        first, last = touch - self.p, self.q - touch
        lengths = [sqrt(d @ d + TINY) for d in (first, last)]
        bent = Way(lengths[0] + lengths[1], first / lengths[0], last / lengths[1])
        return bent.where(self.reached * (1 - positive(self.turn)), self.straight())

    def _turned(self, sense: Any) -> Way:
        """The path around the circle, the shorter (1) or the longer (-1) way."""
        (square_p, square_q), (t_p, t_q) = self.squares, self.tangents
        turn = self.turn + (1 - sense) * (pi - self.angle)
        m = sense * self.n
        first = (self.radius * cross(m, self.p) - t_p * self.p) / square_p
        last = (self.radius * cross(m, self.q) + t_q * self.q) / square_q
        return Way(t_p + t_q + self.radius * turn, first, last)

    def _is_longer(self, side: Array) -> Any:
        """1 where the centre is in the triangle of p, q and a point, which makes the way by this point longer."""
        return positive(-(cross(side, self.q) @ self.n)) * positive(-(cross(self.p, side) @ self.n))

    def _cotangent(self, ratios: list[Any]) -> Any:
        """The cotangent of the angle of incidence, which is exact for equal ratios without iteration.

        The number is rounded before the last steps of Newton's method, which makes it a constant: the derivatives of
        the first steps would be those of the start. These of the last two are those of the solution.
        """
        half = self.angle / 2
        found = (cos(half) - (ratios[0] + ratios[1]) / 2) / sin(half)
        for steps in STEPS:
            found = nearest(found * FINENESS) / FINENESS if steps == STEPS[-1] else found
            for _ in range(steps):
                excess = sum(_part(ratio, found) for ratio in ratios) - self.angle
                found = found - excess / sum(_part_slope(ratio, found) for ratio in ratios)
        return found


def _part(ratio: Any, cotangent: Any) -> Any:
    """ψ for r/d and the cotangent of i."""
    sine = ratio / sqrt(1 + cotangent * cotangent)
    return atan2(1, cotangent) - atan2(sine, sqrt(1 - sine * sine))


def _part_slope(ratio: Any, cotangent: Any) -> Any:
    """The derivative of ψ to the cotangent of i."""
    square = 1 + cotangent * cotangent
    return (ratio * cotangent / sqrt(square - ratio * ratio) - 1) / square
