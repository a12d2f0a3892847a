"""Segment of a tendon from one point to another that wraps a sphere or a cylinder of a third body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ....algebra import Array, Row, cross
from ....elements.element import Scalar
from ....euler import B, E, rotate
from ....functions import positive as is_positive
from ...errors import ModelError
from ...geometry.point import LocalPoint, Point
from ...geometry.pose import Poses
from ...measure import Direction, Length, Offset
from ...quantity import direction, positive, triple, vector
from ...signals import Measure
from .winding import Corner, Way

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
        return Measure(Around(self.axis is not None, passage), tuple(bodies), tuple(values))

    def _refuse_on_axis(self, side: Array, radius: float) -> None:
        """Refuse a side, from the centre, that is on the axis of the cylinder and outside of the radius."""
        if self.axis is None or side @ side < radius * radius:
            return
        across = cross(side, direction(self.axis, "around.axis"))
        if across @ across < 1e-24 * (side @ side):
            message = "around.side is on the axis of the cylinder, which determines no side. Give a point beside it."
            raise ModelError(message, field="around")


class Around(NamedTuple):
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

    def __call__(self, *values: Any) -> Wound:
        """Return the segment with these values of its fields."""
        return Wound(self, dict(zip(self.fields, values, strict=True)))


class Wound(NamedTuple):
    """A segment from a point of body i to one of body j, around a shape of body k, with a side that body l may have."""

    kind: Around
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

    def _way(self, x: Any) -> Way:
        given, p_k = self.values, x[5]
        center = x[4] + rotate(p_k, given["s_k"])
        i, j = x[0] + rotate(x[1], given["s_i"]) - center, x[2] + rotate(x[3], given["s_j"]) - center
        side, axis = (rotate(p_k, given[name]) if name in given else None for name in ("f_k", "h_k"))
        if "s_l" not in given:
            corner = Corner.of(i, j, given["radius"], side, axis)
            return corner.through() if self.kind.passage == "through" else corner.around()
        moving = x[6] + rotate(x[7], given["s_l"]) - center
        corner = Corner.of(i, j, given["radius"], moving, axis)
        inside = is_positive(given["radius"] * given["radius"] - moving @ moving)
        return corner.through().where(inside, corner.around())
