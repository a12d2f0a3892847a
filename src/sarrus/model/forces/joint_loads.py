"""Friction and inertia of joint coordinates."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

from ... import elements
from ..coordinate import ANGLE, DISPLACEMENT, angle, chosen, displacement
from ..errors import ModelError
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..measure import In, Length, Mass, Ratio
from ..parity import AXIAL
from ..primitive import Primitive
from ..quantity import not_negative, positive
from ..signals import Signals
from .force import Force


@dataclass(frozen=True, eq=False, kw_only=True)
class DryFriction:
    """Friction load · [μ + (μ_s − μ) exp(−(u/stribeck)²)] tanh(u/creep) + viscous · u against the sliding speed u.

    Parameters
    ----------
    load
        Normal load [N], constant: the joint's reaction is not used, so where it varies much, so does the error.
    mu
        Coefficient of sliding friction μ.
    mu_static
        Coefficient of sticking friction μ_s; left out, it is ``mu``.
    stribeck
        [m/s] Speed over which one falls to the other.
    creep
        [m/s] Speed of regularization: what would stick creeps, the slower the smaller this is.
    viscous
        [N s/m]
    """

    load: Annotated[float, In("N")]
    mu: Ratio
    mu_static: Ratio | None = None
    stribeck: Annotated[float, In("m/s")] = 1e-2
    creep: Annotated[float, In("m/s")] = 1e-3
    viscous: Annotated[float, In("N s/m")] = 0.0

    def friction(self) -> tuple[float, ...]:
        """Return the checked numbers in the elements' order."""
        mu = not_negative(self.mu, "mu", "Give the coefficient of friction.")
        mu_static = (
            mu if self.mu_static is None else not_negative(self.mu_static, "mu_static", "Give a coefficient.")
        )
        return (
            not_negative(self.load, "load", "Give the normal load in N."),
            mu,
            mu_static,
            positive(self.stribeck, "stribeck", "Give a speed in m/s."),
            positive(self.creep, "creep", "Give a small speed in m/s."),
            not_negative(self.viscous, "viscous", "Give it in N s/m."),
        )


@dataclass(frozen=True, eq=False)
class AngleFriction(DryFriction, AboutAxis, Force):
    """Dry friction of a pin of ``radius`` [m] in a revolute joint; its position is given as that of the joint."""

    parity = AXIAL

    radius: Length = field(kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        i, j = self.frames(poses)
        radius = positive(self.radius, "radius", "Give the pin's radius in m.")
        yield Primitive(elements.AngleFriction, (i.body, j.body), (i.h, radius, *self.friction()), "friction")


@dataclass(frozen=True, eq=False)
class DisplacementFriction(DryFriction, AboutAxis, Force):
    """Dry friction in a translational or cylindrical joint; its position is given as that of the joint."""

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        i, j = self.frames(poses)
        yield Primitive(
            elements.DisplacementFriction, (i.body, j.body), (i.h, j.s, *self.friction()), "friction"
        )


PLACEMENT = ("body_i", "body_j", "point", "axis", "frame_i", "frame_j")


@dataclass(frozen=True, eq=False, repr=False)
class JointInertia(AboutAxis):
    """Inertia of a joint's coordinate.

    Parameters
    ----------
    joint
        The joint by name, ``pin``, or one of its coordinates, ``sleeve.angle``, in place of bodies, point, axis or
        frames.
    """

    joint: str = field(default="", kw_only=True)
    coordinate: ClassVar[type[elements.Element]] = ANGLE  # the element that measures it
    element: ClassVar[type[elements.Element]] = elements.AngleInertia
    unit: ClassVar[str] = "kg m²"

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the inertia of a joint that is placed by bodies or frames."""
        if not self.joint:
            measured = angle if self.coordinate is ANGLE else displacement
            yield self._inertia_along(measured(*self.frames(poses), poses).measure)

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the inertia of a joint that is given by name."""
        if not self.joint:
            return
        placed = next((name for name in PLACEMENT if getattr(self, name) is not None), None)
        if placed is not None:
            raise ModelError(f"has both joint and {placed}. Leave one of them out.", field=placed)
        yield self._inertia_along(chosen(self.joint, self.coordinate, signals.known, "joint").measure)

    def _inertia_along(self: Any, measure: Primitive) -> Primitive:
        """Return the element with the three vectors that measure the coordinate."""
        inertia = not_negative(self.inertia, "inertia", f"Give it in {self.unit}.")
        return Primitive(self.element, measure.bodies, (*measure.values[:3], inertia), "inertia")


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

    parity = AXIAL

    inertia: Annotated[float, In("kg m^2")] = field(kw_only=True)


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
    coordinate = DISPLACEMENT
    element = elements.DisplacementInertia
    unit = "kg"
