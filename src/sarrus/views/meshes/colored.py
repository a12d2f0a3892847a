"""A piece of a mesh file: triangles of one colour."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ..shapes import Mesh


class MeshError(SarrusError):
    """A mesh file that cannot be read."""


class Colored(NamedTuple):
    """Triangles, and their colour ``"#rrggbb"``, empty if the file has none."""

    mesh: Mesh
    color: str = ""


def welded(corners: Array, keys: Array) -> Mesh:
    """A mesh of triangles (n, 3, 3) whose corners are shared where their keys (n, 3, k) are the same."""
    flat = keys.reshape(len(corners) * 3, -1)
    _, first, inverse = np.unique(flat, axis=0, return_index=True, return_inverse=True)
    return Mesh(corners.reshape(-1, 3)[first], inverse.reshape(-1, 3))


def hexadecimal(rgb: Array) -> str:
    """A colour from 0 to 1 as text."""
    return "#" + "".join(f"{round(255 * float(np.clip(c, 0, 1))):02x}" for c in rgb[:3])
