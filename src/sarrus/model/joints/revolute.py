"""Revolute joint, Eq. (30): two bodies turn about a common axis. 5 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, angle
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..primitive import Primitive
from .joint import Joint, dot1, spherical


@dataclass(frozen=True, eq=False)
class Revolute(AboutAxis, Joint):
    """Revolute joint (hinge): a common point and a common axis h.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` and
    ``frame_j`` with h along the axis.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φˢ(P_i, P_j), Φ^d1(f_i, h_j), Φ^d1(g_i, h_j)."""
        i, j = self.frames(poses)
        yield spherical(i, j)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angle from f_i to f_j about h."""
        yield angle(*self.frames(poses), poses)
