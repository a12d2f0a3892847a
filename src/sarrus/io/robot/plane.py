"""Planar joint: a point of one body stays in a plane of another, to which it is not tilted. 3 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ...model.joints.joint import Joint, dot1, dot2
from ...model.placement import AboutAxis
from ...model.pose import Poses
from ...model.primitive import Primitive


@dataclass(frozen=True, eq=False)
class Plane(AboutAxis, Joint):
    """Two planes with a common normal h.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` and
    ``frame_j`` with h along the normal.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d1(f_i, h_j), Φ^d1(g_i, h_j), Φ^d2(h_i, d)."""
        i, j = self.frames(poses)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)
        yield dot2("h_i.d", i, j, i.h)


del Joint.kinds["plane"]  # no word of the model file: it has, or will have, a planar joint of its own
