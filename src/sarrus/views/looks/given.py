"""The look of a body with a given shape: meshes, boxes, cylinders, spheres and capsules."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...model.bodies.shape import Look
from ..meshes import Colored, MeshError, read_mesh
from ..shapes import Mesh, ball, box, disc
from ..shapes.mesh import joined


def given_meshes(look: Look) -> Iterator[Colored]:
    """Yield the meshes of a look in body axes.

    Raises
    ------
    MeshError
        If its file cannot be read.
    """
    pieces = _mesh(look) if look.shape == "mesh" else [Colored(_solid(look))]
    for mesh, color in pieces:
        yield Colored(mesh.moved(look.pose.r, look.pose.A), look.color or color)


def _mesh(look: Look) -> list[Colored]:
    if look.wrong or look.file is None:
        raise MeshError(look.wrong or "a mesh has no file; name one")
    return [Colored(mesh.stretched(look.size), color) for mesh, color in read_mesh(look.file)]


def _solid(look: Look) -> Mesh:
    size = [float(x) for x in look.size]
    match look.shape:
        case "box":
            return box(size)
        case "sphere":
            return ball(size[0])
        case "cylinder":
            return disc(size[0], -size[1] / 2, size[1] / 2)
        case _:
            end = np.array([0.0, 0.0, size[1] / 2])
            return joined([disc(size[0], -size[1] / 2, size[1] / 2), ball(size[0], end), ball(size[0], -end)])
