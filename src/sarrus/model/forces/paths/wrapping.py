"""Segment of a tendon from one point to another that wraps a sphere or a cylinder of a third body.

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

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from .... import functions
from ....algebra import Array, Row, cross
from ....elements.element import Scalar
from ....euler import B, E, rotate
from ....functions import atan2, cos, sin, sqrt
from ...errors import ModelError
from ...geometry.points import LocalPoint, Point
from ...geometry.pose import Poses
from ...measure import Direction, Length, Offset
from ...quantity import direction, positive, triple, vector
from ...signals import Measure

TINY = 1e-60  # [m²] keeps derivatives finite where a length is zero
PARALLEL = 1e-24  # square of the sine of the angle below which a plane is not determined by two directions
NEAR = 1e-6  # square of θ/(1 - r/d)² below which the point of the ring is found without the plane of p and q


class Detour(NamedTuple):
    """A path: its length, and its directions at the first and at the last point."""

    length: Any
    first: Array
    last: Array

    def where(self, chosen: Any, other: Detour) -> Detour:
        """Return this path where `chosen` is 1, and the other where it is 0."""
        return Detour(*(chosen * a + (1 - chosen) * b for a, b in zip(self, other, strict=True)))


class Corner(NamedTuple):
    """Two points about the centre of a circle or sphere, with all that both kinds of paths need.

    Attributes
    ----------
    p, q
        The points.
    flat
        Their positions in the plane of the circle: for a cylinder, without the parts along the axis.
    side
        The path goes around the centre the same way as the straight lines from p to this point and on to q; without it,
        the shorter way.
    rise
        The part of q - p along the axis of a cylinder.
    n
        The unit normal of the plane, about which q is at most half a revolution ahead of p.
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
    flat: list[Array]
    side: Array | None
    rise: Array | None
    n: Array
    angle: Any
    radius: Any
    squares: list[Any]
    tangents: list[Any]
    reached: Any
    turn: Any

    @classmethod
    def of(
        cls, p: Array, q: Array, radius: Any, side: Array | None = None, axis: Array | None = None
    ) -> Corner:
        """Return the points p and q about a sphere, or about a cylinder with a unit vector along its axis."""
        flat = [one if axis is None else one - (one @ axis) * axis for one in (p, q)]
        rise = None if axis is None else ((q - p) @ axis) * axis
        outside = [functions.positive(one @ one - radius * radius) for one in flat]
        reached = outside[0] * outside[1]
        squares = [
            o * (one @ one) + (1 - o) * (2 * radius * radius) for o, one in zip(outside, flat, strict=True)
        ]
        t = [sqrt(square - radius * radius) for square in squares]
        n = (
            _normal(flat[0], flat[1], side, reached)
            if axis is None
            else _sense(cross(flat[0], flat[1]) @ axis) * axis
        )
        sense = _sense(flat[0] @ flat[1])
        cosine = reached * sense * (flat[0] @ flat[1]) + 1 - reached
        angle = (1 - sense) * (pi / 2) + sense * atan2(cross(flat[0], flat[1]) @ n, cosine)
        turn = angle - atan2(t[0], radius) - atan2(t[1], radius)
        return cls(p, q, flat, side, rise, n, angle, radius, squares, t, reached, turn)

    def around(self) -> Detour:
        """Return the path around the circle, straight where this is possible."""
        longer = 0 if self.side is None else self._is_longer(self.side)
        touches = 1 - (1 - functions.positive(self.turn)) * (1 - longer)
        return self._path(self._turned(1 - 2 * longer), self.reached * touches)

    def _path(self, flat: Detour, bent: Any) -> Detour:
        """The path where it is bent: that in the plane, rising by the same amount for each length; else straight."""
        d = self.q - self.p
        length = sqrt(d @ d + TINY)
        straight = Detour(length, d / length, d / length)
        if self.rise is not None:
            run = bent * flat.length + (1 - bent) * self.radius
            length = sqrt(run * run + self.rise @ self.rise)
            flat = Detour(length, *((run * one + self.rise) / length for one in flat[1:]))
        return flat.where(bent, straight)

    def through(self) -> Detour:
        """Return the path through the ring, straight where the straight line passes through it."""
        bent = self.reached * (1 - functions.positive(self.turn))
        ratios = [self.radius / sqrt(square) for square in self.squares]
        e, f = (one / sqrt(square) for one, square in zip(self.flat, self.squares, strict=True))
        across, gap = cross(e, f), (1 - ratios[0]) * (1 - ratios[1])
        near = bent * functions.positive(NEAR * gap * gap - across @ across) * functions.positive(e @ f)
        psi = _part(ratios[0], self._cotangent(ratios, bent * (1 - near)))
        touch = self.radius * (
            near * _between(e, f, ratios, near) + (1 - near) * (cos(psi) * e + sin(psi) * cross(self.n, e))
        )
        first, last = touch - self.flat[0], self.flat[1] - touch
        lengths = [sqrt(d @ d + TINY) for d in (first, last)]
        return self._path(Detour(lengths[0] + lengths[1], first / lengths[0], last / lengths[1]), bent)

    def _turned(self, sense: Any) -> Detour:
        """The path around the circle, the shorter (1) or the longer (-1) way."""
        (square_p, square_q), (t_p, t_q) = self.squares, self.tangents
        turn = self.turn + (1 - sense) * (pi - self.angle)
        m = sense * self.n
        first = (self.radius * cross(m, self.flat[0]) - t_p * self.flat[0]) / square_p
        last = (self.radius * cross(m, self.flat[1]) + t_q * self.flat[1]) / square_q
        return Detour(t_p + t_q + self.radius * turn, first, last)

    def _is_longer(self, side: Array) -> Any:
        """1 where the centre is in the triangle of p, q and a point, which makes the way by this point longer."""
        return functions.positive(-(cross(side, self.flat[1]) @ self.n)) * functions.positive(
            -(cross(self.flat[0], side) @ self.n)
        )

    def _cotangent(self, ratios: list[Any], bent: Any) -> Any:
        """The cotangent of the angle of incidence, which is exact for equal ratios without iteration.

        Where the path is not bent, θ is replaced by another.
        """
        angle = bent * self.angle + (1 - bent) * (self.angle - self.turn) / 2
        start = (cos(angle / 2) - (ratios[0] + ratios[1]) / 2) / sin(angle / 2)
        return functions.root(lambda u: sum(_part(ratio, u) for ratio in ratios) - angle, start)


def _between(e: Array, f: Array, ratios: list[Any], near: Any) -> Array:
    """The direction of the point of the ring where the directions e and f of p and q are near each other.

    By the law of sines sin ψ₁/sin ψ₂ = λ₁/λ₂ with the distances λ of this point from p and q over d. The error is of
    the sixth order of θ, so that derivatives are exact where p and q are on one ray.
    """
    other = np.array([1.0, 0.0, 0.0])
    e, f = (near * one + (1 - near) * other for one in (e, f))
    found = e + f
    for _ in range(3):
        found = found / sqrt(found @ found)
        off = [one - near * ratio * found for one, ratio in zip((e, f), ratios, strict=True)]
        found = sqrt(off[1] @ off[1]) * e + sqrt(off[0] @ off[0]) * f
    touch: Array = found / sqrt(found @ found)
    return touch


def _sense(x: Any) -> Any:
    """-1 where x is negative, else 1."""
    return 1 - 2 * functions.positive(-x)


def _normal(p: Array, q: Array, side: Array | None, reached: Any) -> Array:
    """The unit normal of the plane of p and q, or of another plane through p where q is on the same line.

    That plane is the one of the side, which then decides the way, else one parallel to an axis of coordinates.
    """
    upright = functions.positive(p[0] * p[0] + p[1] * p[1] - p[2] * p[2])
    found = cross(p, np.array([1 - upright, 0, upright]))
    for other in (q,) if side is None else (side, q):
        across = cross(p, other)
        apart = functions.positive(across @ across - PARALLEL * (p @ p) * (other @ other))
        found = apart * across + (1 - apart) * found
    found = reached * found + (1 - reached) * np.array([1.0, 0.0, 0.0])
    normal: Array = found / sqrt(found @ found)
    return normal


def _part(ratio: Any, cotangent: Any) -> Any:
    """ψ for r/d and the cotangent of i."""
    sine = ratio / sqrt(1 + cotangent * cotangent)
    return atan2(1, cotangent) - atan2(sine, sqrt(1 - sine * sine))


Passage: TypeAlias = Literal["shorter", "side", "through", "moving"]


@dataclass(frozen=True, eq=False)
class Wrap:
    """A sphere or cylinder that a segment of a `Tendon` wraps without friction.

    Parameters
    ----------
    center
        The centre of the sphere, or a point on the axis of the cylinder.
    radius
        [m], greater than 0.
    axis
        Of the cylinder, in axes of the body of the centre; without it, the shape is a sphere. A cylinder has no ends.
    side
        A point of the same body, in body axes [m], or a `Point` of any body. Outside of the radius about the centre:
        the segment goes around the shape the same way as the straight lines from its first point to this one and on to
        its last point. Within: the segment passes through the shape, as through a ring. A point of another body decides
        at each instant. Without it, the segment goes the shorter way around.
    """

    center: Point
    radius: Length
    axis: Direction | None = None
    side: Offset | Point | None = None

    def measure(self, ends: tuple[Any, Any], poses: Poses) -> Measure:
        """Return the measure of a segment between two points, given by their bodies and coordinates."""
        center = self.center.resolve(poses, "around.center")
        radius = positive(self.radius, "radius", "Give it in m.")
        values: list[Any] = [*(one.s for one in ends), center.s, radius]
        passage: Passage = "shorter"
        if self.axis is not None:
            values.append(triple(direction(self.axis, "around.axis")))
        given = self.side.resolve(poses, "around.side") if isinstance(self.side, Point) else self.side
        bodies = [one.body for one in (*ends, center)]
        if isinstance(given, LocalPoint) and given.body != center.body:
            passage = "moving"
            apart = poses[center.body].local_vector(given.position(poses) - center.position(poses))
            self._refuse_on_axis(apart, radius)
            values.append(given.s)
            bodies.append(given.body)
        elif given is not None:
            place = given.s if isinstance(given, LocalPoint) else vector(given, "around.side")
            side = np.array(place) - np.array(center.s)
            passage = "through" if side @ side < radius * radius else "side"
            self._refuse_on_axis(side, radius)
            if passage == "side":
                values.append(triple(side))
        return Measure(WrapKind(self.axis is not None, passage), tuple(bodies), tuple(values))

    def _refuse_on_axis(self, side: Array, radius: float) -> None:
        """Refuse a side, from the centre, that is on the axis of the cylinder and outside of the radius."""
        if self.axis is None or side @ side < radius * radius:
            return
        across = cross(side, direction(self.axis, "around.axis"))
        if across @ across < 1e-24 * (side @ side):
            message = "around.side is on the axis of the cylinder, which determines no side. Give a point beside it."
            raise ModelError(message, field="around")


class WrapKind(NamedTuple):
    """The kind of a segment that wraps a shape: what the shape is, and which way the segment passes it."""

    cylinder: bool
    passage: Passage

    @property
    def bodies(self) -> int:
        """Those of both ends, of the shape, and of a side that moves."""
        return 4 if self.passage == "moving" else 3

    @property
    def fields(self) -> Mapping[str, str]:
        """The kinds of the fields by name."""
        found = {"s_i": "Vec3", "s_j": "Vec3", "s_k": "Vec3", "radius": "Scalar"}
        found |= {"h_k": "Vec3"} if self.cylinder else {}
        return found | {"side": {"f_k": "Vec3"}, "moving": {"s_l": "Vec3"}}.get(self.passage, {})

    def __call__(self, *values: Any) -> WoundSegment:
        """Return the segment with these values of its fields."""
        return WoundSegment(self, dict(zip(self.fields, values, strict=True)))


class WoundSegment(NamedTuple):
    """A segment from a point of body i to one of body j, around a shape of body k, with a side that body l may have."""

    kind: WrapKind
    values: Mapping[str, Any]

    @property
    def fields(self) -> Mapping[str, str]:
        """The kinds of the fields by name."""
        return self.kind.fields

    def length(self, x: Any) -> Scalar:
        """Length of the path [m]."""
        return self._way(x).length

    def rate(self, x: Any, v: Any) -> Scalar:
        """Its rate [m/s]."""
        found: Scalar = sum(block @ rate for block, rate in zip(self._gradient(x), v[:6], strict=True))
        return found

    def act(self, values: Any, x: Any, v: Any, t: Scalar) -> Row:
        """Q of a force along the segment, positive where it pushes."""
        return (*(values[0] * block for block in self._gradient(x)), *[None] * (2 * self.kind.bodies - 6))

    def _gradient(self, x: Any) -> list[Array]:
        """The derivatives of the length to the coordinates of the bodies i, j and k.

        Those to the ends are the directions of the path there; motions of all bodies together do not change the length.
        """
        p_i, p_j, r_k, p_k = x[1], x[3], x[4], x[5]
        s_i, s_j = self.values["s_i"], self.values["s_j"]
        way = self._way(x)
        i, j = x[0] + rotate(p_i, s_i) - r_k, x[2] + rotate(p_j, s_j) - r_k
        moment = cross(i, way.first) - cross(j, way.last)
        return [
            -way.first, -(way.first @ B(p_i, s_i)), way.last, way.last @ B(p_j, s_j),
            way.first - way.last, 2 * (moment @ E(p_k)),
        ]  # fmt: skip

    def _way(self, x: Any) -> Detour:
        given, p_k = self.values, x[5]
        center = x[4] + rotate(p_k, given["s_k"])
        i, j = x[0] + rotate(x[1], given["s_i"]) - center, x[2] + rotate(x[3], given["s_j"]) - center
        side, axis = (rotate(p_k, given[name]) if name in given else None for name in ("f_k", "h_k"))
        if "s_l" not in given:
            corner = Corner.of(i, j, given["radius"], side, axis)
            return corner.through() if self.kind.passage == "through" else corner.around()
        moving = x[6] + rotate(x[7], given["s_l"]) - center
        corner = Corner.of(i, j, given["radius"], moving, axis)
        inside = functions.positive(given["radius"] * given["radius"] - moving @ moving)
        return corner.through().where(inside, corner.around())
