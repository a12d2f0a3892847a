"""A tyre as a vertical spring and damper between a wheel centre and a flat road."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..measure import In, Length
from ..point import Point
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import not_negative, number, positive
from .force import Force, refuse_ground


@dataclass(frozen=True, eq=False)
class Tyre(Force):
    """A vertical force k (radius − (z − road)) − c ż at ``point``, without lift-off.

    Parameters
    ----------
    point
        The wheel's centre; z is its global height [m].
    k, c
        Stiffness [N/m] and damping [N s/m].
    radius
        Of the unloaded wheel [m].
    road
        Height of the road [m].
    """

    point: Point
    k: Annotated[float, In("N/m")]
    c: Annotated[float, In("N s/m")]
    radius: Length
    road: Length = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the tyre."""
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        road = number(self.road, "road")
        k = positive(self.k, "k", "give the stiffness in N/m")
        c = not_negative(self.c, "c", "give the damping in N s/m")
        radius = positive(self.radius, "radius", "give the unloaded radius in m")
        yield Primitive(elements.Tyre, (point.body,), (point.s, k, c, radius, road), "tyre")
