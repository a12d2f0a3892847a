"""Bodies' points and frames, and the functions of coordinates that they define."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, Literal, NamedTuple, ParamSpec, TypeAlias, get_args

import numpy as np

from ... import elements
from ..checks.calls import CallCheck
from ..checks.names import find
from ..errors import ModelError
from ..expression.formula_value import formula_value
from ..expression.tree import Expression
from ..primitive import Primitive
from ..quantity import Array, Vec3, Vector, direction, plain, triple, vector
from ..show import quote, show
from .pose import GROUND_POSE, Pose, Poses
from .rotation import perpendicular, skew

Arguments = ParamSpec("Arguments")
GROUND = "ground"  # reserved name, body number 0


def _with_three_coordinates(method: Callable[Arguments, Point]) -> Callable[Arguments, Point]:
    """Refuse a point that is not called with three numbers."""

    @wraps(method)
    def called(*given: Arguments.args, **named: Arguments.kwargs) -> Point:
        if len(given) + len(named) != 4:
            name = getattr(given[0], "name", "body")
            message = f"{method.__name__} of {quote(str(name))} takes three coordinates"
            raise TypeError(f"{message}. Write {name}.{method.__name__}(x, y, z).")
        return method(*given, **named)

    return called


@dataclass(frozen=True, eq=False)
class Solid(metaclass=CallCheck):
    """A named carrier of points and frames. Models refer to it by its name."""

    name: str

    def pose(self) -> Pose:
        """Return the pose in the design position."""
        return GROUND_POSE

    @_with_three_coordinates
    def point(self, x: float, y: float, z: float) -> Point:
        """Return the point fixed at (x, y, z) [m] in body axes."""

        return Point(self, (x, y, z))

    @_with_three_coordinates
    def global_point(self, x: float, y: float, z: float) -> Point:
        """Return the point of this body that is at the global (x, y, z) [m] in the design position."""

        return Point(self, (x, y, z), "global")

    def frame(self, point: Point | Vector, *, x: Vector | None = None, z: Vector | None = None) -> Frame:
        """Return a frame fixed to this body with its origin at ``point``.

        Parameters
        ----------
        point
            Body coordinates [m], or a Point of this body. At a global point, ``x`` and ``z``
            are global directions too.
        x, z
            Directions of the frame's axes f and h, any length, perpendicular. With ``z`` alone the
            first axis is any perpendicular, with neither the axes are the body's.
        """

        return Frame(point if isinstance(point, Point) else Point(self, point), x=x, z=z)


@dataclass(frozen=True, eq=False)
class Ground(Solid):
    """The global frame: it does not move, has no coordinates, and is body number 0."""

    name: str = GROUND


ground = Ground()


def refuse_no_solid(value: object, field: str) -> None:
    """Raise a ModelError if a value is neither a body nor the ground, such as a body's name."""
    if not isinstance(value, Solid):
        message = f"{field} must be on a body, but is {show(value)}. Give the Body object (or sarrus.ground)."
        raise ModelError(message, field=field)


Axes: TypeAlias = Literal["body", "global"]


def refuse_other_axes(axes: object) -> None:
    """Raise a ModelError for axes that are neither those of the body nor global."""
    if not isinstance(axes, str) or axes not in ("global", "body"):
        message = f'axes must be "global" or "body", but is {show(axes)}. Choose one of them.'
        raise ModelError(message, field="axes")


class LocalPoint(NamedTuple):
    """A point as the elements take it: the body's name and s′ in body axes [m]."""

    body: str
    s: Vec3

    def position(self, poses: Poses) -> Array:
        """Return the global position in the design position. (3,) [m]"""
        return poses[self.body].global_point(np.array(self.s))


@dataclass(frozen=True, eq=False)
class Point:
    """A point fixed to a body.

    Parameters
    ----------
    body
        The carrier.
    coordinates
        Three numbers [m].
    axes
        ``"body"``: from the body's origin in body axes. ``"global"``: where the point is in the
        design position.
    """

    body: Solid
    coordinates: Vector
    axes: Axes = "body"

    def __post_init__(self) -> None:
        """Refuse other axes; coordinates of hardpoints become numbers."""
        refuse_other_axes(self.axes)
        if isinstance(self.coordinates, tuple) and any(map(_is_constant, self.coordinates)):
            known = tuple(formula_value(x, "m") if _is_constant(x) else x for x in self.coordinates)
            object.__setattr__(self, "coordinates", known)

    def __repr__(self) -> str:
        axes = ', "global"' if self.axes == "global" else ""
        return f"Point({getattr(self.body, 'name', self.body)}, {self.coordinates!r}{axes})"

    @property
    def label(self) -> str:
        """The body's name, and the coordinates unless it is the origin: ``tool(0.1, 0, 0)``."""
        at = vector(self.coordinates, "point")
        if self.axes == "body" and not any(at):
            return self.body.name
        place = ", ".join(f"{x:g}" for x in at)
        return f"{self.body.name}({place}{' global' * (self.axes == 'global')})"

    def resolve(self, poses: Poses, field: str) -> LocalPoint:
        """Return the point in body axes."""
        refuse_no_solid(self.body, field)
        given = vector(self.coordinates, field)
        pose = find(self.body.name, poses, field)
        local = given if self.axes == "body" else triple(pose.local_point(np.array(given)))
        return LocalPoint(self.body.name, local)

    def __getitem__(self, axes: Any) -> tuple[PointCoordinate, ...]:
        """Return global coordinates of the point as functions: ``point["x", "y"]``.

        Raises
        ------
        ModelError
            For other names; a point is no sequence of coordinates.
        """

        names = axes if isinstance(axes, tuple) else (axes,)
        for name in names:
            check_axis(name)
        return tuple(PointCoordinate(self, name) for name in names)


def _is_constant(value: object) -> bool:
    return isinstance(value, Expression) and not value.names()


PERPENDICULAR = 1e-6  # [-] how far from 0 the product of two "perpendicular" unit vectors may be


class LocalFrame(NamedTuple):
    """A frame as the elements take it: body name, origin s′ [m], unit axes f′, g′, h′, in body axes."""

    body: str
    s: Vec3
    f: Vec3
    g: Vec3
    h: Vec3


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame on a body; ``x`` and ``z`` are in the axes that its point is given in."""

    point: Point
    x: Vector | None = None
    z: Vector | None = None

    def resolve(self, poses: Poses, field: str, axis: str = "") -> LocalFrame:
        """Return the frame in body axes; errors are about ``field``, or ``axis`` for its directions."""
        if not isinstance(self.point, Point):
            raise ModelError(
                f"{field} is a frame at {show(self.point)}, which is no point. Give body.frame((x, y, z)), with "
                "directions x=, z= if they are wanted.",
                field=field,
            )
        origin = self.point.resolve(poses, field)
        axes = frame_axes(self.x, self.z, axis or field)
        if self.point.axes == "global":
            axes = find(origin.body, poses, field).A.T @ axes
        return LocalFrame(*origin, triple(axes[:, 0]), triple(axes[:, 1]), triple(axes[:, 2]))


def frame_axes(x: Vector | None, z: Vector | None, field: str) -> Array:
    """Return the matrix with the unit columns f, g, h of a frame with f along ``x`` and h along ``z``."""
    if x is None and z is None:
        return np.eye(3)
    if z is None:
        f = direction(x, field)
        h = perpendicular(f)
    else:
        h = direction(z, field)
        f = perpendicular(h) if x is None else _across(direction(x, field), h, field)
    return np.column_stack([f, skew(h) @ f, h])


def _across(f: Array, h: Array, field: str) -> Array:
    slope = plain(f @ h)
    if abs(slope) > PERPENDICULAR:
        message = (
            f"{field} has axes x and z that are not perpendicular, the cosine between them is {slope:.6g}"
        )
        raise ModelError(f"{message}. Leave x out, or make it perpendicular to z.", field=field)
    across: Array = f - slope * h
    return across / np.linalg.norm(across)


AxisName = Literal["x", "y", "z"]
AXES: tuple[AxisName, ...] = get_args(AxisName)
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
        return rotation_about(self.axis, self.body.name)


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


def rotation_about(axis: AxisName, body: str) -> Primitive:
    """The argument of a body axis in the plane of the two global ones normal to an axis."""
    first, second = NEXT[axis]
    values = (UNIT[first], UNIT[second], UNIT[first], 0.0, 0.0)
    return Primitive(elements.Angle, (GROUND, body), values, f"rotation_{axis}")


def check_axis(axis: str) -> None:
    if axis not in AXES:
        raise ModelError(f"axis must be x, y or z, but is {axis!r}. Choose one.", field="axis")
