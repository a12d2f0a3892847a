"""One-sided stops of a distance, of a joint's travel and of a joint's angle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

from ... import elements
from ..coordinate import angle
from ..errors import ModelError
from ..measure import Angle, In, Length
from ..placement import AboutAxis, points_apart
from ..point import Point
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import number
from .contact import ContactLaw
from .force import Force


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
            raise ModelError("has no limit; give lower, upper or both", field="lower")
        if len(found) == 2 and found[0][1] >= found[1][1]:
            raise ModelError(
                "has a lower limit that is not below the upper one; exchange them", field="lower"
            )
        yield from found


@dataclass(frozen=True, eq=False)
class LengthStop(Limits, ContactLaw, Force):
    """Keeps the distance of two points between ``lower`` and ``upper`` [m], as a rope or a bump stop does.

    Beyond a limit, the force is stiffness · depthⁿ (1 + damping · rate of the depth), never a pull.
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
class TravelStop(Limits, ContactLaw, AboutAxis, Force):
    """Keeps the travel of a translational or cylindrical joint between ``lower`` and ``upper`` [m].

    The travel is that of body j along the axis of body i. Placed by a global ``point`` [m] and ``axis`` it starts at 0.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield one stop for each limit."""
        i, j = self.frames(poses)
        for name, limit, sign in self.limits():
            values = (i.h, i.s, j.s, limit, sign, *self.contact())
            yield Primitive(elements.TravelStop, (i.body, j.body), values, name)


@dataclass(frozen=True, eq=False)
class AngleStop(Limits, ContactLaw, AboutAxis, Force):
    """Keeps the angle of a revolute or cylindrical joint between ``lower`` and ``upper`` [rad], revolutions included.

    The angle is that of an RSDA: of body j relative to body i about the axis, right-handed.
    """

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
