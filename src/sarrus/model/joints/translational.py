"""Translational joint, Eq. (32): two bodies slide along a common axis. 5 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, displacement
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..primitive import Primitive
from .joint import Joint, dot1, dot2


@dataclass(frozen=True, eq=False)
class Translational(AboutAxis, Joint):
    """Translational (prismatic) joint: displacement along a common axis h, without rotation.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` and
    ``frame_j`` with h along the axis.

    Notes
    -----
    The two frames coincide when the joint is assembled. Eq. (32) uses a frame on body j that is
    rotated by a right angle about h, so its Φ^d1(f_i, f_j) is Φ^d1(f_i, g_j) here.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d1(g_i, h_j), Φ^d1(f_i, h_j), Φ^d1(f_i, g_j), Φ^d2(g_i, d), Φ^d2(f_i, d)."""
        i, j = self.frames(poses)
        yield dot1("g_i.h_j", i, j, i.g, j.h)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("f_i.g_j", i, j, i.f, j.g)
        yield dot2("g_i.d", i, j, i.g)
        yield dot2("f_i.d", i, j, i.f)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the displacement of P_j along h_i."""
        yield displacement(*self.frames(poses), poses)
