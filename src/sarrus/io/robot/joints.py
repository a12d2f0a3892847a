"""The joint that leaves two bodies exactly the motions of a branch."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from ...model import Cylindrical, Fixed, Joint, Planar, Revolute, Spherical, Translational, Universal
from ...model.errors import ModelError
from ...model.geometry.motion import Ball, Free, Motion, Slide, Turn
from ...model.geometry.points import Frame, Point, Solid
from ...model.geometry.pose import Pose
from ...model.geometry.rotation import perpendicular
from ...model.quantity import Array

NEAR = 1e-9  # [-, m] how far axes may be from parallel, perpendicular or meeting in a point

Motions: TypeAlias = tuple[Motion, ...]


class Hinge:
    """Two bodies, the frame of the second in the first while nothing has moved, and a name for the joint."""

    def __init__(self, name: str, parent: Solid, child: Solid, pose: Pose) -> None:
        self.name, self.parent, self.child, self.pose = name, parent, child, pose

    def frames(self, point: Array, z: Array) -> tuple[Frame, Frame]:
        """Return the same frame on both bodies; point and axis in child axes."""
        return self.parent_frame(point, z), Frame(Point(self.child, point), x=perpendicular(z), z=z)

    def parent_frame(self, point: Array, z: Array) -> Frame:
        """Return the frame on the parent; point and axis in child axes."""
        A = self.pose.A
        return Frame(Point(self.parent, self.pose.global_point(point)), x=A @ perpendicular(z), z=A @ z)

    def about(self, kind: Callable[..., Joint], point: Array, z: Array) -> Joint:
        """Return a joint that is placed by a frame on each body."""
        i, j = self.frames(point, z)
        return kind(self.name, frame_i=i, frame_j=j)


def joint(hinge: Hinge, motions: Motions) -> Joint | None:
    """Return the joint, or None where the motions leave all six freedoms.

    Raises
    ------
    ModelError
        If no joint leaves just these motions.
    """
    pattern = "".join(LETTERS[type(motion)] for motion in sorted(motions, key=lambda m: type(m) is Turn))
    make = _MAKERS.get(pattern, _refused)
    return make(hinge, motions)


def coordinate_of(motions: Motions, name: str) -> tuple[str, float] | None:
    """Return which coordinate of the joint a motion is, and its sign; None where the joint does not have it as one."""
    one = next(motion for motion in motions if motion.name == name)
    if len(motions) == 1 and isinstance(one, Turn | Slide):
        return ("angle" if isinstance(one, Turn) else "displacement"), 1.0
    if len(motions) == 2 and isinstance(one, Turn) and _slides(motions):
        return "angle", 1.0
    if len(motions) == 2 and isinstance(one, Slide) and _rotations(motions):
        return "displacement", float(np.sign(one.axis @ _rotations(motions)[0].axis))
    return None


def _fixed(hinge: Hinge, motions: Motions) -> Joint:
    return hinge.about(Fixed, np.zeros(3), np.array([0.0, 0.0, 1.0]))


def _revolute(hinge: Hinge, motions: Motions) -> Joint:
    (turn,) = _rotations(motions)
    return hinge.about(Revolute, turn.point, turn.axis)


def _translational(hinge: Hinge, motions: Motions) -> Joint:
    (slide,) = _slides(motions)
    return hinge.about(Translational, np.zeros(3), slide.axis)


def _cylindrical(hinge: Hinge, motions: Motions) -> Joint:
    (slide,), (turn,) = _slides(motions), _rotations(motions)
    if np.linalg.norm(np.cross(slide.axis, turn.axis)) > NEAR:
        return _refused(hinge, motions)
    return hinge.about(Cylindrical, turn.point, turn.axis)


def _planar(hinge: Hinge, motions: Motions) -> Joint:
    (a, b), (turn,) = _slides(motions), _rotations(motions)
    across = max(abs(a.axis @ turn.axis), abs(b.axis @ turn.axis)) < NEAR
    if not across or np.linalg.norm(np.cross(a.axis, b.axis)) < NEAR:
        return _refused(hinge, motions)
    return hinge.about(Planar, turn.point, turn.axis)


def _universal(hinge: Hinge, motions: Motions) -> Joint:
    first, second = _rotations(motions)
    point = _meeting(first, second)
    if point is None or abs(first.axis @ second.axis) > NEAR:
        return _refused(hinge, motions)
    frame_j = Frame(Point(hinge.child, point), x=first.axis, z=second.axis)
    return Universal(hinge.name, frame_i=hinge.parent_frame(point, first.axis), frame_j=frame_j)


def _three_rotations(hinge: Hinge, motions: Motions) -> Joint:
    rotations = _rotations(motions)
    points = [_meeting(rotations[0], rotations[1]), _meeting(rotations[1], rotations[2])]
    axes = np.array([turn.axis for turn in rotations])
    if points[0] is None or points[1] is None or abs(np.linalg.det(axes)) < NEAR:
        return _refused(hinge, motions)
    if np.linalg.norm(points[0] - points[1]) > NEAR:
        return _refused(hinge, motions)
    return _ball_at(hinge, points[0])


def _ball(hinge: Hinge, motions: Motions) -> Joint:
    (ball,) = (motion for motion in motions if isinstance(motion, Ball))
    return _ball_at(hinge, ball.point)


def _ball_at(hinge: Hinge, point: Array) -> Joint:
    there = Point(hinge.parent, hinge.pose.global_point(point))
    return Spherical(hinge.name, point_i=there, point_j=Point(hinge.child, point))


def _none(hinge: Hinge, motions: Motions) -> None:
    return None


def _refused(hinge: Hinge, motions: Motions) -> Joint:
    names = ", ".join(motion.name for motion in motions)
    message = f"no joint leaves just the motions {names} between two bodies"
    raise ModelError(f"{message}. Put a body with a small mass between them.")


def _rotations(motions: Motions) -> list[Turn]:
    return [motion for motion in motions if isinstance(motion, Turn)]


def _slides(motions: Motions) -> list[Slide]:
    return [motion for motion in motions if isinstance(motion, Slide)]


def _meeting(a: Turn, b: Turn) -> Array | None:
    """Return the point where two axes meet, or None."""
    across = np.cross(a.axis, b.axis)
    square = float(across @ across)
    if square < NEAR:
        return None
    apart = b.point - a.point
    if abs(apart @ across) > NEAR * np.sqrt(square):
        return None
    along = float(np.cross(apart, b.axis) @ across) / square
    return np.asarray(a.point + along * a.axis)


LETTERS: dict[type[Motion], str] = {Turn: "T", Slide: "S", Ball: "B", Free: "F"}
_MAKERS: dict[str, Callable[[Hinge, Motions], Joint | None]] = {
    "": _fixed,
    "T": _revolute,
    "S": _translational,
    "ST": _cylindrical,
    "SST": _planar,
    "TT": _universal,
    "TTT": _three_rotations,
    "B": _ball,
    "F": _none,
    "SSSTTT": _none,
    "SSSB": _none,
    "BSSS": _none,
}
