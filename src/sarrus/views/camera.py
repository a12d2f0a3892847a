"""The camera of a picture, and the projection of points onto it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..algebra import Array

FIELD = np.radians(30.0)  # height of the field of view
MARGIN = 1.2
NARROW = 1e-6


class Camera(NamedTuple):
    """Its place, its axes right, up and back as columns, and pixels per unit of slope, for a picture of this size."""

    place: Array
    axes: Array
    scale: float
    width: int
    height: int

    def seen(self, points: Array) -> Array:
        """Points (..., 3) as x to the right, y downwards [pixels], and distance along the view [m]."""
        local = (points - self.place) @ self.axes
        depth = np.maximum(-local[..., 2], NARROW)
        x = self.width / 2 + self.scale * local[..., 0] / depth
        y = self.height / 2 - self.scale * local[..., 1] / depth
        return np.stack([x, y, depth], axis=-1)


def camera(points: Array, up: Array, view: str, width: int, height: int) -> Camera:
    """A camera that sees all points (n, 3): from a corner ("iso"), or along "x", "y" or "z"."""
    low, high = points.min(axis=0), points.max(axis=0)
    center = (low + high) / 2
    back = _direction(up, view)
    above = up if abs(back @ up) < 0.99 else _ahead(up)
    right = np.cross(above, back)
    right = right / np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(back, right), back])
    slope = np.tan(FIELD / 2)
    local = (points - center) @ axes
    needed = np.maximum(abs(local[:, 1]) / slope, abs(local[:, 0]) / (slope * width / height))
    distance = max(float(np.max(local[:, 2] + MARGIN * needed)), float(np.linalg.norm(high - low)), NARROW)
    return Camera(center + distance * back, axes, height / (2 * slope), width, height)


def _side(up: Array) -> Array:
    """To the right of who looks at a mechanism."""
    side = np.eye(3)[0] if abs(up[0]) < 0.9 else np.eye(3)[1]
    side = side - (side @ up) * up
    return np.asarray(side / np.linalg.norm(side))


def _ahead(up: Array) -> Array:
    return np.asarray(np.cross(up, _side(up)))


def _direction(up: Array, view: str) -> Array:
    """From the mechanism to the camera."""
    straight = {"x": np.eye(3)[0], "y": -np.eye(3)[1], "z": np.eye(3)[2]}
    if view in straight:
        return np.asarray(straight[view])
    back = 0.62 * _side(up) - _ahead(up) + 0.5 * up
    return np.asarray(back / np.linalg.norm(back))
