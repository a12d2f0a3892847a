"""Large meshes with fewer triangles: corners that lie in one cell of a grid become one."""

from __future__ import annotations

import numpy as np

from ...algebra import Array
from ..shapes import Mesh

MOST = 20_000  # triangles that a browser rotates smoothly, and that take less than half a megabyte in a page
FINEST, COARSEST = 300, 4  # cells along the longest side


def thinned(mesh: Mesh, most: int = MOST) -> Mesh:
    """The mesh itself if it has at most so many triangles, or the finest of clusters that has.

    A corner moves by less than the diagonal of a cell; triangles that have lost their area are left out.
    """
    cells, found = FINEST, mesh
    while len(found.faces) > most and cells >= COARSEST:
        found = _clustered(mesh, cells)
        cells = int(
            0.97 * cells * min((most / max(len(found.faces), 1)) ** 0.5, 1.0)
        )  # faces grow with its square
    return found


def _clustered(mesh: Mesh, cells: int) -> Mesh:
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = float((high - low).max()) / cells or 1.0
    keys = _one_number(np.floor((mesh.vertices - low) / size).astype(np.int64), cells + 1)
    _, owner, count = np.unique(keys, return_inverse=True, return_counts=True)
    sums = np.column_stack([np.bincount(owner, column) for column in mesh.vertices.T])
    faces = owner[mesh.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(_one_number(np.sort(faces, axis=1), len(count)), return_index=True)
    return Mesh(sums / count[:, None], faces[np.sort(first)])


def _one_number(triples: Array, base: int) -> Array:
    """Triples of whole numbers below ``base`` as one number each."""
    return (triples[:, 0] * base + triples[:, 1]) * base + triples[:, 2]
