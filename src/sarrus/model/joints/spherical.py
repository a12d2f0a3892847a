"""Spherical joint: two points coincide. 3 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..errors import ModelError
from ..geometry.placement import Points, refuse_both, refuse_other_body, refuse_same_body, two_bodies
from ..geometry.point import Point
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..measure import Place
from ..primitive import Primitive
from .joint import Joint, spherical


@dataclass(frozen=True, eq=False)
class Spherical(Joint):
    """Spherical (ball) joint of ``body_i`` and ``body_j``.

    Given by a global ``point`` [m] in the initial pose, or by ``point_i`` and ``point_j``, a point on each body.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    point_i: Point | None = None
    point_j: Point | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φˢ(P_i, P_j)."""
        i, j = self._points(poses)
        yield spherical(i, j)

    def _points(self, poses: Poses) -> Points:
        given = self.point_i is not None or self.point_j is not None
        points = self._given(poses) if given else self._made(poses)
        refuse_same_body(points.i.body, points.j.body, "point_j" if given else "body_j")
        return points

    def _made(self, poses: Poses) -> Points:
        body_i, body_j = two_bodies(self.body_i, self.body_j)
        if self.point is None:
            raise ModelError("point is missing. Give a point in global axes, or a point on each body.")
        i, j = (Point(body, self.point, "global").resolve(poses, "point") for body in (body_i, body_j))
        return Points(i, j)

    def _given(self, poses: Poses) -> Points:
        refuse_both({"point": self.point}, "points")
        if self.point_i is None or self.point_j is None:
            raise ModelError("one of its two points is missing. Give a point on each body.", field="point_i")
        points = Points(self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j"))
        refuse_other_body(self.body_i, points.i.body, "point_i")
        refuse_other_body(self.body_j, points.j.body, "point_j")
        return points
