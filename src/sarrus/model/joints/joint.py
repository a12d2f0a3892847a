"""Base class of joints: a name and a list of primitives. It contains no formula of mechanics."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from ... import elements
from ..coordinate import Coordinate, Known, angle, displacement
from ..geometry.placement import Frames
from ..geometry.points import LocalFrame, LocalPoint
from ..geometry.pose import Poses
from ..primitive import Primitive
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
        """Yield the primitives for the given poses of the design position."""

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angles and displacements of the joint that can be output, driven and coupled."""
        yield from ()

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield the primitives that need the coordinates of other joints."""
        yield from ()


class FramedJoint(Joint, abstract=True):
    """Base class of joints between two frames, which name their constraints and the coordinates that these leave.

    Attributes
    ----------
    constraints
        Labels of the basic constraints, see `basic_constraints`.
    free
        Coordinates that can be output, driven and coupled: ``angle``, from f_i to f_j about h_i; ``displacement``, of
        P_j from P_i along h_i; ``displacement_x``, ``displacement_y`` and ``displacement_z``, along f_i, g_i and h_i.
    """

    constraints: ClassVar[tuple[str, ...]] = ()
    free: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes."""

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the basic constraints."""
        yield from basic_constraints(*self.frames(poses), *self.constraints)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        i, j = self.frames(poses)
        axes = {"displacement_x": i.f, "displacement_y": i.g}
        for name in self.free:
            if name == "angle":
                yield angle(i, j, poses)
            else:
                yield displacement(i, j, poses, axis=axes.get(name), name=name)


def basic_constraints(
    i: LocalPoint | LocalFrame, j: LocalPoint | LocalFrame, *labels: str
) -> Iterator[Primitive]:
    """Yield the basic constraints of two frames, or of two points, with these labels.

    ``point``: the two points coincide, Φˢ, Eq. (29). ``f_i.h_j``: a vector of each body, which are perpendicular, Φ^d1,
    Eq. (26). ``f_i.d``, ``h_j.d``: the line between the points is perpendicular to a vector of a body, Φ^d2, Eq. (88).
    """
    for label in labels:
        first, _, second = label.partition(".")
        a, b = (j, i) if first.endswith("_j") else (i, j)
        bodies = a.body, b.body
        if label == "point":
            yield Primitive(elements.Spherical, bodies, (a.s, b.s), label)
        elif second == "d":
            yield Primitive(elements.Dot2, bodies, (getattr(a, first[0]), a.s, b.s), label)
        else:
            yield Primitive(elements.Dot1, bodies, (getattr(a, first[0]), getattr(b, second[0])), label)
