"""The given shape of a body: a solid, or a mesh file, as triangles with their colours."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ...algebra import Array
from ...model.bodies.mesh_file import MeshError, read_scene
from ...model.bodies.shape import Look
from .mesh import Facets, Mesh, joined
from .solids import ball, box, disc


@lru_cache(maxsize=64)
def read_mesh(file: Path) -> list[Facets]:
    """Return the parts of a mesh file, large ones thinned.

    Raises
    ------
    MeshError
        If there is no such file, or its content cannot be read, in one message.
    """
    scene, kind, parts = read_scene(file), file.suffix.lower(), list[Facets]()
    for place, name in map(scene.graph.get, scene.graph.nodes_geometry):
        if len(getattr(scene.geometry[name], "faces", ())):
            geometry = scene.geometry[name].copy()
            geometry.apply_transform(place)
            if kind != ".stl":  # whose triangles are flat
                geometry.merge_vertices(merge_tex=True)
            mesh = Mesh(np.array(geometry.vertices), np.array(geometry.faces))
            parts.append(Facets(thinned(mesh), _color(geometry.visual, linear=kind in (".gltf", ".glb"))))
    return parts


def _color(visual: Any, *, linear: bool) -> str:
    """The colour of a material as text; empty if there is none."""
    if not visual.defined:
        return ""
    rgb = np.array(visual.material.main_color if visual.kind == "texture" else visual.main_color)[:3] / 255
    if linear:
        rgb = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)
    return "#" + "".join(f"{round(255 * float(c)):02x}" for c in rgb)


MOST = 20_000  # triangles that a browser rotates smoothly, and that take less than half a megabyte in a page
FINEST, COARSEST = 300, 4  # cells along the longest side


def thinned(mesh: Mesh, most: int = MOST) -> Mesh:
    """The mesh itself if it has at most so many triangles, or the finest of clusters that has.

    A corner moves by less than the diagonal of a cell; triangles that have lost their area are left out.
    """
    cells, clusters = FINEST, mesh
    while len(clusters.faces) > most and cells >= COARSEST:
        clusters = _clustered(mesh, cells)
        # the number of faces grows with the square of that of cells
        cells = int(0.97 * cells * min((most / max(len(clusters.faces), 1)) ** 0.5, 1.0))
    return clusters


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


def given_meshes(look: Look) -> Iterator[Facets]:
    """Yield the meshes of a look in body axes.

    Raises
    ------
    MeshError
        If its file cannot be read.
    """
    pieces = _mesh(look) if look.shape == "mesh" else [Facets(_solid(look))]
    for mesh, color in pieces:
        yield Facets(mesh.moved(look.pose.r, look.pose.A), look.color or color)


def _mesh(look: Look) -> list[Facets]:
    if look.wrong or look.file is None:
        raise MeshError(look.wrong or "a mesh has no file. Name one.")
    return [Facets(mesh.stretched(look.size), color) for mesh, color in read_mesh(look.file)]


def _solid(look: Look) -> Mesh:
    size = [float(x) for x in look.size]
    match look.shape:
        case "box":
            return box(size)
        case "sphere":
            return ball(size[0])
        case "ellipsoid":
            return ball(1.0).stretched(size)
        case "cylinder":
            return disc(size[0], -size[1] / 2, size[1] / 2)
        case _:
            end = np.array([0.0, 0.0, size[1] / 2])
            return joined([disc(size[0], -size[1] / 2, size[1] / 2), ball(size[0], end), ball(size[0], -end)])
