"""Joints by conditions on directions and points: constant angles, parallel axes, points on lines and planes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ... import elements
from ..._jit.formulas.functions import cos
from ..coordinate import turned
from ..errors import ModelError
from ..geometry.placement import AboutAxis, Axis, Frames, placed_frames
from ..geometry.points import PERPENDICULAR, Frame, LocalFrame, Solid
from ..geometry.pose import Poses
from ..measure import Angle, Direction
from ..parity import AXIAL
from ..primitive import Primitive
from ..quantity import number, plain
from .joint import FramedJoint, Joint


@dataclass(frozen=True, eq=False)
class Cartesian(AboutAxis, FramedJoint):
    """Two bodies that translate freely and do not rotate relative to each other, as on a gantry or a shaker.

    Placed by a global ``point`` [m] and ``axis`` in the design position, or by ``frame_i`` and ``frame_j``.
    """

    constraints = ("f_i.h_j", "g_i.h_j", "f_i.g_j")
    free = ("displacement_x", "displacement_y", "displacement_z")


@dataclass(frozen=True, eq=False)
class ConstantAngle(Joint):
    """Constant ``angle`` [rad] between ``axis_i`` and ``axis_j``, by default the initial one.

    Placed by two global axes in the design position, or by ``frame_i`` and ``frame_j`` with h along them.

    Parameters
    ----------
    body_i, body_j
        The two bodies that it connects; with frames, these name them.
    """

    parity = AXIAL

    body_i: Solid | None = None
    body_j: Solid | None = None
    axis_i: Direction | None = None
    axis_j: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    angle: Angle | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield h_i·h_j = cos(angle)."""
        axes = Axis("axis_i", self.axis_i), Axis("axis_j", self.axis_j)
        i, j = placed_frames(self, axes, poses)
        yield constant_angle(i, j, cosine_of(self.angle, "angle", i, j, poses))


def cosine(i: LocalFrame, j: LocalFrame, poses: Poses) -> float:
    """The cosine between h_i and h_j in the design position."""
    return plain(turned(i.h, i.body, poses) @ turned(j.h, j.body, poses))


def cosine_of(angle: float | None, field: str, i: LocalFrame, j: LocalFrame, poses: Poses) -> float:
    """The cosine of a given angle, or that between h_i and h_j in the design position.

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
class ParallelAxes(FramedJoint):
    """Parallel axes of ``body_i`` and ``body_j``: relative rotation about the direction h only, translation free.

    Placed by a global ``axis`` in the design position, or by ``frame_i`` and ``frame_j`` with h along it.
    """

    parity = AXIAL

    body_i: Solid | None = None
    body_j: Solid | None = None
    axis: Direction | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None

    constraints = ("f_i.h_j", "g_i.h_j")
    free = ("angle",)

    def frames(self, poses: Poses) -> Frames:
        """Return both frames in body axes."""
        return placed_frames(self, (Axis("axis", self.axis), Axis("axis", self.axis)), poses)


@dataclass(frozen=True, eq=False)
class PointOnLine(AboutAxis, FramedJoint):
    """Point on a line: the line h is fixed in body i, the point in body j, which may move otherwise.

    The order matters: ``PointOnLine("roller", sr.ground, bar, ...)`` is a roller of a bar on a fixed rail. With
    exchanged bodies, a rail on the bar passes through a fixed point; both are the same only in the design position.

    Placed by a global ``point`` [m] and ``axis`` in the design position, or by ``frame_i`` with h along the
    line and ``frame_j`` at the point.
    """

    constraints = ("f_i.d", "g_i.d")
    free = ("displacement",)


@dataclass(frozen=True, eq=False)
class PointOnPlane(AboutAxis, FramedJoint):
    """Point on a plane: the plane with the normal h is fixed in body i, the point in body j.

    The order matters, as of a `PointOnLine`.

    Placed by a global ``point`` [m] and the normal ``axis`` in the design position, or by ``frame_i`` with h
    along the normal and ``frame_j`` at the point.
    """

    constraints = ("h_i.d",)
    free = ("displacement_x", "displacement_y")
