"""Unilateral contacts: a sphere or a point on a plane, and stops of a distance, a displacement and an angle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

from ... import elements
from ..coordinate import angle
from ..errors import ModelError
from ..geometry.placement import AboutAxis, points_apart, refuse_same_body
from ..geometry.points import Frame, Point
from ..geometry.pose import Poses
from ..measure import Angle, In, Length, Ratio
from ..parity import AXIAL, declared
from ..primitive import Primitive
from ..quantity import not_negative, number, positive, regularization
from ..show import show
from .force import Force


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactLaw:
    """Normal force stiffness · depthⁿ (1 + damping · rate of the depth), after Hunt and Crossley.

    Parameters
    ----------
    stiffness
        Greater than 0 [N/mⁿ].
    exponent
        n, at least 1; 3/2 for two elastic spheres.
    damping
        [s/m] An impact at the small speed u comes back with about u (1 − ⅔ damping · u), at any speed with u' of
        damping · u − ln(1 + damping · u) = −damping · u' − ln(1 − damping · u').
    rounding
        Depth [m] over which the force sets in smoothly, centred on first touch; beyond half of it the law is exact, as
        long as the depth falls no faster than 7/8 of 1/damping. Faster, the force is rounded towards zero: up to
        damping · u = 2.4 (36 % of the speed comes back) nothing of this is met, at 5 u' is 1.1 % too large.
    """

    stiffness: Annotated[float, In("")]  # any unit: it depends on the exponent
    exponent: Ratio = 1.0
    damping: Annotated[float, In("s/m")] = 0.0
    rounding: Length = 1e-4

    def contact(self) -> tuple[float, float, float, float]:
        """Return the checked numbers in the elements' order."""
        stiffness = positive(self.stiffness, "stiffness", "Give the stiffness in N/m.")
        exponent = number(self.exponent, "exponent")
        if exponent < 1.0:
            raise ModelError(
                f"exponent must be at least 1, but is {show(exponent)}. Give 1 for a linear law.",
                field="exponent",
            )
        damping = not_negative(self.damping, "damping", "Give it in s/m.")
        return stiffness, exponent, damping, positive(self.rounding, "rounding", "Give a small depth.")


@dataclass(frozen=True, eq=False)
class SphereContact(ContactLaw, Force):
    """Contact of a sphere on one body with a plane on another, with friction.

    Parameters
    ----------
    center
        The sphere's centre.
    plane
        A frame whose origin is in the plane and whose third axis is its normal, towards the sphere.
    radius
        [m] 0 for a point.
    mu
        Coefficient of friction, after Coulomb: it acts against the sliding speed u as μ N u/√(u² + creep²).
    creep
        [m/s] Speed of regularization: a sticking contact creeps at a speed below this value.
    """

    parity = declared(plane="polar")

    center: Point
    plane: Frame
    radius: Length = 0.0
    mu: Ratio = 0.0
    creep: Annotated[float, In("m/s")] = 1e-3

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        center, plane = self.center.resolve(poses, "center"), self.plane.resolve(poses, "plane")
        refuse_same_body(center.body, plane.body, "plane")
        radius = not_negative(self.radius, "radius", "Give the radius in m, or 0 for a point.")
        mu = not_negative(self.mu, "mu", "Give the coefficient of friction.")
        creep = regularization(self.creep)
        values = (center.s, plane.s, plane.h, radius, *self.contact(), mu, creep)
        yield Primitive(elements.SphereContact, (center.body, plane.body), values, "contact")


@dataclass(frozen=True, eq=False, kw_only=True)
class Limits:
    """The two limits of a stop, of which one may be missing."""

    lower: Length | None = None
    upper: Length | None = None

    def limits(self) -> Iterator[tuple[str, float, float]]:
        """Yield name, limit and sign of each that is given."""
        given = [(name, getattr(self, name), sign) for name, sign in (("lower", -1.0), ("upper", 1.0))]
        found = [(name, number(value, name), sign) for name, value, sign in given if value is not None]
        if not found:
            raise ModelError("has no limit. Give lower, upper or both.", field="lower")
        if len(found) == 2 and found[0][1] >= found[1][1]:
            raise ModelError(
                "has a lower limit that is not below the upper one. Exchange them.", field="lower"
            )
        yield from found


@dataclass(frozen=True, eq=False)
class LengthStop(Limits, ContactLaw, Force):
    """Stop that limits the distance of two points to ``lower`` … ``upper`` [m], such as a rope or a bump stop.

    Beyond a limit, the force is stiffness · depthⁿ (1 + damping · rate of the depth), never a pull.

    Parameters
    ----------
    point_i, point_j
        A point on each of two bodies, which may not coincide in the design position.
    """

    point_i: Point
    point_j: Point

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield one stop for each limit."""
        i, j = points_apart(self.point_i, self.point_j, poses)
        for name, limit, sign in self.limits():
            values = (i.s, j.s, limit, sign, *self.contact())
            yield Primitive(elements.LengthStop, (i.body, j.body), values, name)


@dataclass(frozen=True, eq=False)
class DisplacementStop(Limits, ContactLaw, AboutAxis, Force):
    """Stop that limits the displacement of a translational or cylindrical joint to ``lower`` … ``upper`` [m].

    The displacement is that of body j along the axis of body i. Placed by a global ``point`` [m] and ``axis`` it
    starts at 0.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield one stop for each limit."""
        i, j = self.frames(poses)
        for name, limit, sign in self.limits():
            values = (i.h, i.s, j.s, limit, sign, *self.contact())
            yield Primitive(elements.DisplacementStop, (i.body, j.body), values, name)


@dataclass(frozen=True, eq=False)
class AngleStop(Limits, ContactLaw, AboutAxis, Force):
    """Stop that limits the angle of a revolute or cylindrical joint to ``lower`` … ``upper`` [rad], with revolutions.

    The angle is that of an RSDA: of body j relative to body i about the axis, right-handed. Beyond a limit, the torque
    is stiffness · depthⁿ (1 + damping · rate of the depth).

    Parameters
    ----------
    stiffness
        Greater than 0 [N m/radⁿ].
    damping
        [s/rad] As in `LengthStop`, with angular speeds.
    rounding
        Depth [rad] over which the torque sets in smoothly, as in `LengthStop`.
    """

    parity = AXIAL

    lower: Angle | None = field(default=None, kw_only=True)
    upper: Angle | None = field(default=None, kw_only=True)
    damping: Annotated[float, In("s/rad")] = field(default=0.0, kw_only=True)
    rounding: Angle = field(default=1e-3, kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield one stop for each limit."""
        i, j = self.frames(poses)
        for name, limit, sign in self.limits():
            values = (i.f, i.g, i.h, j.f, j.h, limit, sign, *self.contact(), angle(i, j, poses).start)
            yield Primitive(elements.AngleStop, (i.body, j.body), values, name)
