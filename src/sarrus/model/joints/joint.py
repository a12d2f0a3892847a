"""Base class of joints: a name and a list of primitives. It contains no formula of mechanics."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from ... import elements
from ..coordinate import Coordinate, Known
from ..geometry.points import LocalFrame, LocalPoint
from ..geometry.pose import Poses
from ..primitive import Primitive
from ..quantity import Vec3
from ..registry import Part, register


@dataclass(frozen=True, eq=False)
class Joint(Part, ABC):
    """Base class of joints; a subclass is a frozen dataclass that yields constraint primitives.

    The model file and its JSON Schema use the fields of the subclass; a new joint needs no other declaration.
    """

    kinds: ClassVar[dict[str, type[Joint]]] = {}

    name: str

    def __init_subclass__(cls, abstract: bool = False, **options: Any) -> None:
        super().__init_subclass__(**options)
        if not abstract:
            register(cls, Joint.kinds)

    @abstractmethod
    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the primitives for the given initial poses."""

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angles and displacements of the joint that can be output, driven and coupled."""
        yield from ()

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield the primitives that need the coordinates of other joints."""
        yield from ()


def spherical(i: LocalPoint | LocalFrame, j: LocalPoint | LocalFrame) -> Primitive:
    """The two points coincide: Φˢ, Eq. (29)."""
    return Primitive(elements.Spherical, (i.body, j.body), (i.s, j.s), "point")


def dot1(label: str, i: LocalFrame, j: LocalFrame, a_i: Vec3, a_j: Vec3) -> Primitive:
    """Two body-fixed vectors are perpendicular: Φ^d1, Eq. (26)."""
    return Primitive(elements.Dot1, (i.body, j.body), (a_i, a_j), label)


def dot2(label: str, i: LocalFrame, j: LocalFrame, a_i: Vec3) -> Primitive:
    """The line between the points is perpendicular to a vector of body i: Φ^d2, Eq. (88)."""
    return Primitive(elements.Dot2, (i.body, j.body), (a_i, i.s, j.s), label)
