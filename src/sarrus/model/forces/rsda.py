"""RSDA: a spring, damper and actuator about an axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

from ... import elements
from ..coordinate import angle
from ..measure import Angle, In
from ..placement import AboutAxis
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import number
from .force import Force


@dataclass(frozen=True, eq=False)
class RSDA(AboutAxis, Force):
    """A torque n = k (θ − angle) + c θ̇ + torque about h_i, Eq. (106), against the rotation θ.

    θ is the rotation of body j relative to body i about h_i, right-handed, with counted
    revolutions. Placed by a global ``point`` [m] and ``axis`` in the initial pose, where θ then
    starts at 0, or by ``frame_i`` and ``frame_j``, where θ is the angle from f_i to f_j.

    Parameters
    ----------
    k
        Stiffness [N m/rad].
    c
        Damping [N m s/rad].
    angle
        Free angle [rad].
    torque
        Actuator's torque [N m].
    """

    k: Annotated[float, In("N m/rad")] = field(kw_only=True)
    c: Annotated[float, In("N m s/rad")] = 0.0
    angle: Angle = 0.0
    torque: Annotated[float, In("N m")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the RSDA with its initial angle."""
        i, j = self.frames(poses)
        k, c = number(self.k, "k"), number(self.c, "c")
        free, torque = number(self.angle, "angle", "give radians"), number(self.torque, "torque")
        axes = (i.f, i.g, i.h, j.f, j.h)
        values = (*axes, k, c, free, torque, angle(i, j, poses).start)
        yield Primitive(elements.RSDA, (i.body, j.body), values, "rsda")
