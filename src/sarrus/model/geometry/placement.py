"""Two frames of a joint: from a global point and directions, or given one on each body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from ..errors import ModelError
from ..measure import Direction, Place
from ..quantity import SMALLEST_LENGTH, Vector, triple
from ..show import quote
from . import rotation
from .points import Frame, LocalFrame, LocalPoint, Point, Solid
from .pose import Poses


class Frames(NamedTuple):
    """The joint's frame on body i and on body j."""

    i: LocalFrame
    j: LocalFrame

    def parallel(self) -> tuple[float, Vector]:
        """Return the Euler parameters of body j in body i where both frames are parallel, the first one apart."""
        i, j = (np.column_stack([one.f, one.g, one.h]) for one in self)
        e_0, *e = rotation.parameters(i @ j.T)
        return e_0, triple(np.array(e))


class Points(NamedTuple):
    """The joint's point on body i and on body j."""

    i: LocalPoint
    j: LocalPoint


def points_apart(point_i: Point, point_j: Point, poses: Poses) -> Points:
    """Return two points of different bodies in body axes, or raise a ModelError if they coincide at the start."""
    points = Points(point_i.resolve(poses, "point_i"), point_j.resolve(poses, "point_j"))
    refuse_same_body(points.i.body, points.j.body, "point_j")
    apart = points.j.position(poses) - points.i.position(poses)
    if np.linalg.norm(apart) < SMALLEST_LENGTH:
        message = "has zero length, its two points coincide in the initial pose. Move one of them."
        raise ModelError(message, field="point_i")
    return points


class Axis(NamedTuple):
    """A global direction and the name of the field that gives it."""

    field: str
    direction: Vector | None


class HasFrames(Protocol):
    """A part that is placed by a global point, or by ``frame_i`` and ``frame_j``."""

    @property
    def body_i(self) -> Solid | None: ...
    @property
    def body_j(self) -> Solid | None: ...
    @property
    def point(self) -> Vector | None: ...
    @property
    def frame_i(self) -> Frame | None: ...
    @property
    def frame_j(self) -> Frame | None: ...


@dataclass(frozen=True, eq=False, repr=False)  # a joint has its own line
class AboutAxis:
    """Placement by a global point and axis in the initial pose, or by a frame on each body.

    Parameters
    ----------
    body_i, body_j
        The two bodies that it connects.
    point, axis
        A point [m] and the direction of the axis, both in global axes in the initial pose.
    frame_i, frame_j
        Instead of point and axis: a frame on each body, whose third axis h is along the axis.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    axis: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None

    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes, with h along the axis."""
        axis = Axis("axis", self.axis)
        return placed_frames(self, (axis, axis), poses)


def placed_frames(part: HasFrames, axes: tuple[Axis, Axis] | None, poses: Poses) -> Frames:
    """Return both frames of a part in body axes.

    ``axes`` are the global directions of h on body i and on body j; a part without any takes the
    global axes.
    """
    if part.frame_i is not None or part.frame_j is not None:
        refuse_both({"point": part.point, **dict(axes or ())}, "frames")
        frames = _given(part, poses)
        refuse_same_body(frames.i.body, frames.j.body, "frame_j")
        return frames
    frames = _made(part, axes, poses)
    refuse_same_body(frames.i.body, frames.j.body, "body_j")
    return frames


def _made(part: HasFrames, axes: tuple[Axis, Axis] | None, poses: Poses) -> Frames:
    body_i, body_j = two_bodies(part.body_i, part.body_j)
    point = _all_given({"point": part.point, **dict(axes or ())})
    axis_i, axis_j = axes or (Axis("", None), Axis("", None))
    return Frames(
        Frame(Point(body_i, point, "global"), z=axis_i.direction).resolve(poses, "point", axis_i.field),
        Frame(Point(body_j, point, "global"), z=axis_j.direction).resolve(poses, "point", axis_j.field),
    )


def _all_given(needed: Mapping[str, Vector | None]) -> Vector:
    """Return the point among the needed entries, or raise a ModelError if one of them is missing."""
    for field, value in needed.items():
        if value is None:
            message = (
                f"{field} is missing. Give {' and '.join(needed)} in global axes, or a frame on each body."
            )
            raise ModelError(message)
    point = needed["point"]
    assert point is not None
    return point


def _given(part: HasFrames, poses: Poses) -> Frames:
    if part.frame_i is None or part.frame_j is None:
        raise ModelError("one of its two frames is missing. Give a frame on each body.", field="frame_i")
    frames = Frames(part.frame_i.resolve(poses, "frame_i"), part.frame_j.resolve(poses, "frame_j"))
    refuse_other_body(part.body_i, frames.i.body, "frame_i")
    refuse_other_body(part.body_j, frames.j.body, "frame_j")
    return frames


def two_bodies(body_i: Solid | None, body_j: Solid | None) -> tuple[Solid, Solid]:
    """Return both bodies, or raise a ModelError if one is missing."""
    if body_i is None or body_j is None:
        raise ModelError("its bodies are missing. Name the two bodies it connects.", field="body_i")
    return body_i, body_j


def refuse_same_body(body_i: str, body_j: str, field: str) -> None:
    """Raise a ModelError if a part connects a body to itself."""
    if body_i == body_j:
        raise ModelError(f"connects {quote(body_i)} to itself. Name two different bodies.", field=field)


def refuse_other_body(named: Solid | None, found: str, field: str) -> None:
    """Raise a ModelError if a point or frame is not on the body that the part names."""
    if named is not None and named.name != found:
        message = (
            f"{field} is on {quote(found)}, but the body named is {quote(named.name)}. Name one of them."
        )
        raise ModelError(message, field=field)


def refuse_both(given: Mapping[str, object], others: str) -> None:
    """Raise a ModelError if a part is placed in two ways at once."""
    for field, value in given.items():
        if value is not None:
            raise ModelError(f"has both {field} and {others}. Leave one of them out.", field=field)
