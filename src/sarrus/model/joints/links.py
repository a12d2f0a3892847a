"""Massless links between two bodies: with two balls, two hinges, or a hinge and a ball."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ... import elements
from ..._jit.formulas.functions import cos
from ..coordinate import Coordinate, heading
from ..errors import ModelError
from ..geometry.placement import Frames, frames_on_bodies, refuse_same_body
from ..geometry.points import PERPENDICULAR, Frame, LocalFrame, LocalPoint, Point, frame_axes
from ..geometry.pose import Poses
from ..measure import Angle, Direction, Length
from ..parity import AXIAL
from ..primitive import Primitive
from ..quantity import SMALLEST_LENGTH, Vector, number, plain, positive, triple
from .conditions import constant_angle, cosine
from .joint import Joint, basic_constraints


@dataclass(frozen=True, eq=False)
class Link:
    """Ends by a point on each body and global axes in the design position, or by a frame on each body."""

    point_i: Point | None = None
    point_j: Point | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    length: Length | None = None

    def ends(
        self, poses: Poses, axis_i: Vector | None, axis_j: Vector | None, fields: tuple[str, str]
    ) -> Frames:
        """Return the frames of both ends in body axes, with h along the axes."""
        if self.frame_i is not None or self.frame_j is not None:
            placing = {"point_i": self.point_i, "point_j": self.point_j, fields[0]: axis_i}
            frames = frames_on_bodies(self, placing, poses)
        elif self.point_i is None or self.point_j is None:
            raise ModelError("its ends are missing. Give a point or a frame on each body.", field="point_i")
        else:
            i, j = self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j")
            frames = Frames(_end(i, axis_i, fields[0], poses), _end(j, axis_j, fields[1], poses))
        refuse_same_body(frames.i.body, frames.j.body, "point_j")
        return frames

    def distance(self, i: LocalFrame, j: LocalFrame, poses: Poses) -> Primitive:
        """The distance of the ends: the given length, or the one in the design position."""
        apart = poses[j.body].global_point(np.array(j.s)) - poses[i.body].global_point(np.array(i.s))
        initial = plain(np.linalg.norm(apart))
        if self.length is None and initial < SMALLEST_LENGTH:
            raise ModelError("its two ends coincide. Move one of them.", field="point_i")
        length = initial if self.length is None else positive(self.length, "length", "Give the length in m.")
        return Primitive(elements.Distance, (i.body, j.body), (i.s, j.s, length), "distance")


def _end(point: LocalPoint, axis: Vector | None, field: str, poses: Poses) -> LocalFrame:
    if axis is None:
        raise ModelError(
            f"{field} is missing. Give points and {field} in global axes, or a frame on each body."
        )
    axes = poses[point.body].A.T @ frame_axes(None, axis, field)
    return LocalFrame(*point, triple(axes[:, 0]), triple(axes[:, 1]), triple(axes[:, 2]))


@dataclass(frozen=True, eq=False)
class Distance(Joint):
    """Constant distance ``length`` [m] of ``point_i`` and ``point_j`` on two bodies, by default the initial one."""

    point_i: Point
    point_j: Point
    length: Length | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φˢˢ(P_i, P_j, C), Eq. (28)."""
        i = self.point_i.resolve(poses, "point_i")
        j = self.point_j.resolve(poses, "point_j")
        refuse_same_body(i.body, j.body, "point_j")
        apart = plain(np.linalg.norm(j.position(poses) - i.position(poses)))
        if apart < SMALLEST_LENGTH:
            message = "its two points coincide. Move one of them, or use a spherical joint."
            raise ModelError(message, field="point_i")
        length = apart if self.length is None else positive(self.length, "length", "Give the length in m.")
        yield Primitive(elements.Distance, (i.body, j.body), (i.s, j.s, length), "distance")


@dataclass(frozen=True, eq=False)
class RevoluteRevolute(Link, Joint):
    """A link along the common normal of axes of body i and body j, with the angle ``twist`` [rad] between them.

    Placed by ``point_i`` and ``point_j`` and global axes in the design position, or by ``frame_i`` and
    ``frame_j`` with h along the axes. Left out, ``axis_j`` is parallel to ``axis_i``, the ``length`` [m] and
    the ``twist`` are those of the design position.
    """

    parity = AXIAL

    axis_i: Direction | None = None
    axis_j: Direction | None = None
    twist: Angle | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the equations for parallel axes, or those for twisted ones."""
        i, j = self._hinges(poses)
        twist = cosine(i, j, poses) if self.twist is None else cos(number(self.twist, "twist"))
        if abs(twist) > 1 - PERPENDICULAR:
            yield from basic_constraints(i, j, "f_i.h_j", "g_i.h_j", "h_i.d")
        else:
            yield constant_angle(i, j, twist)
            yield from basic_constraints(i, j, "h_i.d", "h_j.d")
        yield self.distance(i, j, poses)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angles of the link about h_i and about h_j."""
        i, j = self._hinges(poses)
        yield heading(i, j, poses, from_start=self.frame_i is None, name="angle_i")
        yield heading(j, i, poses, from_start=self.frame_j is None, name="angle_j")

    def _hinges(self, poses: Poses) -> Frames:
        axis_j = self.axis_i if self.axis_j is None else self.axis_j
        return self.ends(poses, self.axis_i, axis_j, ("axis_i", "axis_j"))


@dataclass(frozen=True, eq=False)
class RevoluteSpherical(Link, Joint):
    """A link that rotates about an axis of body i, normal to it, and carries a point of body j at its end.

    Placed by ``point_i`` and ``point_j`` and the global ``axis`` in the design position, or by ``frame_i`` with h
    along the axis and ``frame_j``. The ``length`` [m], left out, is the initial distance.
    """

    parity = AXIAL

    axis: Direction | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d2(h_i, d), Φˢˢ(P_i, P_j, C)."""
        i, j = self.ends(poses, self.axis, self.axis, ("axis", "axis"))
        yield from basic_constraints(i, j, "h_i.d")
        yield self.distance(i, j, poses)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angle of the link about h_i."""
        i, j = self.ends(poses, self.axis, self.axis, ("axis", "axis"))
        yield heading(i, j, poses, from_start=self.frame_i is None)
