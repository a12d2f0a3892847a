"""Coloured triangles of a mesh file, and limits: it costs seconds at most, and reads nothing outside of its folder."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from .mesh import Mesh


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


LARGEST = 64 * 2**20  # bytes of a file
DEEPEST = 64  # nodes within nodes
MOST_NODES = 5_000  # as placed: a node that is used twice counts twice
MOST_TRIANGLES = 5_000_000  # as placed
FARTHEST = 1e30  # of a corner from the origin: areas and their squares remain finite numbers


def content(file: Path) -> bytes:
    """The bytes of a regular file that is not too large."""
    if file.exists() and not file.is_file():
        raise ValueError("it is not a regular file")
    with file.open("rb") as stream:
        data = stream.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise ValueError(f"it is larger than {LARGEST // 2**20} MB")
    return data


def beside(file: Path, name: str) -> Path:
    """A file that a mesh file names; it must be in the same folder or below, links followed."""
    folder = file.resolve().parent
    found = (folder / name).resolve()
    if not found.is_relative_to(folder):
        raise ValueError(f"it names {name}, which is outside of its folder")
    return found


class Nodes:
    """Counts the nodes of a scene as they are placed."""

    def __init__(self) -> None:
        self.count = 0

    def place(self, depth: int) -> None:
        """Count one, at a depth; a scene that contains itself has no end of depth."""
        self.count += 1
        if depth > DEEPEST:
            raise ValueError(f"its nodes are nested deeper than {DEEPEST} levels, or contain themselves")
        if self.count > MOST_NODES:
            raise ValueError(f"it places more than {MOST_NODES} nodes")


def bounded(pieces: Iterable[Colored]) -> Iterator[Colored]:
    """The pieces of a file, whose corners are finite and exist, and whose triangles can be counted."""
    total = 0
    for piece in pieces:
        vertices, faces = piece.mesh
        total += len(faces)
        if total > MOST_TRIANGLES:
            raise ValueError(f"it has more than {MOST_TRIANGLES} triangles")
        if not (np.abs(vertices) < FARTHEST).all():
            raise ValueError("it has a corner that is not a finite number, or too far away")
        if len(faces) and not 0 <= faces.min() <= faces.max() < len(vertices):
            raise ValueError("it has a triangle whose corners do not exist")
        yield piece
    if not total:
        raise ValueError("it has no triangles")
