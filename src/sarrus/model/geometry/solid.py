"""Anything that points and frames can be fixed to: a body, or the ground."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, ParamSpec

from ..checks.calls import Called
from ..errors import ModelError
from ..quantity import Vector
from ..show import quote, show
from .pose import GROUND_POSE, Pose

if TYPE_CHECKING:
    from .frame import Frame
    from .point import Point

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
class Solid(metaclass=Called):
    """A named carrier of points and frames. Models refer to it by its name."""

    name: str

    def pose(self) -> Pose:
        """Return the initial pose."""
        return GROUND_POSE

    @_with_three_coordinates
    def point(self, x: float, y: float, z: float) -> Point:
        """Return the point fixed at (x, y, z) [m] in body axes."""
        from .point import Point

        return Point(self, (x, y, z))

    @_with_three_coordinates
    def global_point(self, x: float, y: float, z: float) -> Point:
        """Return the point of this body that is at the global (x, y, z) [m] in the initial pose."""
        from .point import Point

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
        from .frame import Frame
        from .point import Point

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
