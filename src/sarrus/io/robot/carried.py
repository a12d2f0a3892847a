"""A link with points and frames: they are given in its axes and stored in those of its body."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from ...model.bodies.solid import Solid
from ...model.geometry.frame import Frame
from ...model.geometry.point import Point
from ...model.geometry.pose import GROUND_POSE, Pose
from ...model.quantity import Vector, vector

Part = TypeVar("Part")
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Carried(Solid):
    """A link at ``place``, in the axes of the body that carries it; often the body itself, or the ground."""

    body: Solid
    place: Pose = GROUND_POSE

    def pose(self) -> Pose:
        """Return the initial pose of the link."""
        from ...model.geometry.motion import compose

        return compose(self.body.pose(), self.place)

    def point(self, x: float, y: float, z: float) -> Point:
        """Return the point at (x, y, z) [m] in link axes, on the body."""
        return Point(self.body, self.place.global_point(np.array([x, y, z])))

    def global_point(self, x: float, y: float, z: float) -> Point:
        """Return the point that is at the global (x, y, z) [m] in the initial pose, on the body."""
        return self.body.global_point(x, y, z)

    def frame(self, point: Point | Vector, *, x: Vector | None = None, z: Vector | None = None) -> Frame:
        """Return a frame at ``point``, with directions in link axes; by default the link's own axes."""
        frame: Frame = on_body(super().frame(point, x=x, z=z))
        return frame


def on_body(value: Any) -> Any:
    """Return a point, frame or link as one of the body that carries it; anything else unchanged."""
    if isinstance(value, Point) and isinstance(value.body, Carried):
        return _point_on_body(value, value.body)
    if isinstance(value, Frame) and isinstance(value.point.body, Carried):
        return _frame_on_body(value, value.point.body)
    return value.body if isinstance(value, Carried) else value


def part_on_bodies(part: Part) -> Part:
    """Return a joint or force whose points, frames and bodies are those of the carrying bodies."""
    held: Any = part
    return replace(held, **{f.name: on_body(getattr(part, f.name)) for f in fields(held)})  # type: ignore[no-any-return]


def _point_on_body(point: Point, link: Carried) -> Point:
    if point.axes == "global":
        return Point(link.body, point.coordinates, "global")
    return link.point(*vector(point.coordinates, "point"))


def _frame_on_body(frame: Frame, link: Carried) -> Frame:
    if frame.point.axes == "global":
        return Frame(on_body(frame.point), x=frame.x, z=frame.z)
    x, z = (frame.x, frame.z) if _has_axes(frame) else (X, Z)
    return Frame(on_body(frame.point), x=_turned(x, link), z=_turned(z, link))


def _has_axes(frame: Frame) -> bool:
    return frame.x is not None or frame.z is not None


def _turned(direction: Vector | None, link: Carried) -> Vector | None:
    return None if direction is None else link.place.A @ np.array(vector(direction, "frame"))
