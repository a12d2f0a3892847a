"""Point on line, also called in-line, and point on plane: a point of one body stays there on the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, displacement
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..primitive import Primitive
from .joint import Joint, dot2


@dataclass(frozen=True, eq=False)
class PointOnLine(AboutAxis, Joint):
    """Point on a line: the line h is fixed in body i, the point in body j, which may move otherwise.

    The order matters: ``PointOnLine("roller", sr.ground, bar, ...)`` is a roller of a bar on a fixed rail. With
    exchanged bodies, a rail on the bar passes through a fixed point; both are the same only in the initial pose.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` with h along the
    line and ``frame_j`` at the point.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d2(f_i, d), Φ^d2(g_i, d)."""
        i, j = self.frames(poses)
        yield dot2("f_i.d", i, j, i.f)
        yield dot2("g_i.d", i, j, i.g)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the displacement of the point along the line."""
        yield displacement(*self.frames(poses), poses)


@dataclass(frozen=True, eq=False)
class PointOnPlane(AboutAxis, Joint):
    """Point on a plane: the plane with the normal h is fixed in body i, the point in body j.

    The order matters, as of a `PointOnLine`.

    Placed by a global ``point`` [m] and the normal ``axis`` in the initial pose, or by ``frame_i`` with h
    along the normal and ``frame_j`` at the point.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d2(h_i, d)."""
        i, j = self.frames(poses)
        yield dot2("h_i.d", i, j, i.h)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the displacements of the point along f_i and g_i."""
        i, j = self.frames(poses)
        yield displacement(i, j, poses, axis=i.f, name="displacement_x")
        yield displacement(i, j, poses, axis=i.g, name="displacement_y")
