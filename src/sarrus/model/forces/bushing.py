"""A bushing: an elastic and damping connection of two frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

from ... import elements
from ..geometry.frame import Frame
from ..geometry.placement import placed_frames
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..measure import In, Place
from ..primitive import Primitive
from .force import Force
from .matrix6 import Matrix6, Vector6, dissipative6, vector6


@dataclass(frozen=True, eq=False)
class Bushing(Force):
    """Bushing: force and torque stiffness · Ξ + damping · Ξ̇ − preload for the deformation Ξ of two frames.

    Ξ are the three coordinates of frame j's origin in frame i, and the three components there of n sin φ, where frame j
    is rotated by φ about n: a model for small angles. Placed by a global ``point`` [m], with the global axes, in
    the initial pose, where Ξ then starts at 0, or by ``frame_i`` and ``frame_j``.

    Parameters
    ----------
    body_i, body_j
        The two bodies that it connects.
    stiffness
        Six by six, or the six diagonal entries [N/m, N/rad; N, N m/rad]. A symmetric one conserves energy. It may not
        be negative in any direction.
    damping
        In the same form [N s/m, N s/rad; N s, N m s/rad].
    preload
        Force [N] and torque [N m] on body j, in the axes of frame i, where Ξ = 0.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    stiffness: Annotated[Matrix6, In("")] = field(kw_only=True)
    damping: Annotated[Matrix6, In("")] = (0.0,) * 6
    preload: Annotated[Vector6, In("")] = (0.0,) * 6

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the bushing."""
        i, j = placed_frames(self, None, poses)
        K, C = dissipative6(self.stiffness, "stiffness"), dissipative6(self.damping, "damping")
        values = (i.s, i.f, i.g, i.h, j.s, j.f, j.g, j.h, K, C, vector6(self.preload, "preload"))
        yield Primitive(elements.Bushing, (i.body, j.body), values, "bushing")
