"""Mesh files, read by trimesh within limits: in seconds, and nothing outside of their folder."""

from __future__ import annotations

import io
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from ..errors import ModelError

KINDS = (".stl", ".obj", ".gltf", ".glb", ".dae", ".ply")
LARGEST = 64 * 2**20  # bytes of a file
DEEPEST = 64  # nodes within nodes
MOST_NODES = 5_000  # as placed: a node that is used twice counts twice
MOST_TRIANGLES = 5_000_000  # as placed
FARTHEST = 1e30  # of a corner from the origin: areas and their squares remain finite numbers

NOT_FINITE = "it has a corner that is not a finite number, or too far away"


class MeshError(ModelError):
    """A mesh file that cannot be read."""


class MissingReaderError(MeshError):
    """No mesh file can be read: trimesh is not installed."""


def read_scene(file: Path) -> Any:
    """Return the triangles of a mesh file as trimesh's scene, in metres where the file has a unit.

    Raises
    ------
    MeshError
        If there is no such file, its content cannot be read, or trimesh is not installed, in one message.
    """
    kind = file.suffix.lower()
    if kind not in KINDS:
        raise MeshError(f"{file}: meshes must end in {', '.join(KINDS)}. Convert it.")
    try:
        import collada  # noqa: F401  # by which trimesh reads .dae
        import trimesh
    except ImportError:
        message = "trimesh, which reads meshes, is not installed. Install it with: pip install 'sarrus[mesh]'"
        raise MissingReaderError(message) from None
    try:
        data = _content(file)
        folder: Any = _Folder(file)
        unit = _unit(data) if kind == ".dae" else 1.0
        with np.errstate(all="ignore"):
            scene: Any = trimesh.load_scene(io.BytesIO(data), kind[1:], resolver=folder, process=False)
            if folder.refused:
                raise ValueError(folder.refused)
            if scene.geometry:
                scene.apply_transform(np.diag([unit, unit, unit, 1.0]))
            _check(scene)
    except FileNotFoundError:
        raise MeshError(f"{file}: does not exist. Check the path.") from None
    except OSError as error:
        raise MeshError(f"{file}: {(error.strerror or str(error)).lower()}. Check the path.") from None
    except Exception as error:  # foreign code: whatever it raises
        raise MeshError(f"{file}: is no mesh that can be read ({error}). Export it again.") from None
    return scene


class _Folder:
    """The files that a mesh file names; they must be in the same folder or below, links followed."""

    def __init__(self, file: Path) -> None:
        self.folder, self.refused = file.resolve().parent, ""

    def get(self, name: str) -> bytes:
        found = (self.folder / unquote(name)).resolve()
        if not found.is_relative_to(self.folder):
            self.refused = f"it names {name}, which is outside of its folder"
            raise ValueError(self.refused)
        if not found.is_file():
            raise ValueError(f"it is damaged, or {name} is missing")
        return _content(found)

    __getitem__ = get


def _content(file: Path) -> bytes:
    """The bytes of a regular file that is not too large."""
    if file.exists() and not file.is_file():
        raise ValueError("it is not a regular file")
    with file.open("rb") as stream:
        data = stream.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise ValueError(f"it is larger than {LARGEST // 2**20} MB")
    return data


def _check(scene: Any) -> None:
    """Refuse corners that are not finite or do not exist, and more triangles than can be drawn."""
    nodes = scene.graph.nodes_geometry
    faces = [getattr(scene.geometry[scene.graph[node][1]], "faces", ()) for node in nodes]
    if not 0 < sum(map(len, faces)) <= MOST_TRIANGLES:
        raise ValueError(f"it has no triangles, or more than {MOST_TRIANGLES}")
    for mesh in scene.geometry.values():
        count = len(mesh.vertices)
        if len(getattr(mesh, "faces", ())) and not 0 <= mesh.faces.min() <= mesh.faces.max() < count:
            raise ValueError("it has a triangle whose corners do not exist")
    for node in nodes:
        place, name = scene.graph[node]
        if not (np.abs(scene.geometry[name].vertices @ place[:3, :3].T + place[:3, 3]) < FARTHEST).all():
            raise ValueError(NOT_FINITE)


class _Builder(ElementTree.TreeBuilder):
    """Accepts no document type, so that no entity can be declared."""

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise ValueError("it declares a document type, which could define entities")


def _unit(data: bytes) -> float:
    """The unit of a COLLADA document [m]; one that contains itself, or places very many nodes, is refused."""
    root = ElementTree.fromstring(data, ElementTree.XMLParser(target=_Builder()))
    for array in root.iterfind(
        ".//{*}float_array"
    ):  # in which pycollada makes numbers of those that are none
        if not (np.abs(np.array((array.text or "").split(), dtype=float)) < FARTHEST).all():
            raise ValueError(NOT_FINITE)
    for sides in root.iterfind(".//{*}vcount"):
        counts = [int(count) for count in (sides.text or "").split()]
        if min(counts, default=0) < 0 or sum(counts) > len(data):
            raise ValueError("its polygons have more corners than it lists")
    by_id = {node.get("id"): node for node in root.iterfind(".//{*}node")}

    @cache
    def placed(node: Any, depth: int) -> int:
        if depth > DEEPEST:
            raise ValueError(f"its nodes are nested deeper than {DEEPEST} levels, or contain themselves")
        used = [by_id.get(one.get("url", "")[1:]) for one in node.iterfind("{*}instance_node")]
        inner = [*node.iterfind("{*}node"), *(one for one in used if one is not None)]
        return 1 + sum(placed(one, depth + 1) for one in inner)

    if sum(placed(scene, 0) for scene in root.iterfind(".//{*}visual_scene")) > MOST_NODES:
        raise ValueError(f"it places more than {MOST_NODES} nodes")
    unit = root.find("{*}asset/{*}unit")
    return 1.0 if unit is None else float(unit.get("meter", 1.0))
