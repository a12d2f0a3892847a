"""Universal joint, Eq. (31): a common point and two perpendicular cross axes. 4 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, angle, turned
from ..errors import ModelError
from ..geometry.frame import PERPENDICULAR, Frame, LocalFrame, frame_axes
from ..geometry.placement import Axis, Frames, placed_frames
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..measure import Direction, Place
from ..primitive import Primitive
from ..quantity import Array, direction, plain, triple
from .joint import Joint, dot1, spherical


@dataclass(frozen=True, eq=False)
class Universal(Joint):
    """Universal (Cardan) joint; its cross rotates in ``body_i`` about ``axis_i`` and in ``body_j`` about ``axis_j``.

    Placed by a global ``point`` [m] and two perpendicular global axes in the initial pose, or by
    ``frame_i`` and ``frame_j`` with h along the cross axes.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    axis_i: Direction | None = None
    axis_j: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None

    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes, with h along the cross axes."""
        return placed_frames(self, (Axis("axis_i", self.axis_i), Axis("axis_j", self.axis_j)), poses)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φˢ(P_i, P_j), Φ^d1(h_i, h_j)."""
        i, j = self.frames(poses)
        if self.frame_i is None:
            _check_cross(direction(self.axis_i, "axis_i"), direction(self.axis_j, "axis_j"))
        yield spherical(i, j)
        yield dot1("h_i.h_j", i, j, i.h, j.h)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angles of the cross in body i about h_i, from f_i to h_j, and in body j about h_j.

        Placed by global axes both start at 0; then f_i is h_j in the initial pose, and the other way round.
        """
        axes = Axis("axis_i", self.axis_i), Axis("axis_j", self.axis_j)
        i, j = placed_frames(self, axes, poses)
        if self.frame_i is None:
            i, j = _along(i, j, poses), _along(j, i, poses)
        yield angle(i, j, poses, f_j=j.h, name="angle_i")
        yield angle(j, i, poses, f_j=i.h, name="angle_j")


def _check_cross(h_i: Array, h_j: Array) -> None:
    cosine = plain(h_i @ h_j)
    if abs(cosine) > PERPENDICULAR:
        message = f"axis_i and axis_j must be perpendicular, but the cosine between them is {cosine:.6g}"
        raise ModelError(f"{message}. Turn one of them.", field="axis_i")


def _along(i: LocalFrame, j: LocalFrame, poses: Poses) -> LocalFrame:
    """The frame of body i turned about h_i until f_i is h_j."""
    towards = poses[i.body].local_vector(turned(j.h, j.body, poses))
    axes = frame_axes(towards, i.h, "axis_j")
    return LocalFrame(i.body, i.s, triple(axes[:, 0]), triple(axes[:, 1]), i.h)
