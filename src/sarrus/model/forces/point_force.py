"""A force at a point of a body, constant or varying in time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..law import Law
from ..measure import In
from ..point import Axes, Point
from ..pose import Poses
from ..primitive import Primitive
from .force import Force, choose, refuse_ground
from .history import Load, history


@dataclass(frozen=True, eq=False)
class PointForce(Force):
    """A ``force`` [N] at ``point``, in global axes, or in body axes: it follows the body.

    Parameters
    ----------
    point
        Where it acts.
    force
        Three components; each a number, or a law over time [s].
    axes
        "global" or "body".
    factor
        A number, or a law over time [s], that scales the force: a magnitude, where ``force`` is a direction.
    """

    point: Point
    force: Annotated[Load, In("N", over="s")]
    axes: Axes = "global"
    factor: Annotated[Law, In("1", over="s")] = 1.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the point force or the follower force."""
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        force, curves = history(self.force, self.factor, "force")
        element = choose(self.axes, of_global=elements.PointForce, of_body=elements.FollowerForce)
        if curves:
            element = choose(
                self.axes, of_global=elements.VaryingForce, of_body=elements.VaryingFollowerForce
            )
        yield Primitive(element, (point.body,), (point.s, force, *curves), "force")
