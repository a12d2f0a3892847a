"""Drivers, prescribed motions: primitives whose right-hand sides are functions of time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from ... import elements
from ..checks.names import find
from ..coordinate import ANGLE, DISPLACEMENT, Known, chosen
from ..errors import ModelError
from ..forces.force import refuse_ground
from ..geometry.placement import refuse_same_body
from ..geometry.points import GROUND, Point, Solid
from ..geometry.pose import Poses
from ..laws.law import Law, motion_of
from ..measure import In
from ..parity import declared
from ..primitive import Primitive
from ..registry import Part, register


@dataclass(frozen=True, eq=False)
class Driver(Part, ABC):
    """Base class of drivers (prescribed motions); a subclass is a frozen dataclass that yields primitives.

    In a model file its type is the class name without "Driver".
    """

    kinds: ClassVar[dict[str, type[Driver]]] = {}

    name: str

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        register(cls, Driver.kinds)

    @abstractmethod
    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield the primitives for the given poses of the design position and coordinates of joints."""


NAMES = ("x", "y", "z", "e0", "e1", "e2", "e3")


@dataclass(frozen=True, eq=False)
class CoordinateDriver(Driver):
    """A ``coordinate`` of a ``body``, x, y, z [m] of its origin or an Euler parameter, follows a ``motion``."""

    parity = declared(coordinate="refused")

    body: Solid
    coordinate: Literal["x", "y", "z", "e0", "e1", "e2", "e3"]
    motion: Annotated[Law, In("", over="s", states=True)]

    @property
    def law_measures(self) -> dict[str, In]:
        """The quantity of the motion: a length for x, y and z."""
        return {"motion": In("m" if self.coordinate in ("x", "y", "z") else "1", over="s", states=True)}

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield coordinate - f(t)."""
        refuse_ground(self.body.name, "body")
        find(self.body.name, poses, "body")
        if self.coordinate not in NAMES:
            message = f"coordinate must be one of {', '.join(NAMES)}, but is {self.coordinate!r}. Choose one."
            raise ModelError(message, field="coordinate")
        form = [float(name == self.coordinate) for name in NAMES]
        values = (tuple(form[:3]), form[3], tuple(form[4:]), *motion_of(self.motion, "motion"))
        yield Primitive(elements.CoordinateDriver, (self.body.name,), values, self.coordinate)


@dataclass(frozen=True, eq=False)
class AngleDriver(Driver):
    """The angle [rad] of a ``joint`` follows a ``motion``, a number or a function of time, with all revolutions.

    The joint is given by name, ``pin``, or where it has several angles ``hook.angle_i``.
    """

    joint: str
    motion: Annotated[Law, In("rad", over="s", states=True)]

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield θ - f(t)."""
        bodies, values = chosen(self.joint, ANGLE, known, "joint").measure[1:3]
        law = motion_of(self.motion, "motion")
        yield Primitive(elements.AngleDriver, bodies, (*values[:3], *law), "angle")


@dataclass(frozen=True, eq=False)
class DisplacementDriver(Driver):
    """The displacement [m] of a ``joint`` follows a ``motion``, a number or a function of time.

    The joint is given by name, ``slide``, or if it has several displacements ``table.displacement_x``.
    """

    joint: str
    motion: Annotated[Law, In("m", over="s", states=True)]

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield h_i·d - f(t)."""
        bodies, values = chosen(self.joint, DISPLACEMENT, known, "joint").measure[1:3]
        law = motion_of(self.motion, "motion")
        yield Primitive(elements.DisplacementDriver, bodies, (*values[:3], *law), "displacement")


@dataclass(frozen=True, eq=False)
class DistanceDriver(Driver):
    """The distance [m] of ``point_i`` and ``point_j`` follows a ``motion``, a number or a function of time.

    It may not vanish.
    """

    point_i: Point
    point_j: Point
    motion: Annotated[Law, In("m", over="s", states=True)]

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield d·d - f(t)²."""
        i, j = self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j")
        refuse_same_body(i.body, j.body, "point_j")
        values = (i.s, j.s, *motion_of(self.motion, "motion"))
        yield Primitive(elements.DistanceDriver, (i.body, j.body), values, "distance")


ORIGIN = (0.0, 0.0, 0.0)
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, eq=False)
class PointDriver(Driver):
    """Global coordinates ``x``, ``y``, ``z`` [m] of a ``point`` follow functions of time; those left out are free."""

    parity = declared(y="odd")

    point: Point
    x: Annotated[Law | None, In("m", over="s", states=True)] = None
    y: Annotated[Law | None, In("m", over="s", states=True)] = None
    z: Annotated[Law | None, In("m", over="s", states=True)] = None

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield e·P - f(t) for each given coordinate."""
        at = self.point.resolve(poses, "point")
        refuse_ground(at.body, "point")
        paths = {
            name: path for name, path in (("x", self.x), ("y", self.y), ("z", self.z)) if path is not None
        }
        if not paths:
            raise ModelError("has no path. Give at least one of x, y and z.", field="x")
        for name, path in paths.items():
            values = (AXES[name], ORIGIN, at.s, *motion_of(path, name))
            yield Primitive(elements.DisplacementDriver, (GROUND, at.body), values, name)
