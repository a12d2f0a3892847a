"""Constant angle: a direction of one body and a direction of the other keep the angle between them. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ... import elements
from ..._jit.formulas.functions import cos
from ..coordinate import turned
from ..errors import ModelError
from ..geometry.frame import Frame, LocalFrame
from ..geometry.placement import Axis, placed_frames
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..measure import Angle, Direction
from ..primitive import Primitive
from ..quantity import Vector, number, plain
from .joint import Joint


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


PARALLEL = 1e-6  # [-] distance of the cosine between two axes from 1, below which its gradient vanishes


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
    if abs(value) > 1 - PARALLEL:
        raise ModelError("its axes are parallel. Use a joint for parallel axes.", field=field)
    return value


def constant_angle(i: LocalFrame, j: LocalFrame, value: float) -> Primitive:
    """The cosine between h_i and h_j has a value."""
    return Primitive(elements.ConstantAngle, (i.body, j.body), (i.h, j.h, value), "h_i.h_j")
