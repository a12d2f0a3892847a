"""Constant angle: a direction of one body and a direction of the other keep the angle between them. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..frame import Frame
from ..measure import Angle, Direction
from ..placement import Axis, placed_frames
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import Vector
from ..solid import Solid
from .joint import Joint
from .twist import constant_angle, cosine_of


@dataclass(frozen=True, eq=False)
class ConstantAngle(Joint):
    """An ``angle`` [rad] between ``axis_i`` and ``axis_j``; left out, as it is in the initial pose.

    Placed by two global axes in the initial pose, or by ``frame_i`` and ``frame_j`` with h along them.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    axis_i: Direction | None = None
    axis_j: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    angle: Angle | None = None

    @property
    def point(self) -> Vector | None:
        """Where its frames are put, which does not matter."""
        return None if self.frame_i or self.frame_j else (0.0, 0.0, 0.0)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield h_i·h_j = cos(angle)."""
        axes = Axis("axis_i", self.axis_i), Axis("axis_j", self.axis_j)
        i, j = placed_frames(self, axes, poses)
        yield constant_angle(i, j, cosine_of(self.angle, "angle", i, j, poses))
