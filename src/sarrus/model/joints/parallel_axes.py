"""Parallel axes: a direction of one body stays parallel to a direction of the other. 2 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, angle
from ..geometry.frame import Frame
from ..geometry.placement import Axis, Frames, placed_frames
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..measure import Direction
from ..primitive import Primitive
from ..quantity import Vector
from .joint import Joint, dot1


@dataclass(frozen=True, eq=False)
class ParallelAxes(Joint):
    """Parallel axes of ``body_i`` and ``body_j``: relative rotation about the direction h only, translation free.

    Placed by a global ``axis`` in the initial pose, or by ``frame_i`` and ``frame_j`` with h along it.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    axis: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None

    @property
    def point(self) -> Vector | None:
        """The arbitrary origin of both frames."""
        return None if self.frame_i or self.frame_j else (0.0, 0.0, 0.0)

    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes."""
        return placed_frames(self, (Axis("axis", self.axis), Axis("axis", self.axis)), poses)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d1(f_i, h_j), Φ^d1(g_i, h_j)."""
        i, j = self.frames(poses)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angle from f_i to f_j about h."""
        yield angle(*self.frames(poses), poses)
