"""GLB, the binary form of glTF 2.0: a mechanism, and its motion as an animation, for other programs."""

from __future__ import annotations

import json
import struct
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np

from ..algebra import Array
from ..model.coordinates import slice_of
from ..results.saving.exported_file import exporting
from .browser import Scene
from .looks import Part, Span, place_of
from .meshes.mesh import normals, rgb


class Code(IntEnum):
    """Component types of glTF, and targets of buffer views."""

    UINT = 5125
    FLOAT = 5126
    VERTICES = 34962
    INDICES = 34963


def write_glb(scene: Scene, file: Path) -> Path:
    """Write a run, or a position, as GLB; z (or what is up) becomes the y axis of glTF. Returns the path."""
    content = _Writer(scene).bytes()
    with exporting(file) as draft:
        draft.write_bytes(content)
    return file


class _Writer:
    def __init__(self, scene: Scene) -> None:
        self.scene, self.sketch = scene, scene.sketch
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.materials: dict[tuple[str, float], int] = {}
        self.nodes: list[dict[str, Any]] = []
        self.channels: list[dict[str, Any]] = []
        self.samplers: list[dict[str, Any]] = []
        t = scene.frames.t
        self.times = self._accessor(t - t[0], "SCALAR") if len(t) > 1 else -1
        self._fill()

    def bytes(self) -> bytes:
        """The whole file."""
        text = json.dumps(self._document(), separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        body = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        heads = (struct.pack("<I4s", len(chunk), kind) for chunk, kind in ((text, b"JSON"), (body, b"BIN\0")))
        size = 12 + 8 + len(text) + 8 + len(body)
        return struct.pack("<4sII", b"glTF", 2, size) + next(heads) + text + next(heads) + body

    def _document(self) -> dict[str, Any]:
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "Sarrus"},
            "scene": 0,
            "scenes": [{"name": self.sketch.name, "nodes": [0]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": [_material(*look) for look in self.materials],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.data) + -len(self.data) % 4}],
        }
        if self.channels:
            animation = {"name": self.scene.name, "channels": self.channels, "samplers": self.samplers}
            document["animations"] = [animation]
        return document

    def _fill(self) -> None:
        """The root rotates z up into y up; below it the ground, the bodies, and the spans between them."""
        upward = _shortest_rotation(self.sketch.up[None], np.array([0.0, 1.0, 0.0]))[0]
        self._node(self.sketch.name, rotation=upward.tolist(), children=[])
        moving = (frame.name for frame in self.sketch.moving)
        for number, name in enumerate(("ground", *self.sketch.bodies, *moving)):
            node = self._node(name, children=[])
            self.nodes[0]["children"].append(node)
            for part in self.sketch.parts:
                if part.body == number:
                    self.nodes[node]["children"].append(self._node(part.name, mesh=self._mesh(part)))
            if number:
                q = self.scene.frames.q[:, slice_of(number - 1)]
                p = np.roll(q[:, 3:], -1, axis=1)  # the scalar last
                self._moves(node, translation=q[:, :3], rotation=p / np.linalg.norm(p, axis=1, keepdims=True))
        for span in self.sketch.spans:
            node = self._node(span.name, mesh=self._mesh(span))
            self.nodes[0]["children"].append(node)
            self._moves(node, **self._stretched(span))
        for entries in self.nodes:
            if not entries.get("children", True):
                del entries["children"]

    def _node(self, name: str, **entries: Any) -> int:
        self.nodes.append({"name": name, **entries})
        return len(self.nodes) - 1

    def _moves(self, node: int, **paths: Array) -> None:
        """Add the initial place of a node and, if there is a motion, its places at all times."""
        for path, values in paths.items():
            self.nodes[node][path] = values[0].tolist()
            if self.times >= 0 and np.ptp(values, axis=0).any():
                output = self._accessor(values, "VEC4" if values.shape[1] == 4 else "VEC3")
                self.samplers.append({"input": self.times, "output": output, "interpolation": "LINEAR"})
                target = {"node": node, "path": path}
                self.channels.append({"sampler": len(self.samplers) - 1, "target": target})

    def _stretched(self, span: Span) -> dict[str, Array]:
        q = self.scene.frames.q
        ends = (place_of(q, body, point) for body, point in zip(span.bodies, span.points, strict=True))
        place, way, stretch = span.placed(*ends)
        scale = np.column_stack([np.ones((len(way), 2)), stretch])
        rotation = _shortest_rotation(np.array([0.0, 0.0, 1.0]), way)
        return {"translation": place, "rotation": rotation, "scale": scale}

    def _mesh(self, part: Part | Span) -> int:
        look = (part.color, getattr(part, "opacity", 1.0))
        material = self.materials.setdefault(look, len(self.materials))
        attributes = {
            "POSITION": self._accessor(part.mesh.vertices, "VEC3", Code.VERTICES),
            "NORMAL": self._accessor(normals(part.mesh), "VEC3", Code.VERTICES),
        }
        triangles = self._accessor(part.mesh.faces.reshape(-1, 1), "SCALAR", Code.INDICES)
        primitive = {"attributes": attributes, "indices": triangles, "material": material}
        self.meshes.append({"name": part.name, "primitives": [primitive]})
        return len(self.meshes) - 1

    def _accessor(self, values: Array, kind: str, target: int | None = None) -> int:
        whole = target == Code.INDICES
        data = np.ascontiguousarray(values, dtype="<u4" if whole else "<f4")
        rows = data.reshape(len(data), -1)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": data.nbytes}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += data.tobytes()
        accessor = {
            "bufferView": len(self.views) - 1,
            "componentType": Code.UINT if whole else Code.FLOAT,
            "count": len(rows),
        }
        bounds = {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append({**accessor, "type": kind, **bounds})
        return len(self.accessors) - 1


def _material(color: str, opacity: float) -> dict[str, Any]:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb(color).tolist()]
    surface = {"baseColorFactor": [*linear, opacity], "metallicFactor": 0.1, "roughnessFactor": 0.55}
    glass = {"alphaMode": "BLEND"} if opacity < 1 else {}
    return {"pbrMetallicRoughness": surface, "doubleSided": opacity < 1, **glass}


def _shortest_rotation(start: Array, end: Array) -> Array:
    """Euler parameters (n, 4), scalar last, of the shortest rotations of unit vectors into others.

    Their sign does not jump. Opposite vectors, along y or z, are turned about x.
    """
    w = 1 + (start * end).sum(axis=1)
    p = np.column_stack([np.cross(start, end), w])
    p[w < 1e-9] = [1.0, 0.0, 0.0, 0.0]
    return np.asarray(p / np.linalg.norm(p, axis=1, keepdims=True))
