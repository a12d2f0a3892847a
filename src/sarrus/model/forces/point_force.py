"""A constant force at a point of a body."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ... import elements
from ..measure import ForceVector
from ..point import Axes, Point
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import vector
from .force import Force, choose, refuse_ground


@dataclass(frozen=True, eq=False)
class PointForce(Force):
    """A ``force`` [N] at ``point``, constant in global axes, or in body axes: it follows the body."""

    point: Point
    force: ForceVector
    axes: Axes = "global"

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the point force or the follower force."""
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        element = choose(self.axes, of_global=elements.PointForce, of_body=elements.FollowerForce)
        yield Primitive(element, (point.body,), (point.s, vector(self.force, "force")), "force")
