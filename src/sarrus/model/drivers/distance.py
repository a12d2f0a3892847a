"""Distance driver: the distance of two points is a function of time, as in a hydraulic cylinder. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..coordinate import Known
from ..geometry.placement import refuse_same_body
from ..geometry.point import Point
from ..geometry.pose import Poses
from ..laws.prescribed import Motion, motion_of
from ..measure import In
from ..primitive import Primitive
from .driver import Driver


@dataclass(frozen=True, eq=False)
class DistanceDriver(Driver):
    """The distance [m] of ``point_i`` and ``point_j`` follows a ``motion``, a number or a function of time.

    It may not vanish.
    """

    point_i: Point
    point_j: Point
    motion: Annotated[Motion, In("m", over="s", states=True)]

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield d·d - f(t)²."""
        i, j = self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j")
        refuse_same_body(i.body, j.body, "point_j")
        values = (i.s, j.s, *motion_of(self.motion, "motion"))
        yield Primitive(elements.DistanceDriver, (i.body, j.body), values, "distance")
