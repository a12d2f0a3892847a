"""COLLADA (.dae), as robots' descriptions have it: triangles and polygons, in the axes of the file, in metres."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ...algebra import Array
from ...model.geometry.motion import axis_angle, unit
from ...model.geometry.rotation import matrix
from .colored import Colored, Nodes, content, hexadecimal, welded
from .mesh import affine

POLYGONS = ("triangles", "polylist", "polygons")


def read_dae(file: Path) -> Iterator[Colored]:
    """Yield all triangles of the file's scene."""
    try:
        root = ElementTree.fromstring(content(file), ElementTree.XMLParser(target=_Builder()))
    except ElementTree.ParseError as error:
        raise ValueError(str(error)) from None
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    yield from _Reader(root).pieces()


class _Builder(ElementTree.TreeBuilder):
    """Accepts no document type, so that no entity can be declared."""

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise ValueError("it declares a document type, which could define entities")


class _Reader:
    def __init__(self, root: Any) -> None:
        self.root = root
        self.nodes = Nodes()
        self.by_id = {element.get("id"): element for element in root.iter() if element.get("id")}
        unit = root.find("asset/unit")
        self.meter = float(unit.get("meter", 1.0)) if unit is not None else 1.0

    def pieces(self) -> Iterator[Colored]:
        scale = np.diag([self.meter, self.meter, self.meter, 1.0])
        for scene in self.root.iter("visual_scene"):
            yield from self._nodes(scene.findall("node"), scale)

    def _nodes(self, nodes: Iterable[Any], place: Array, depth: int = 1) -> Iterator[Colored]:
        for node in nodes:
            self.nodes.place(depth)
            here = place @ _matrix(node)
            for used in node.findall("instance_geometry"):
                yield from self._geometry(self._of(used.get("url")), here, self._materials(used))
            used_nodes = (self._of(used.get("url")) for used in node.findall("instance_node"))
            yield from self._nodes((*used_nodes, *node.findall("node")), here, depth + 1)

    def _of(self, reference: str) -> Any:
        return self.by_id[reference.removeprefix("#")]

    def _materials(self, used: Any) -> dict[str, str]:
        return {one.get("symbol"): self._color(one.get("target")) for one in used.iter("instance_material")}

    def _color(self, material: str) -> str:
        effect = self._of(self._of(material).find("instance_effect").get("url"))
        diffuse = effect.find(".//diffuse/color")
        return "" if diffuse is None else hexadecimal(np.array([float(x) for x in diffuse.text.split()]))

    def _geometry(self, geometry: Any, place: Array, materials: dict[str, str]) -> Iterator[Colored]:
        for piece in (p for kind in POLYGONS for p in geometry.iter(kind)):
            inputs = {one.get("semantic"): one for one in piece.findall("input")}
            width = 1 + max(int(one.get("offset")) for one in inputs.values())
            corners = _triangles(piece, width)
            vertices = self._of(inputs["VERTEX"].get("source"))
            source = next(one for one in vertices.findall("input") if one.get("semantic") == "POSITION")
            points = self._points(self._of(source.get("source")))
            which = corners[:, :, int(inputs["VERTEX"].get("offset"))]
            normal = corners[:, :, int(inputs["NORMAL"].get("offset"))] if "NORMAL" in inputs else 0 * which
            if len(which):
                mesh = welded(points[which], np.stack([which, normal], axis=-1)).placed(place)
                yield Colored(mesh, materials.get(piece.get("material"), ""))

    def _points(self, source: Any) -> Array:
        numbers = np.array(source.find("float_array").text.split(), dtype=float)
        return numbers.reshape(-1, int(source.find("technique_common/accessor").get("stride", 3)))[:, :3]


def _triangles(piece: Any, width: int) -> Array:
    """Indices (n, 3, width) of all triangles; polygons are cut into fans."""
    numbers = [
        np.array((p.text or "").split(), dtype=np.int64).reshape(-1, width) for p in piece.findall("p")
    ]
    if piece.tag == "triangles":
        return np.concatenate(numbers).reshape(-1, 3, width) if numbers else np.zeros((0, 3, width), np.int64)
    sides = piece.find("vcount")
    counts = [len(p) for p in numbers] if sides is None else [int(x) for x in sides.text.split()]
    corners, start = np.concatenate(numbers), np.cumsum([0, *counts])
    if start[-1] != len(corners) or min(counts, default=0) < 0:
        raise ValueError(f"its polygons have {start[-1]} corners by <vcount> and {len(corners)} by <p>")
    fans = [(a, a + k, a + k + 1) for a, n in zip(start, counts, strict=False) for k in range(1, n - 1)]
    return np.asarray(corners[np.array(fans)])


def _matrix(node: Any) -> Array:
    """A node's 4 × 4 matrix: its transformations one after the other."""
    here = np.eye(4)
    for step in node:
        numbers = [float(x) for x in (step.text or "").split()] if step.tag in _STEPS else []
        if numbers:
            here = here @ _STEPS[step.tag](np.array(numbers))
    return here


_STEPS: dict[str, Any] = {
    "matrix": lambda m: m.reshape(4, 4),
    "translate": lambda r: affine(np.eye(3), r),
    "rotate": lambda turn: affine(matrix(axis_angle(unit(turn[:3]), np.radians(turn[3])))),
    "scale": lambda s: np.diag([*s, 1.0]),
}
