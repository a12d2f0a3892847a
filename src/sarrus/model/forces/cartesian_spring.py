"""A spring and damper for each axis between two points: a bushing without rotational stiffness."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..geometry.placement import refuse_same_body
from ..geometry.point import Point
from ..geometry.pose import Poses
from ..measure import In
from ..primitive import Primitive
from ..quantity import Vector, not_negative, vector
from .bushing import dissipative6
from .force import Force

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class CartesianSpring(Force):
    """A force k (u − offset) + c u̇ along each axis of body i, for the displacement u of ``point_j`` from ``point_i``.

    Parameters
    ----------
    point_i, point_j
        The ends, which may coincide. The force acts at point_j, in the axes of the body of point_i.
    stiffness
        k for each axis [N/m].
    damping
        c for each axis [N s/m].
    offset
        The displacement u without force [m].
    """

    point_i: Point
    point_j: Point
    stiffness: Annotated[Vector, In("N/m")]
    damping: Annotated[Vector, In("N s/m")] = ZERO
    offset: Annotated[Vector, In("m")] = ZERO

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield a bushing."""
        i, j = self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j")
        refuse_same_body(i.body, j.body, "point_j")
        k, c = vector(self.stiffness, "stiffness"), vector(self.damping, "damping")
        for name, three in (("stiffness", k), ("damping", c)):
            for value in three:
                not_negative(value, name, "Give three numbers of at least 0.")
        preload = [one * u for one, u in zip(k, vector(self.offset, "offset"), strict=True)]
        matrices = (dissipative6((*one, *ZERO), "stiffness") for one in (k, c))
        values = (i.s, *AXES, j.s, 1.0, ZERO, *matrices, (*preload, *ZERO))
        yield Primitive(elements.Bushing, (i.body, j.body), values, "bushing")
