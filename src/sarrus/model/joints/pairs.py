"""Kinematic pairs: fixed, revolute, translational, cylindrical, screw, planar, spherical and universal joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

from ... import elements
from ..coordinate import Coordinate, angle, turned
from ..errors import ModelError
from ..geometry.placement import (
    AboutAxis,
    Axis,
    Frames,
    Points,
    placed_frames,
    refuse_both,
    refuse_other_body,
    refuse_same_body,
    two_bodies,
)
from ..geometry.points import PERPENDICULAR, Frame, LocalFrame, Point, Solid, frame_axes
from ..geometry.pose import Poses
from ..measure import Direction, Length, Place
from ..parity import AXIAL, POLAR, declared
from ..primitive import Primitive
from ..quantity import Array, direction, number, plain, triple
from .joint import FramedJoint, Joint, basic_constraints


@dataclass(frozen=True, eq=False)
class Fixed(FramedJoint):
    """Fixed joint of ``body_i`` and ``body_j``.

    Given by a global ``point`` [m] in the design position, or by ``frame_i`` and ``frame_j``, which it makes coincide.
    """

    parity = POLAR

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None

    constraints = ("point", "f_i.h_j", "g_i.h_j", "f_i.g_j")

    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes."""
        return placed_frames(self, None, poses)


@dataclass(frozen=True, eq=False)
class Revolute(AboutAxis, FramedJoint):
    """Revolute joint (hinge): a common point and a common axis h.

    Placed by a global ``point`` [m] and ``axis`` in the design position, or by ``frame_i`` and
    ``frame_j`` with h along the axis.
    """

    parity = AXIAL

    constraints = ("point", "f_i.h_j", "g_i.h_j")
    free = ("angle",)


@dataclass(frozen=True, eq=False)
class Translational(AboutAxis, FramedJoint):
    """Translational (prismatic) joint: displacement along a common axis h, without rotation.

    Placed by a global ``point`` [m] and ``axis`` in the design position, or by ``frame_i`` and
    ``frame_j`` with h along the axis.

    Notes
    -----
    The two frames coincide when the joint is assembled. Eq. (32) uses a frame on body j that is
    rotated by a right angle about h, so its Φ^d1(f_i, f_j) is Φ^d1(f_i, g_j) here.
    """

    constraints = ("g_i.h_j", "f_i.h_j", "f_i.g_j", "g_i.d", "f_i.d")
    free = ("displacement",)


@dataclass(frozen=True, eq=False)
class Cylindrical(AboutAxis, FramedJoint):
    """Cylindrical joint: rotation about, and displacement along, a common axis h.

    Placed by a global ``point`` [m] and ``axis`` in the design position, or by ``frame_i`` and
    ``frame_j`` with h along the axis.
    """

    constraints = ("f_i.h_j", "g_i.h_j", "f_i.d", "g_i.d")
    free = ("angle", "displacement")


@dataclass(frozen=True, eq=False)
class Screw(Cylindrical):
    """Screw joint: common axis h, and ``pitch`` [m], the displacement per revolution, positive if right-handed.

    Placed by a global ``point`` [m] and ``axis`` in the design position, or by ``frame_i`` and
    ``frame_j`` with h along the axis; the frames coincide where angle and displacement are 0.
    """

    parity = declared(POLAR, pitch="odd")

    pitch: Length = field(kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the primitives of a cylindrical joint, and the screw."""
        pitch = number(self.pitch, "pitch", "Give the displacement in m per revolution.")
        if not pitch:
            raise ModelError("pitch must not be 0. Give it in m, or use a revolute joint.", field="pitch")
        yield from super().primitives(poses)
        i, j = self.frames(poses)
        values = (i.f, i.g, i.h, j.f, i.s, j.s, pitch / (2 * pi), 0.0, 0.0)
        yield Primitive(elements.Screw, (i.body, j.body), values, "screw")


@dataclass(frozen=True, eq=False)
class Planar(AboutAxis, FramedJoint):
    """Planar joint: the bodies have a common plane with the normal h.

    Placed by a global ``point`` [m] of the plane and its normal ``axis`` in the design position, or by
    ``frame_i`` and ``frame_j`` with h along the normal.
    """

    parity = AXIAL

    constraints = ("f_i.h_j", "g_i.h_j", "h_i.d")
    free = ("angle", "displacement_x", "displacement_y")


@dataclass(frozen=True, eq=False)
class Spherical(Joint):
    """Spherical (ball) joint of ``body_i`` and ``body_j``.

    Given by a global ``point`` [m] in the design position, or by ``point_i`` and ``point_j``, a point on each body.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    point_i: Point | None = None
    point_j: Point | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φˢ(P_i, P_j)."""
        yield from basic_constraints(*self._points(poses), "point")

    def _points(self, poses: Poses) -> Points:
        given = self.point_i is not None or self.point_j is not None
        points = self._given(poses) if given else self._made(poses)
        refuse_same_body(points.i.body, points.j.body, "point_j" if given else "body_j")
        return points

    def _made(self, poses: Poses) -> Points:
        body_i, body_j = two_bodies(self.body_i, self.body_j)
        if self.point is None:
            raise ModelError("point is missing. Give a point in global axes, or a point on each body.")
        i, j = (Point(body, self.point, "global").resolve(poses, "point") for body in (body_i, body_j))
        return Points(i, j)

    def _given(self, poses: Poses) -> Points:
        refuse_both({"point": self.point}, "points")
        if self.point_i is None or self.point_j is None:
            raise ModelError("one of its two points is missing. Give a point on each body.", field="point_i")
        points = Points(self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j"))
        refuse_other_body(self.body_i, points.i.body, "point_i")
        refuse_other_body(self.body_j, points.j.body, "point_j")
        return points


@dataclass(frozen=True, eq=False)
class Universal(FramedJoint):
    """Universal (Cardan) joint; its cross rotates in ``body_i`` about ``axis_i`` and in ``body_j`` about ``axis_j``.

    Placed by a global ``point`` [m] and two perpendicular global axes in the design position, or by
    ``frame_i`` and ``frame_j`` with h along the cross axes.
    """

    parity = AXIAL

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    axis_i: Direction | None = None
    axis_j: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None

    constraints = ("point", "h_i.h_j")

    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes, with h along the cross axes."""
        frames = placed_frames(self, (Axis("axis_i", self.axis_i), Axis("axis_j", self.axis_j)), poses)
        if self.frame_i is None:
            _check_cross(direction(self.axis_i, "axis_i"), direction(self.axis_j, "axis_j"))
        return frames

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angles of the cross in body i about h_i, from f_i to h_j, and in body j about h_j.

        Placed by global axes both start at 0; then f_i is h_j in the design position, and the other way round.
        """
        i, j = self.frames(poses)
        if self.frame_i is None:
            i, j = _along(i, j, poses), _along(j, i, poses)
        yield angle(i, j, poses, f_j=j.h, name="angle_i")
        yield angle(j, i, poses, f_j=i.h, name="angle_j")


def _check_cross(h_i: Array, h_j: Array) -> None:
    cosine = plain(h_i @ h_j)
    if abs(cosine) > PERPENDICULAR:
        message = f"axis_i and axis_j must be perpendicular, but the cosine between them is {cosine:.6g}"
        raise ModelError(f"{message}. Turn one of them.", field="axis_i")


def _along(i: LocalFrame, j: LocalFrame, poses: Poses) -> LocalFrame:
    """The frame of body i turned about h_i until f_i is h_j."""
    towards = poses[i.body].local_vector(turned(j.h, j.body, poses))
    axes = frame_axes(towards, i.h, "axis_j")
    return LocalFrame(i.body, i.s, triple(axes[:, 0]), triple(axes[:, 1]), i.h)
