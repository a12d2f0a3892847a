"""A frame fixed to a body: an origin and three perpendicular axes f, g, h."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..checks.names import find
from ..errors import ModelError
from ..quantity import Array, Vec3, Vector, direction, plain, triple
from ..show import show
from .point import Point
from .pose import Poses
from .rotation import perpendicular, skew

PERPENDICULAR = 1e-6  # [-] how far from 0 the product of two "perpendicular" unit vectors may be


class LocalFrame(NamedTuple):
    """A frame as the elements take it: body name, origin s′ [m], unit axes f′, g′, h′, in body axes."""

    body: str
    s: Vec3
    f: Vec3
    g: Vec3
    h: Vec3


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame on a body; ``x`` and ``z`` are in the axes that its point is given in."""

    point: Point
    x: Vector | None = None
    z: Vector | None = None

    def resolve(self, poses: Poses, field: str, axis: str = "") -> LocalFrame:
        """Return the frame in body axes; errors are about ``field``, or ``axis`` for its directions."""
        if not isinstance(self.point, Point):
            raise ModelError(
                f"{field} is a frame at {show(self.point)}, which is no point. Give body.frame((x, y, z)), with "
                "directions x=, z= if they are wanted.",
                field=field,
            )
        origin = self.point.resolve(poses, field)
        axes = frame_axes(self.x, self.z, axis or field)
        if self.point.axes == "global":
            axes = find(origin.body, poses, field).A.T @ axes
        return LocalFrame(*origin, triple(axes[:, 0]), triple(axes[:, 1]), triple(axes[:, 2]))


def frame_axes(x: Vector | None, z: Vector | None, field: str) -> Array:
    """Return the matrix with the unit columns f, g, h of a frame with f along ``x`` and h along ``z``."""
    if x is None and z is None:
        return np.eye(3)
    if z is None:
        f = direction(x, field)
        h = perpendicular(f)
    else:
        h = direction(z, field)
        f = perpendicular(h) if x is None else _across(direction(x, field), h, field)
    return np.column_stack([f, skew(h) @ f, h])


def _across(f: Array, h: Array, field: str) -> Array:
    slope = plain(f @ h)
    if abs(slope) > PERPENDICULAR:
        message = (
            f"{field} has axes x and z that are not perpendicular, the cosine between them is {slope:.6g}"
        )
        raise ModelError(f"{message}. Leave x out, or make it perpendicular to z.", field=field)
    across: Array = f - slope * h
    return across / np.linalg.norm(across)
