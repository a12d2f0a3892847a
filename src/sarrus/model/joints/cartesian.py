"""Cartesian joint: three translations and no rotation. 3 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..coordinate import Coordinate, displacement
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..primitive import Primitive
from .joint import Joint, dot1


@dataclass(frozen=True, eq=False)
class Cartesian(AboutAxis, Joint):
    """Two bodies that translate freely and do not rotate relative to each other, as on a gantry or a shaker.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` and ``frame_j``.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d1(f_i, h_j), Φ^d1(g_i, h_j), Φ^d1(f_i, g_j), the rotations of Eq. (32)."""
        i, j = self.frames(poses)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)
        yield dot1("f_i.g_j", i, j, i.f, j.g)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the displacements of P_j along f_i, g_i and h_i."""
        i, j = self.frames(poses)
        for name, axis in (("x", i.f), ("y", i.g), ("z", i.h)):
            yield displacement(i, j, poses, axis=axis, name=f"displacement_{name}")
