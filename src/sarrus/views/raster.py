"""Triangles to pixels: flat areas of colour with depth, drawn row by row with NumPy alone."""

from __future__ import annotations

from copy import deepcopy
from typing import NamedTuple

import numpy as np

from ..algebra import Array
from .meshes.mesh import POINT, upright

FAR = np.inf


class Canvas:
    """A picture that triangles are drawn into, nearer ones over farther ones.

    Attributes
    ----------
    pixels : (height, width, 3) colours, 0 to 1
    depth : (height, width) of what is seen, -1 / distance [1/m]: it grows with the distance and is linear on the page
    """

    def __init__(self, width: int, height: int, background: Array) -> None:
        self.pixels = np.tile(np.asarray(background, dtype=np.float32), (height, width, 1))
        self.depth = np.full((height, width), FAR)

    def draw(self, corners: Array, colors: Array) -> None:
        """Draw triangles: corners (n, 3, 3) as x, y [pixels] and depth, colours (n, 3)."""
        place, depth, owner = self._seen(corners)
        self.depth.reshape(-1)[place] = depth
        self.pixels.reshape(-1, 3)[place] = colors[owner]

    def blend(self, corners: Array, colors: Array, opacity: float) -> None:
        """Draw triangles as glass over what is there."""
        place, _, owner = self._seen(corners)
        last = np.zeros(self.depth.size, dtype=np.int64)
        last[place] = order = np.arange(len(place))
        nearest = last[place] == order
        pixels, place = self.pixels.reshape(-1, 3), place[nearest]
        pixels[place] = (1 - opacity) * pixels[place] + opacity * colors[owner[nearest]]

    def _seen(self, corners: Array) -> tuple[Array, Array, Array]:
        """Pixel, depth and triangle of all that is nearer than what is there; the nearest of a pixel is last."""
        owner, row, column, depth = _covered(corners, *self.depth.shape)
        place = row * self.depth.shape[1] + column
        nearer = depth < self.depth.reshape(-1)[place]
        place, depth, owner = place[nearer], depth[nearer], owner[nearer]
        order = np.argsort(-depth, kind="stable")
        return place[order], depth[order], owner[order]

    def bytes(self) -> Array:
        """The picture as bytes (height, width, 3)."""
        return np.asarray(np.clip(255 * self.pixels + 0.5, 0, 255), dtype=np.uint8)

    def copy(self) -> Canvas:
        """The same picture, to be drawn over."""
        return deepcopy(self)


def _covered(corners: Array, height: int, width: int) -> tuple[Array, Array, Array, Array]:
    """Triangle, row, column and depth of every pixel whose centre a triangle covers."""
    x, y, z = (corners[:, :, n] for n in range(3))
    low, high = np.ceil(y.min(axis=1) - 0.5), np.floor(y.max(axis=1) - 0.5)
    first, last = np.clip(low, 0, height).astype(int), np.clip(high, -1, height - 1).astype(int)
    owner, row = _expanded(first, np.maximum(last - first + 1, 0))
    left, right = _crossings(x[owner], y[owner], row + 0.5)
    first = np.clip(np.ceil(left - 0.5), 0, width).astype(int)
    last = np.clip(np.floor(right - 0.5), -1, width - 1).astype(int)
    line, column = _expanded(first, np.maximum(last - first + 1, 0))
    owner, row = owner[line], row[line]
    slope_x, slope_y = _slopes(x, y, z)
    depth = z[:, 0][owner] + slope_x[owner] * (column + 0.5 - x[:, 0][owner])
    return owner, row, column, depth + slope_y[owner] * (row + 0.5 - y[:, 0][owner])


def _expanded(first: Array, count: Array) -> tuple[Array, Array]:
    """Numbers first, first + 1, ... of every entry, ``count`` of them, with the entry that each belongs to."""
    owner = np.repeat(np.arange(len(first)), count)
    start = np.cumsum(count) - count
    return owner, first[owner] + np.arange(len(owner)) - start[owner]


def _crossings(x: Array, y: Array, height: Array) -> tuple[Array, Array]:
    """Return where a horizontal line enters and leaves each triangle."""
    left, right = np.full(len(x), np.inf), np.full(len(x), -np.inf)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        rise = y[:, b] - y[:, a]
        inside = (np.minimum(y[:, a], y[:, b]) <= height) & (height <= np.maximum(y[:, a], y[:, b]))
        at = x[:, a] + (height - y[:, a]) / np.where(rise == 0, 1.0, rise) * (x[:, b] - x[:, a])
        meets = inside & (rise != 0)
        left = np.where(meets, np.minimum(left, at), left)
        right = np.where(meets, np.maximum(right, at), right)
    empty = left > right
    return np.where(empty, 0.0, left), np.where(empty, -1.0, right)


def _slopes(x: Array, y: Array, z: Array) -> tuple[Array, Array]:
    """Return the slopes of the depth along x and y on each triangle; 0 if it is seen edge on."""
    ax, ay, az = x[:, 1] - x[:, 0], y[:, 1] - y[:, 0], z[:, 1] - z[:, 0]
    bx, by, bz = x[:, 2] - x[:, 0], y[:, 2] - y[:, 0], z[:, 2] - z[:, 0]
    area = ax * by - ay * bx
    area[area == 0] = np.inf
    return (az * by - ay * bz) / area, (ax * bz - az * bx) / area


FIELD = np.radians(30.0)  # height of the field of view
MARGIN = 1.2


class Camera(NamedTuple):
    """Its place, its axes right, up and back as columns, and pixels per unit of slope, for a picture of this size."""

    place: Array
    axes: Array
    scale: float
    width: int
    height: int

    def seen(self, points: Array) -> Array:
        """Points (..., 3) as x to the right, y downwards [pixels], and depth, -1 / distance along the view [1/m]."""
        local = (points - self.place) @ self.axes
        depth = np.maximum(-local[..., 2], POINT)
        x = self.width / 2 + self.scale * local[..., 0] / depth
        y = self.height / 2 - self.scale * local[..., 1] / depth
        return np.stack([x, y, -1 / depth], axis=-1)


def camera(points: Array, up: Array, view: str, width: int, height: int) -> Camera:
    """A camera that sees all points (n, 3): from a corner ("iso"), or along "x", "y" or "z"."""
    low, high = points.min(axis=0), points.max(axis=0)
    center = (low + high) / 2
    back = _direction(up, view)
    above = up if abs(back @ up) < 0.99 else upright(up)[:, 1]
    right = np.cross(above, back)
    right = right / np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(back, right), back])
    slope = np.tan(FIELD / 2)
    local = (points - center) @ axes
    needed = np.maximum(abs(local[:, 1]) / slope, abs(local[:, 0]) / (slope * width / height))
    distance = max(float(np.max(local[:, 2] + MARGIN * needed)), float(np.linalg.norm(high - low)), POINT)
    return Camera(center + distance * back, axes, height / (2 * slope), width, height)


def _direction(up: Array, view: str) -> Array:
    """Return the direction from the mechanism to the camera."""
    straight = {"x": np.eye(3)[0], "y": -np.eye(3)[1], "z": np.eye(3)[2]}
    if view in straight:
        return np.asarray(straight[view])
    back = upright(up) @ [0.62, -1.0, 0.5]
    return np.asarray(back / np.linalg.norm(back))
