"""Cylindrical joint: two bodies slide along and turn about a common axis. 4 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, angle, displacement
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..primitive import Primitive
from .joint import Joint, dot1, dot2


@dataclass(frozen=True, eq=False)
class Cylindrical(AboutAxis, Joint):
    """Cylindrical joint: rotation about, and displacement along, a common axis h.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` and
    ``frame_j`` with h along the axis.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d1(f_i, h_j), Φ^d1(g_i, h_j), Φ^d2(f_i, d), Φ^d2(g_i, d)."""
        i, j = self.frames(poses)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)
        yield dot2("f_i.d", i, j, i.f)
        yield dot2("g_i.d", i, j, i.g)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angle from f_i to f_j about h, and the displacement of P_j along h_i."""
        i, j = self.frames(poses)
        yield angle(i, j, poses)
        yield displacement(i, j, poses)
