"""Fixed joint: two bodies move as one. 6 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..geometry.frame import Frame
from ..geometry.placement import Frames, placed_frames
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..measure import Place
from ..primitive import Primitive
from .joint import Joint, dot1, spherical


@dataclass(frozen=True, eq=False)
class Fixed(Joint):
    """Fixed joint of ``body_i`` and ``body_j``.

    Given by a global ``point`` [m] in the initial pose, or by ``frame_i`` and ``frame_j``, which it makes coincide.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None

    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes."""
        return placed_frames(self, None, poses)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φˢ(P_i, P_j), Φ^d1(f_i, h_j), Φ^d1(g_i, h_j), Φ^d1(f_i, g_j)."""
        i, j = self.frames(poses)
        yield spherical(i, j)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)
        yield dot1("f_i.g_j", i, j, i.f, j.g)
