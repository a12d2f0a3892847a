"""Revolute-spherical joint: a massless link, hinged to body i, with a ball on body j. 2 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, heading
from ..measure import Direction
from ..pose import Poses
from ..primitive import Primitive
from .joint import Joint, dot2
from .link import Link


@dataclass(frozen=True, eq=False)
class RevoluteSpherical(Link, Joint):
    """A link that rotates about an axis of body i, normal to it, and carries a point of body j at its end.

    Placed by ``point_i`` and ``point_j`` and the global ``axis`` in the initial pose, or by ``frame_i`` with h
    along the axis and ``frame_j``. The ``length`` [m], left out, is the initial distance.
    """

    axis: Direction | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d2(h_i, d), Φˢˢ(P_i, P_j, C)."""
        i, j = self.ends(poses, self.axis, self.axis, ("axis", "axis"))
        yield dot2("h_i.d", i, j, i.h)
        yield self.distance(i, j, poses)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angle of the link about h_i."""
        i, j = self.ends(poses, self.axis, self.axis, ("axis", "axis"))
        yield heading(i, j, poses, from_start=self.frame_i is None)
