"""Numbers, vectors and poses in the texts of SDF elements."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ...model.geometry.motion import pose, unit
from ...model.geometry.orientation import EulerAngles, euler_parameters
from ...model.geometry.pose import GROUND_POSE, Pose
from ...model.quantity import Array
from ..xml.element import Element
from ..xml.reader import Reader

QUATERNION = "quat_xyzw"  # scalar last
UNLIMITED = 1e12  # what a file writes for no limit is larger


def number(element: Element, tag: str, reader: Reader, default: float) -> float:
    """Return the number in a child, or the default."""
    child = reader.one(element, tag)
    return default if child is None else reader.content(child)[0]


def maybe(element: Element | None, tag: str, reader: Reader) -> float | None:
    """Return the number in a child, or None: files write inf, or 1e16, for no limit."""
    child = reader.one(element, tag) if element else None
    with suppress(ValueError):
        if child is not None and not abs(float(child.text)) < UNLIMITED:
            return None
    return None if child is None else reader.content(child)[0]


def flag(element: Element, tag: str, reader: Reader, default: bool) -> bool:
    """Return the truth in a child, or the default."""
    child = reader.one(element, tag)
    return default if child is None else reader.flag(child)


def vector(element: Element, tag: str, reader: Reader, default: tuple[float, float, float]) -> Array:
    """Return the three numbers in a child, or the default."""
    child = reader.one(element, tag)
    return np.array(default if child is None else reader.content(child, 3), dtype=float)


def pose_of(element: Element, reader: Reader) -> Pose:
    """Return the pose in the child <pose>: x y z [m] and roll pitch yaw [rad, or degrees], or a quaternion."""
    child = reader.one(element, "pose")
    if child is None or not child.text:
        return GROUND_POSE
    if child.attributes.get("rotation_format") == QUATERNION:
        x, y, z, a, b, c, w = reader.content(child, 7)
        return pose(np.array([x, y, z]), unit(np.array([w, a, b, c])))
    x, y, z, *angles = reader.content(child, 6)
    degrees = child.attributes.get("degrees", "false").lower() in ("true", "1")
    roll, pitch, yaw = np.deg2rad(angles) if degrees else angles
    return pose(np.array([x, y, z]), euler_parameters(EulerAngles((yaw, pitch, roll), "zyx")))
