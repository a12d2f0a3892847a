"""Large meshes with fewer triangles: corners that lie in one cell of a grid become one."""

from __future__ import annotations

import numpy as np

from ..shapes import Mesh

MOST = 20_000  # triangles that a browser turns with ease, and that a page holds in less than half a megabyte
FINEST, COARSEST = 512, 4  # cells along the longest side


def thinned(mesh: Mesh, most: int = MOST) -> Mesh:
    """The mesh itself if it has at most so many triangles, or the finest of clusters that has.

    A corner moves by less than the diagonal of a cell; triangles that have lost their area are left out.
    """
    cells = FINEST
    found = mesh
    while len(found.faces) > most and cells >= COARSEST:
        found = _clustered(mesh, cells)
        cells = int(cells / 1.3)
    return found


def _clustered(mesh: Mesh, cells: int) -> Mesh:
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = float((high - low).max()) / cells or 1.0
    keys = np.floor((mesh.vertices - low) / size).astype(np.int64)
    _, owner, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    owner = owner.reshape(-1)
    sums = np.zeros((len(count), 3))
    np.add.at(sums, owner, mesh.vertices)
    faces = owner[mesh.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return Mesh(sums / count[:, None], faces[np.sort(first)])
