"""Flat and convex bodies: boxes, plates with given corners, toothed wheels, links with round ends, hulls of points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra import Array
from .mesh import Mesh, joined


def box(size: Sequence[float] | Array) -> Mesh:
    """A box with its centre at the origin; edges sharp."""
    x, y, z = (float(s) / 2 for s in size)
    return plate(np.array([(-x, -y), (x, -y), (x, y), (-x, y)]), -z, z)


def plate(outline: Array, low: float, high: float) -> Mesh:
    """A convex outline (n, 2), counter-clockwise in x and y, from z = low to high."""
    n = len(outline)
    bottom, top = (np.column_stack([outline, np.full(n, z)]) for z in (low, high))
    fan = np.array([(0, k, k + 1) for k in range(1, n - 1)])
    return joined([Mesh(bottom, fan[:, ::-1]), Mesh(top, fan), *_sides(bottom, top)])


def toothed(radius: float, height: float, teeth: int, low: float, high: float) -> Mesh:
    """A toothed wheel about z: pitch radius, height of the teeth, from z = low to high."""
    steps = np.linspace(0.0, 2 * np.pi, 4 * teeth, endpoint=False)
    reach = radius + 0.5 * height * np.tile([1.0, 1.0, -1.0, -1.0], teeth)
    outline = reach[:, None] * np.column_stack([np.cos(steps), np.sin(steps)])
    n = len(outline)
    bottom, top = (
        np.column_stack([np.vstack([outline, [0.0, 0.0]]), np.full(n + 1, z)]) for z in (low, high)
    )
    fan = np.array([(n, k, (k + 1) % n) for k in range(n)])
    return joined([Mesh(bottom, fan[:, ::-1]), Mesh(top, fan), *_sides(bottom[:n], top[:n])])


def _sides(bottom: Array, top: Array) -> list[Mesh]:
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    after = np.roll(np.arange(len(bottom)), -1)
    return [Mesh(np.array([bottom[k], bottom[m], top[m], top[k]]), faces) for k, m in enumerate(after)]


def bar(length: float, radius: float, thickness: float) -> Mesh:
    """A link along x from 0 to ``length`` with round ends, flat across z."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 13)
    end = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    outline = np.concatenate([end + [length, 0.0], -end])
    return plate(outline, -thickness / 2, thickness / 2)


def hull(points: Array) -> Mesh | None:
    """The convex hull of points that span a volume, with sharp edges; None if they do not."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        found = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    triangles = points[found.simplices]
    a, b, c = (triangles[:, k] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), found.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
