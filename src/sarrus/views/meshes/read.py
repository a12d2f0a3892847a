"""The given shape of a body: a solid, or a mesh file of any kind that is known, as triangles with their colours."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...algebra import Array
from ...model.bodies.shape import Look
from .colored import Colored, MeshError, bounded, content
from .dae import read_dae
from .gltf import read_gltf
from .mesh import Mesh, joined
from .obj import read_obj
from .solids import ball, box, disc

HEADER = 84  # bytes: text, and the number of triangles
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(file: Path) -> Iterator[Colored]:
    """Yield the triangles of an STL file; each keeps its own corners, and is seen flat."""
    data = content(file)
    count = int.from_bytes(data[80:HEADER], "little")
    if len(data) >= HEADER and len(data) == HEADER + RECORD.itemsize * count:
        corners = np.frombuffer(data, RECORD, count, HEADER)["corners"]
    else:
        lines = map(str.split, data.decode("ascii", "strict").splitlines())
        corners = np.array([[float(x) for x in words[1:4]] for words in lines if words[:1] == ["vertex"]])
    corners = corners.reshape(-1, 3)
    yield Colored(Mesh(corners.astype(float), np.arange(len(corners)).reshape(-1, 3)))


READERS: dict[str, Callable[[Path], Iterable[Colored]]] = {
    ".stl": read_stl,
    ".obj": read_obj,
    ".gltf": read_gltf,
    ".glb": read_gltf,
    ".dae": read_dae,
}

DAMAGED = (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RuntimeError, MemoryError)


@lru_cache(maxsize=64)
def read_mesh(file: Path) -> list[Colored]:
    """Return the parts of a mesh file, large ones thinned.

    Raises
    ------
    MeshError
        If there is no such file, or its content cannot be read, in one message.
    """
    reader = READERS.get(file.suffix.lower())
    if reader is None:
        raise MeshError(f"{file}: meshes must end in {', '.join(READERS)}. Convert it.")
    try:
        with np.errstate(all="ignore"):
            return [Colored(thinned(mesh), color) for mesh, color in bounded(reader(file))]
    except FileNotFoundError:
        raise MeshError(f"{file}: does not exist. Check the path.") from None
    except OSError as error:
        raise MeshError(f"{file}: {(error.strerror or str(error)).lower()}. Check the path.") from None
    except DAMAGED as error:
        raise MeshError(f"{file}: is no mesh that can be read ({error}). Export it again.") from None


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
        raise MeshError(look.wrong or "a mesh has no file. Name one.")
    return [Colored(mesh.stretched(look.size), color) for mesh, color in read_mesh(look.file)]


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
