"""Two frames of a joint: from a global point and directions, or given one on each body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..errors import ModelError
from ..measure import Direction, Place
from ..parity import POLAR, Parities
from ..quantity import SMALLEST_LENGTH, Vector, triple
from ..show import quote
from . import rotation
from .points import ORIGIN, Frame, LocalFrame, LocalPoint, Point, Solid
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
        message = "has zero length, its two points coincide in the design position. Move one of them."
        raise ModelError(message, field="point_i")
    return points


class Axis(NamedTuple):
    """A global direction and the name of the field that gives it."""

    field: str
    direction: Vector | None


@dataclass(frozen=True, eq=False, repr=False)  # a joint has its own line
class AboutAxis:
    """Placement by a global point and axis in the design position, or by a frame on each body.

    Parameters
    ----------
    body_i, body_j
        The two bodies that it connects.
    point, axis
        A point [m] and the direction of the axis, both in global axes in the design position.
    frame_i, frame_j
        Instead of point and axis: a frame on each body, whose third axis h is along the axis.
    """

    parity: ClassVar[Parities] = POLAR

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


def placed_frames(part: Any, axes: tuple[Axis, Axis] | None, poses: Poses) -> Frames:
    """Return both frames of a part in body axes.

    ``axes`` are the global directions of h on body i and on body j; a part without any takes the
    global axes. A part of directions alone, without a field ``point``, has an arbitrary origin.
    """
    placing = ({"point": part.point} if hasattr(part, "point") else {}) | dict(axes or ())
    by_frames = part.frame_i is not None or part.frame_j is not None
    frames = frames_on_bodies(part, placing, poses) if by_frames else _made(part, placing, axes, poses)
    refuse_same_body(frames.i.body, frames.j.body, "frame_j" if by_frames else "body_j")
    return frames


def _made(
    part: Any, placing: Mapping[str, Vector | None], axes: tuple[Axis, Axis] | None, poses: Poses
) -> Frames:
    bodies = two_bodies(part.body_i, part.body_j)
    for field, value in placing.items():
        if value is None:
            message = f"{field} is missing. Give {' and '.join(placing)} in global axes"
            raise ModelError(f"{message}, or a frame on each body.")
    point = placing.get("point", ORIGIN)
    assert point is not None
    pairs = zip(bodies, axes or (Axis("", None),) * 2, strict=True)
    return Frames(
        *(Frame(Point(b, point, "global"), z=h).resolve(poses, "point", field) for b, (field, h) in pairs)
    )


def frames_on_bodies(part: Any, placing: Mapping[str, object], poses: Poses) -> Frames:
    """Return the two frames that are given to a part, in place of global points and axes."""
    refuse_both(placing, "frames")
    if part.frame_i is None or part.frame_j is None:
        raise ModelError("one of its two frames is missing. Give a frame on each body.", field="frame_i")
    frames = Frames(part.frame_i.resolve(poses, "frame_i"), part.frame_j.resolve(poses, "frame_j"))
    refuse_other_body(getattr(part, "body_i", None), frames.i.body, "frame_i")
    refuse_other_body(getattr(part, "body_j", None), frames.j.body, "frame_j")
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
