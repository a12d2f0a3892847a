"""Coupler: any coordinates of two joints are proportional. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Known, chosen
from ..measure import Ratio
from ..primitive import Primitive
from .coupling import Coupling, coupled, ratio_of


@dataclass(frozen=True, eq=False)
class Coupler(Coupling):
    """Coordinate of ``joint_j`` = ``ratio`` · coordinate of ``joint_i`` + ``offset``, as numbers in m and rad.

    Coordinates are given as ``slide.travel``, ``pin.angle``, or by the joint's name where it has only one. Left out,
    the offset is that of the initial pose.

    Its reaction, `run.reaction`, is the torque or force along the coordinate of ``joint_j`` on the second body of that
    joint; along the coordinate of ``joint_i`` it is -``ratio`` times as much. Nothing else is transmitted to bearings.
    """

    joint_i: str
    joint_j: str
    ratio: Ratio
    offset: Ratio | None = None

    @property
    def follower(self) -> str:
        """The second joint."""
        return self.joint_j

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield the second coordinate - ratio · the first - offset."""
        i, j = chosen(self.joint_i, None, known, "joint_i"), chosen(self.joint_j, None, known, "joint_j")
        yield coupled(i, j, ratio_of(self.ratio), self.offset)
