"""Contact of a sphere, or a point, with a plane."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..frame import Frame
from ..measure import In, Length, Ratio
from ..placement import refuse_same_body
from ..point import Point
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import not_negative, positive
from .contact import ContactLaw
from .force import Force


@dataclass(frozen=True, eq=False)
class SphereContact(ContactLaw, Force):
    """A sphere on one body touches a plane on another, with friction.

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
        [m/s] Speed of regularization. What would stick creeps, the slower the smaller this is.
    """

    center: Point
    plane: Frame
    radius: Length = 0.0
    mu: Ratio = 0.0
    creep: Annotated[float, In("m/s")] = 1e-3

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the contact."""
        center, plane = self.center.resolve(poses, "center"), self.plane.resolve(poses, "plane")
        refuse_same_body(center.body, plane.body, "plane")
        radius = not_negative(self.radius, "radius", "give the radius in m, or 0 for a point")
        mu = not_negative(self.mu, "mu", "give the coefficient of friction")
        creep = positive(self.creep, "creep", "give a small speed in m/s")
        values = (center.s, plane.s, plane.h, radius, *self.contact(), mu, creep)
        yield Primitive(elements.SphereContact, (center.body, plane.body), values, "contact")
