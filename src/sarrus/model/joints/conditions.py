"""Joints by conditions on directions and points: constant angles, parallel axes, points on lines and planes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ... import elements
from ..._jit.formulas.functions import cos
from ..coordinate import Coordinate, angle, displacement, turned
from ..errors import ModelError
from ..geometry.placement import AboutAxis, Axis, Frames, placed_frames
from ..geometry.points import PERPENDICULAR, Frame, LocalFrame, Solid
from ..geometry.pose import Poses
from ..measure import Angle, Direction
from ..primitive import Primitive
from ..quantity import Vector, number, plain
from .joint import Joint, dot1, dot2


@dataclass(frozen=True, eq=False)
class Cartesian(AboutAxis, Joint):
    """Two bodies that translate freely and do not rotate relative to each other, as on a gantry or a shaker.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` and ``frame_j``.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d1(f_i, h_j), Φ^d1(g_i, h_j), Φ^d1(f_i, g_j), the rotations of Eq. (32)."""
        i, j = self.frames(poses)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)
        yield dot1("f_i.g_j", i, j, i.f, j.g)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the displacements of P_j along f_i, g_i and h_i."""
        i, j = self.frames(poses)
        for name, axis in (("x", i.f), ("y", i.g), ("z", i.h)):
            yield displacement(i, j, poses, axis=axis, name=f"displacement_{name}")


@dataclass(frozen=True, eq=False)
class ConstantAngle(Joint):
    """Constant ``angle`` [rad] between ``axis_i`` and ``axis_j``, by default the initial one.

    Placed by two global axes in the initial pose, or by ``frame_i`` and ``frame_j`` with h along them.

    Parameters
    ----------
    body_i, body_j
        The two bodies that it connects; with frames, these name them.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    axis_i: Direction | None = None
    axis_j: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    angle: Angle | None = None

    @property
    def point(self) -> Vector | None:
        """The arbitrary origin of both frames."""
        return None if self.frame_i or self.frame_j else (0.0, 0.0, 0.0)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield h_i·h_j = cos(angle)."""
        axes = Axis("axis_i", self.axis_i), Axis("axis_j", self.axis_j)
        i, j = placed_frames(self, axes, poses)
        yield constant_angle(i, j, cosine_of(self.angle, "angle", i, j, poses))


def cosine(i: LocalFrame, j: LocalFrame, poses: Poses) -> float:
    """The cosine between h_i and h_j in the initial pose."""
    return plain(turned(i.h, i.body, poses) @ turned(j.h, j.body, poses))


def cosine_of(angle: float | None, field: str, i: LocalFrame, j: LocalFrame, poses: Poses) -> float:
    """The cosine of a given angle, or that between h_i and h_j in the initial pose.

    Raises
    ------
    ModelError
        If the axes are parallel, which one equation cannot prescribe.
    """
    value = cosine(i, j, poses) if angle is None else cos(number(angle, field, "Give radians."))
    if abs(value) > 1 - PERPENDICULAR:
        raise ModelError("its axes are parallel. Use a joint for parallel axes.", field=field)
    return value


def constant_angle(i: LocalFrame, j: LocalFrame, value: float) -> Primitive:
    """The cosine between h_i and h_j has a value."""
    return Primitive(elements.ConstantAngle, (i.body, j.body), (i.h, j.h, value), "h_i.h_j")


@dataclass(frozen=True, eq=False)
class ParallelAxes(Joint):
    """Parallel axes of ``body_i`` and ``body_j``: relative rotation about the direction h only, translation free.

    Placed by a global ``axis`` in the initial pose, or by ``frame_i`` and ``frame_j`` with h along it.
    """

    body_i: Solid | None = None
    body_j: Solid | None = None
    axis: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None

    @property
    def point(self) -> Vector | None:
        """The arbitrary origin of both frames."""
        return None if self.frame_i or self.frame_j else (0.0, 0.0, 0.0)

    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes."""
        return placed_frames(self, (Axis("axis", self.axis), Axis("axis", self.axis)), poses)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d1(f_i, h_j), Φ^d1(g_i, h_j)."""
        i, j = self.frames(poses)
        yield dot1("f_i.h_j", i, j, i.f, j.h)
        yield dot1("g_i.h_j", i, j, i.g, j.h)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the angle from f_i to f_j about h."""
        yield angle(*self.frames(poses), poses)


@dataclass(frozen=True, eq=False)
class PointOnLine(AboutAxis, Joint):
    """Point on a line: the line h is fixed in body i, the point in body j, which may move otherwise.

    The order matters: ``PointOnLine("roller", sr.ground, bar, ...)`` is a roller of a bar on a fixed rail. With
    exchanged bodies, a rail on the bar passes through a fixed point; both are the same only in the initial pose.

    Placed by a global ``point`` [m] and ``axis`` in the initial pose, or by ``frame_i`` with h along the
    line and ``frame_j`` at the point.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d2(f_i, d), Φ^d2(g_i, d)."""
        i, j = self.frames(poses)
        yield dot2("f_i.d", i, j, i.f)
        yield dot2("g_i.d", i, j, i.g)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the displacement of the point along the line."""
        yield displacement(*self.frames(poses), poses)


@dataclass(frozen=True, eq=False)
class PointOnPlane(AboutAxis, Joint):
    """Point on a plane: the plane with the normal h is fixed in body i, the point in body j.

    The order matters, as of a `PointOnLine`.

    Placed by a global ``point`` [m] and the normal ``axis`` in the initial pose, or by ``frame_i`` with h
    along the normal and ``frame_j`` at the point.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield Φ^d2(h_i, d)."""
        i, j = self.frames(poses)
        yield dot2("h_i.d", i, j, i.h)

    def coordinates(self, poses: Poses) -> Iterator[Coordinate]:
        """Yield the displacements of the point along f_i and g_i."""
        i, j = self.frames(poses)
        yield displacement(i, j, poses, axis=i.f, name="displacement_x")
        yield displacement(i, j, poses, axis=i.g, name="displacement_y")
