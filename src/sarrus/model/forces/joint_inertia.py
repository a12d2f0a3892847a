"""Inertia of a joint coordinate, as of a motor's rotor behind a gear."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

from ... import elements
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..measure import In, Mass
from ..primitive import Primitive
from ..quantity import not_negative
from .force import Force


@dataclass(frozen=True, eq=False)
class AngleInertia(AboutAxis, Force):
    """Kinetic energy ½ inertia · θ̇² of the angle θ of a revolute or cylindrical joint; placed like the joint.

    A rotor with the moment of inertia J about its axis, behind a gear of the ratio n, has the inertia n² J, which
    robotics calls armature or reflected inertia. The gyroscopic moment of the rotor is neglected.

    Parameters
    ----------
    inertia
        [kg m²], not negative.
    """

    inertia: Annotated[float, In("kg m^2")] = field(kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the inertia of the angle."""
        i, j = self.frames(poses)
        inertia = not_negative(self.inertia, "inertia", "Give it in kg m².")
        yield Primitive(elements.AngleInertia, (i.body, j.body), (i.f, i.g, j.f, inertia), "inertia")


@dataclass(frozen=True, eq=False)
class DisplacementInertia(AboutAxis, Force):
    """Kinetic energy ½ inertia · u̇² of the displacement u of a translational or cylindrical joint; placed like it.

    A rotor with the moment of inertia J that rotates by the angle n u has the inertia n² J.

    Parameters
    ----------
    inertia
        [kg], not negative.
    """

    inertia: Mass = field(kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the inertia of the displacement."""
        i, j = self.frames(poses)
        inertia = not_negative(self.inertia, "inertia", "Give it in kg.")
        yield Primitive(elements.DisplacementInertia, (i.body, j.body), (i.h, i.s, j.s, inertia), "inertia")
