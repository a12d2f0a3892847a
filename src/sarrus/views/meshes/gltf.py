"""glTF 2.0: .gltf with its buffers, or .glb; triangles in the axes of the file."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ...algebra import Array
from ...model.geometry.rotation import matrix
from .colored import Colored, Nodes, beside, content, hexadecimal
from .mesh import Mesh, affine

KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TRIANGLES = 4


def read_gltf(file: Path) -> Iterator[Colored]:
    """Yield all triangles of the file's scene."""
    yield from _Reader(file).pieces()


class _Reader:
    def __init__(self, file: Path) -> None:
        data = content(file)
        self.file, self.embedded, self.nodes = file, b"", Nodes()
        self.buffers: dict[int, bytes] = {}
        if data[:4] == b"glTF":
            size = int.from_bytes(data[12:16], "little")
            self.document: dict[str, Any] = json.loads(data[20 : 20 + size])
            self.embedded = data[28 + size :]
        else:
            self.document = json.loads(data)

    def pieces(self) -> Iterator[Colored]:
        scenes = self.document.get("scenes") or [{"nodes": range(len(self.document["nodes"]))}]
        yield from self._nodes(scenes[self.document.get("scene", 0)]["nodes"], np.eye(4))

    def _nodes(self, numbers: Any, place: Array, depth: int = 1) -> Iterator[Colored]:
        for number in numbers:
            self.nodes.place(depth)
            node = self.document["nodes"][number]
            here = place @ _matrix(node)
            if "mesh" in node:
                yield from self._mesh(self.document["meshes"][node["mesh"]], here)
            yield from self._nodes(node.get("children", ()), here, depth + 1)

    def _mesh(self, mesh: dict[str, Any], place: Array) -> Iterator[Colored]:
        for piece in mesh["primitives"]:
            if piece.get("mode", TRIANGLES) == TRIANGLES:
                points = self._array(piece["attributes"]["POSITION"]).astype(float)
                order = self._array(piece["indices"]) if "indices" in piece else np.arange(len(points))
                faces = order.reshape(-1, 3).astype(np.int64)
                yield Colored(Mesh(points, faces).placed(place), self._color(piece))

    def _array(self, number: int) -> Array:
        accessor = self.document["accessors"][number]
        view = self.document["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(KINDS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        data = self._buffer(view["buffer"])
        if accessor["count"] > len(data):  # a stride of zero would need no more bytes
            raise ValueError("it has fewer numbers than declared")
        rows = np.ndarray((accessor["count"], width), kind, data, start, (stride, kind.itemsize))
        return np.asarray(rows)

    def _buffer(self, number: int) -> bytes:
        if number not in self.buffers:
            self.buffers[number] = self._read(self.document["buffers"][number].get("uri", ""))
        return self.buffers[number]

    def _read(self, uri: str) -> bytes:
        if not uri:
            return self.embedded
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        return content(beside(self.file, unquote(uri)))

    def _color(self, piece: dict[str, Any]) -> str:
        if "material" not in piece:
            return ""
        surface = self.document["materials"][piece["material"]].get("pbrMetallicRoughness", {})
        linear = np.array(surface.get("baseColorFactor", (1.0, 1.0, 1.0)))[:3]
        return hexadecimal(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))


def _matrix(node: dict[str, Any]) -> Array:
    """A node's 4 × 4 matrix, given whole or as translation, rotation and scale."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    turn = matrix(np.roll(np.array(node.get("rotation", (0.0, 0.0, 0.0, 1.0)), dtype=float), 1))
    return affine(
        turn * np.array(node.get("scale", (1.0, 1.0, 1.0))), node.get("translation", (0.0, 0.0, 0.0))
    )
