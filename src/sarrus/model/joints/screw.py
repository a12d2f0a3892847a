"""Screw joint: two bodies rotate about a common axis and move along it in proportion. 5 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from ... import elements
from ..errors import ModelError
from ..geometry.pose import Poses
from ..measure import Length
from ..primitive import Primitive
from ..quantity import number
from .cylindrical import Cylindrical


@dataclass(frozen=True, eq=False)
class Screw(Cylindrical):
    """Screw joint: common axis h, and ``pitch`` [m], the displacement per revolution, positive if right-handed.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` and
    ``frame_j`` with h along the axis; the frames coincide where angle and displacement are 0.
    """

    pitch: Length = field(kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the primitives of a cylindrical joint, and the screw."""
        pitch = number(self.pitch, "pitch", "Give the displacement in m per revolution.")
        if not pitch:
            raise ModelError("pitch must not be 0. Give it in m, or use a revolute joint.", field="pitch")
        yield from super().primitives(poses)
        i, j = self.frames(poses)
        values = (i.f, i.g, i.h, j.f, i.s, j.s, pitch / (2 * pi), 0.0, 0.0)
        yield Primitive(elements.Screw, (i.body, j.body), values, "screw")
