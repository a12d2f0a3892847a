"""Gears: the angles of two joints are proportional. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import ANGLE, Known, chosen
from ..measure import Angle, Ratio
from ..primitive import Primitive
from .coupling import Coupling, coupled, ratio_of


@dataclass(frozen=True, eq=False)
class Gear(Coupling):
    """Angle of ``joint_j`` = ``ratio`` · angle of ``joint_i`` + ``offset`` [rad], revolutions included.

    The joints are given by name, ``pin``, or where one has several angles ``hook.angle_i``. Left out, the offset is
    that of the initial pose. Spur gears of the same sense of axes have a negative ratio.

    Its reaction, `run.reaction`, is the torque on the second body of ``joint_j`` through that joint; the second body
    of ``joint_i`` feels -``ratio`` times as much, and the first bodies the opposite. Torques are transmitted, tooth
    forces are not: the bearings of the wheels carry no radial or tangential force of the mesh.
    """

    joint_i: str
    joint_j: str
    ratio: Ratio
    offset: Angle | None = None

    @property
    def follower(self) -> str:
        """The second joint."""
        return self.joint_j

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield θ_j - ratio θ_i - offset."""
        i, j = chosen(self.joint_i, ANGLE, known, "joint_i"), chosen(self.joint_j, ANGLE, known, "joint_j")
        yield coupled(i, j, ratio_of(self.ratio), self.offset)
