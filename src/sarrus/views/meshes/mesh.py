"""A triangle mesh: its corners and triangles, how it is moved, and the normals that shade it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ...algebra import Array


class Mesh(NamedTuple):
    """Corners (n, 3) [m] and triangles (m, 3); corners are shared where the surface is smooth."""

    vertices: Array
    faces: Array

    def moved(self, r: Array, axes: Array | None = None) -> Mesh:
        """The mesh turned by a matrix, then shifted by r."""
        turned = self.vertices if axes is None else self.vertices @ np.asarray(axes).T
        return Mesh(turned + np.asarray(r), self.faces)

    def stretched(self, factors: Iterable[float]) -> Mesh:
        """The mesh stretched along its axes; turned inside out by a mirror, it is turned back."""
        scale = np.array([*factors], dtype=float)
        return Mesh(self.vertices * scale, self.faces if np.prod(scale) > 0 else self.faces[:, ::-1])


class Facets(NamedTuple):
    """Triangles, and their colour ``"#rrggbb"``, empty if the file has none."""

    mesh: Mesh
    color: str = ""


POINT = 1e-6  # of the size of a drawing: what is smaller is a point
EMPTY = Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))


def upright(up: Array) -> Array:
    """A rotation matrix whose third column is ``up``, the first, where that can be, along x."""
    across = np.eye(3)[0] if abs(up[0]) < 0.9 else np.eye(3)[1]
    f = across - (across @ up) * up
    f = f / np.linalg.norm(f)
    return np.column_stack([f, np.cross(up, f), up])


def joined(meshes: Iterable[Mesh]) -> Mesh:
    parts = [EMPTY, *meshes]
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=True)]
    return Mesh(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))


def normals(mesh: Mesh) -> Array:
    """Unit normals at the corners (n, 3): means of the triangles around, by their areas."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    total = np.zeros_like(mesh.vertices)
    for k in range(3):
        np.add.at(total, mesh.faces[:, k], across)
    size = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(np.where(size > 0, total / np.where(size > 0, size, 1.0), [0.0, 0.0, 1.0]))


def rgb(color: str) -> Array:
    """Red, green and blue (3,) from 0 to 1 of a colour ``"#rrggbb"``."""
    return np.array([int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)])


def along(direction: Array) -> Array:
    """A rotation matrix whose third column is along a direction."""
    h = np.asarray(direction, dtype=float)
    h = h / np.linalg.norm(h)
    helper = np.eye(3)[np.argmin(abs(h))]
    f = np.cross(helper, h)
    f /= np.linalg.norm(f)
    return np.column_stack([f, np.cross(h, f), h])
