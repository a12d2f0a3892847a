"""Inertia of a joint coordinate, as of a motor's rotor behind a gear."""

from __future__ import annotations

import abc
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

from ... import elements
from ..coordinate import ANGLE, DISPLACEMENT, chosen
from ..errors import ModelError
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..measure import In, Mass
from ..primitive import Primitive
from ..quantity import not_negative
from ..signals import Signals
from .force import Force

PLACEMENT = ("body_i", "body_j", "point", "axis", "frame_i", "frame_j")


@dataclass(frozen=True, eq=False, repr=False)
class JointInertia(AboutAxis, abc.ABC):
    """Inertia of a joint's coordinate.

    Parameters
    ----------
    joint
        The joint by name, ``pin``, or one of its coordinates, ``sleeve.angle``, in place of bodies, point, axis or
        frames.
    """

    joint: str = field(default="", kw_only=True)
    coordinate: ClassVar[type[elements.Element]] = ANGLE  # the element that measures it

    @abc.abstractmethod
    def inertia_of(self, bodies: tuple[str, ...], vectors: tuple[Any, ...]) -> Primitive:
        """The element, with the three vectors that measure the coordinate."""

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the inertia of a joint that is given by name."""
        if not self.joint:
            return
        placed = next((name for name in PLACEMENT if getattr(self, name) is not None), None)
        if placed is not None:
            raise ModelError(f"has both joint and {placed}. Leave one of them out.", field=placed)
        measure = chosen(self.joint, self.coordinate, signals.known, "joint").measure
        yield self.inertia_of(measure.bodies, measure.values[:3])


@dataclass(frozen=True, eq=False)
class AngleInertia(JointInertia, Force):
    """Kinetic energy ½ inertia · θ̇² of the angle θ of a revolute or cylindrical joint; by its name or placed like it.

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
        if not self.joint:
            i, j = self.frames(poses)
            yield self.inertia_of((i.body, j.body), (i.f, i.g, j.f))

    def inertia_of(self, bodies: tuple[str, ...], vectors: tuple[Any, ...]) -> Primitive:
        """The inertia of the angle."""
        inertia = not_negative(self.inertia, "inertia", "Give it in kg m².")
        return Primitive(elements.AngleInertia, bodies, (*vectors, inertia), "inertia")


@dataclass(frozen=True, eq=False)
class DisplacementInertia(JointInertia, Force):
    """Kinetic energy ½ inertia · u̇² of the displacement u of a translational or cylindrical joint; as `AngleInertia`.

    A rotor with the moment of inertia J that rotates by the angle n u has the inertia n² J.

    Parameters
    ----------
    inertia
        [kg], not negative.
    """

    inertia: Mass = field(kw_only=True)
    coordinate: ClassVar[type[elements.Element]] = DISPLACEMENT

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the inertia of the displacement."""
        if not self.joint:
            i, j = self.frames(poses)
            yield self.inertia_of((i.body, j.body), (i.h, i.s, j.s))

    def inertia_of(self, bodies: tuple[str, ...], vectors: tuple[Any, ...]) -> Primitive:
        """The inertia of the displacement."""
        inertia = not_negative(self.inertia, "inertia", "Give it in kg.")
        return Primitive(elements.DisplacementInertia, bodies, (*vectors, inertia), "inertia")
