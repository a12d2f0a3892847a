"""Functions of a mechanism's position for analyses: a coordinate of a point, a length, a rotation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal, get_args

from ... import elements
from ..errors import ModelError
from ..primitive import Primitive
from .point import Point
from .pose import Poses
from .solid import GROUND, Solid

AxisName = Literal["x", "y", "z"]
UNIT = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
NEXT = {
    "x": ("y", "z"),
    "y": ("z", "x"),
    "z": ("x", "y"),
}  # the axes that a turn about an axis takes into each other
ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Function(ABC):
    """A number that depends on the position of a mechanism, under a name."""

    @property
    @abstractmethod
    def label(self) -> str:
        """The name in results."""

    @abstractmethod
    def primitive(self, poses: Poses) -> Primitive:
        """Return the element that measures it."""


@dataclass(frozen=True, eq=False)
class PointCoordinate(Function):
    """A global coordinate [m] of a ``point``, along the ``axis`` x, y or z."""

    point: Point
    axis: AxisName
    name: str = ""

    @property
    def label(self) -> str:
        """The given name, or that of the point with the axis: ``tool.x`` for the origin, ``tool(0.1, 0, 0).x``."""
        return self.name or f"{self.point.label}.{self.axis}"

    def primitive(self, poses: Poses) -> Primitive:
        """Return e·P as a displacement from the ground's origin."""
        check_axis(self.axis)
        at = self.point.resolve(poses, "point")
        return Primitive(
            elements.Displacement, (GROUND, at.body), (UNIT[self.axis], ORIGIN, at.s, 0.0), self.axis
        )


@dataclass(frozen=True, eq=False)
class Rotation(Function):
    """Rotation angle [rad] of a ``body`` about a global ``axis``, for planar mechanisms.

    It is the angle of the body's next axis (x for z) in the plane normal to the global axis.
    """

    body: Solid
    axis: AxisName = "z"
    name: str = ""

    @property
    def label(self) -> str:
        """The given name, or that of the body with the axis."""
        return self.name or f"{self.body.name}.rotation_{self.axis}"

    def primitive(self, poses: Poses) -> Primitive:
        """Return the argument of a body axis in the plane of two global ones."""
        check_axis(self.axis)
        first, second = NEXT[self.axis]
        values = (UNIT[first], UNIT[second], UNIT[first], 0.0, 0.0)
        return Primitive(elements.Angle, (GROUND, self.body.name), values, f"rotation_{self.axis}")


@dataclass(frozen=True, eq=False)
class Length(Function):
    """Distance [m] of ``point_i`` and ``point_j``, for example the length of a leg that has no bodies.

    Left out, its ``name`` is made of those of the bodies.
    """

    point_i: Point
    point_j: Point
    name: str = ""

    @property
    def label(self) -> str:
        """The given name, or that of the bodies."""
        return self.name or f"{self.point_i.body.name}-{self.point_j.body.name}"

    def primitive(self, poses: Poses) -> Primitive:
        """Return the square of the distance."""
        i, j = self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j")
        return Primitive(elements.Distance, (i.body, j.body), (i.s, j.s, 0.0), "length")


def check_axis(axis: str) -> None:
    if axis not in get_args(AxisName):
        raise ModelError(f"axis must be x, y or z, but is {axis!r}. Choose one.", field="axis")
