"""Planar joint: a plane of one body slides on a plane of the other. 3 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, angle, displacement
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..primitive import Primitive
from .joint import Joint, dot1, dot2


@dataclass(frozen=True, eq=False)
class Planar(AboutAxis, Joint):
    """Planar joint: the bodies have a common plane with the normal h.

    Placed by a global ``point`` [m] of the plane and its normal ``axis`` in the initial pose, or by
    ``frame_i`` and ``frame_j`` with h along the normal.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d1(f_i, h_j), Φ^d1(g_i, h_j), Φ^d2(h_i, d)."""
        i, j = self.frames(poses)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)
        yield dot2("h_i.d", i, j, i.h)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angle from f_i to f_j about h, and the displacements of P_j along f_i and g_i."""
        i, j = self.frames(poses)
        yield angle(i, j, poses)
        yield displacement(i, j, poses, axis=i.f, name="displacement_x")
        yield displacement(i, j, poses, axis=i.g, name="displacement_y")
