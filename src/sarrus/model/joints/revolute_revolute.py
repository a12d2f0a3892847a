"""Revolute-revolute joint: a massless link, hinged to both bodies. 4 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..._jit.functions import cos
from ..coordinate import Coordinate, heading
from ..frame import LocalFrame
from ..measure import Angle, Direction
from ..placement import Frames
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import number
from .joint import Joint, dot1, dot2
from .link import Link
from .twist import PARALLEL, constant_angle, cosine


@dataclass(frozen=True, eq=False)
class RevoluteRevolute(Link, Joint):
    """A link along the common normal of an axis of body i and one of body j, which it keeps at a ``twist`` [rad].

    Placed by ``point_i`` and ``point_j`` and global axes in the initial pose, or by ``frame_i`` and
    ``frame_j`` with h along the axes. Left out, ``axis_j`` is parallel to ``axis_i``, the ``length`` [m] and
    the ``twist`` are those of the initial pose.
    """

    axis_i: Direction | None = None
    axis_j: Direction | None = None
    twist: Angle | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the equations for parallel axes, or those for twisted ones."""
        i, j = self._hinges(poses)
        twist = cosine(i, j, poses) if self.twist is None else cos(number(self.twist, "twist"))
        yield from _parallel(i, j) if abs(twist) > 1 - PARALLEL else _twisted(i, j, twist)
        yield self.distance(i, j, poses)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angles of the link about h_i and about h_j."""
        i, j = self._hinges(poses)
        yield heading(i, j, poses, from_start=self.frame_i is None, name="angle_i")
        yield heading(j, i, poses, from_start=self.frame_j is None, name="angle_j")

    def _hinges(self, poses: Poses) -> Frames:
        axis_j = self.axis_i if self.axis_j is None else self.axis_j
        return self.ends(poses, self.axis_i, axis_j, ("axis_i", "axis_j"))


def _parallel(i: LocalFrame, j: LocalFrame) -> Iterator[Primitive]:
    """Yield Φ^d1(f_i, h_j), Φ^d1(g_i, h_j), Φ^d2(h_i, d)."""
    yield dot1("f_i.h_j", i, j, i.f, j.h)
    yield dot1("g_i.h_j", i, j, i.g, j.h)
    yield dot2("h_i.d", i, j, i.h)


def _twisted(i: LocalFrame, j: LocalFrame, twist: float) -> Iterator[Primitive]:
    """Yield h_i·h_j = cos(twist), Φ^d2(h_i, d), Φ^d2(h_j, d)."""
    yield constant_angle(i, j, twist)
    yield dot2("h_i.d", i, j, i.h)
    yield dot2("h_j.d", j, i, j.h)
