"""Universal joint, Eq. (31): a common point and two perpendicular cross axes. 4 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..errors import ModelError
from ..frame import PERPENDICULAR, Frame
from ..measure import Direction, Place
from ..placement import Axis, placed_frames
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import Array, direction
from ..solid import Solid
from .joint import Joint, dot1, spherical


@dataclass(frozen=True, eq=False)
class Universal(Joint):
    """A Cardan joint; the cross turns in body i about ``axis_i`` and in body j about ``axis_j``.

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

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φˢ(P_i, P_j), Φ^d1(h_i, h_j)."""
        axes = Axis("axis_i", self.axis_i), Axis("axis_j", self.axis_j)
        i, j = placed_frames(self, axes, poses)
        if self.frame_i is None:
            _check_cross(direction(self.axis_i, "axis_i"), direction(self.axis_j, "axis_j"))
        yield spherical(i, j)
        yield dot1("h_i.h_j", i, j, i.h, j.h)


def _check_cross(h_i: Array, h_j: Array) -> None:
    cosine = float(h_i @ h_j)
    if abs(cosine) > PERPENDICULAR:
        told = f"axis_i and axis_j must be perpendicular, but the cosine between them is {cosine:.6g}"
        raise ModelError(f"{told}; turn one of them", field="axis_i")
