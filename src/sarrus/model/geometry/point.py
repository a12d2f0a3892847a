"""A point fixed to a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ..checks.names import find
from ..errors import ModelError
from ..quantity import Array, Vec3, Vector, triple, vector
from ..show import show
from .pose import Poses
from .solid import Solid, refuse_no_solid

if TYPE_CHECKING:
    from .function import PointCoordinate

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
        """Return the global position in the initial pose. (3,) [m]"""
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
        initial pose.
    """

    body: Solid
    coordinates: Vector
    axes: Axes = "body"

    def __post_init__(self) -> None:
        """Refuse other axes."""
        refuse_other_axes(self.axes)

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
        from .function import PointCoordinate, check_axis

        names = axes if isinstance(axes, tuple) else (axes,)
        for name in names:
            check_axis(name)
        return tuple(PointCoordinate(self, name) for name in names)
