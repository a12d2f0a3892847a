"""Good files of every kind, which the mutations begin with."""

from __future__ import annotations

import base64
import json
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"```yaml\n(.*?)```", re.DOTALL)

STUDY = """\
name: springs
model: crank.yaml
parameters:
  spring.k: {from: 5 N/m, to: 15, count: 3}
  rod.mass: [0.5, 2]
responses:
  reach: max(slider.x) - min(slider.x)
  end: slider.x
analysis: {type: simulate, until: 0.2, steps: 50, method: {type: hht, alpha: -0.1}}
sample: {type: latin_hypercube, count: 8, seed: 1}
"""
SPREAD = STUDY.replace("[0.5, 2]", "{distribution: norm, loc: 1, scale: 0.1}").replace(
    "latin_hypercube", "monte_carlo"
)
STATIC = """\
model: crank.yaml
parameters: {rod.mass: [1, 2]}
responses: {end: slider.x}
analysis: {type: statics}
"""
OPTIMIZATION = """\
model: crank.yaml
parameters:
  spring.k: {from: 1, to: 60, start: 10}
minimize: max(slider.x)
constraints:
  reach: {of: mean(slider.x), lower: 0, upper: 10}
analysis: {type: simulate, until: 0.2, method: {type: hht, alpha: -0.1}}
solver: SLSQP
starts: 2
seed: 3
iterations: 10
"""
FIT = """\
model: crank.yaml
parameters: {spring.k: {from: 1, to: 60}}
fit:
  - {of: slider.x, file: data.csv, time: t, column: x, sigma: 0.01}
analysis: {type: simulate, until: 0.2}
noise: estimated
"""
MJCF = """<mujoco model="arm"><compiler angle="radian"/><option gravity="0 0 -9.81"/>
<default><geom density="1000"/></default>
<worldbody><body name="a" pos="0 0 1">
<joint name="j" type="hinge" axis="0 1 0" range="-1 1" limited="true" damping="0.1"/>
<geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.05"/><body name="b" pos="0.5 0 0">
<joint name="k" type="slide" axis="1 0 0"/>
<geom type="box" size="0.1 0.1 0.1"/><site name="s" pos="0 0 0.1"/></body></body>
<body name="c" pos="1 0 1"><freejoint name="f"/><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
<geom size="0.1"/></body>
<replicate count="3" offset="0 1 0"><body pos="2 0 0"><joint axis="0 0 1"/><geom size="0.1"/></body></replicate>
</worldbody>
<equality><connect body1="b" body2="c" anchor="0 0 0"/></equality>
<actuator><motor joint="j"/></actuator></mujoco>"""


def models() -> list[bytes]:
    """The examples, the mechanisms of the package, and what the guide shows."""
    files = [
        *sorted((ROOT / "examples").glob("*.yaml")),
        *sorted((ROOT / "src/sarrus/mechanisms").glob("*.yaml")),
    ]
    texts = [file.read_text() for file in files] + BLOCK.findall((ROOT / "docs/model-file.md").read_text())
    return [
        text.encode() for text in texts if "name:" in text and "bodies:" in text and "include:" not in text
    ]


def json_models() -> list[bytes]:
    found = []
    for text in models():
        try:
            found.append(json.dumps(yaml.safe_load(text)).encode())
        except (yaml.YAMLError, TypeError):
            continue
    return found


def urdfs() -> list[bytes]:
    panda = (ROOT / "tests/io/data/panda.urdf").read_bytes()
    small = re.sub(rb"<(visual|collision)>.*?</\1>", b"", panda, flags=re.DOTALL)
    return [panda, small, small, small]


def meshes() -> dict[str, bytes]:
    """A triangle pyramid in every format, by ending."""
    points, faces = (
        np.vstack([np.zeros(3), np.eye(3)]).astype("<f4"),
        np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
    )
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *points[face].reshape(-1), 0) for face in faces)
    lines = "".join(f"v {x} {y} {z}\n" for x, y, z in points) + "vn 0 0 1\nusemtl red\n"
    obj = (
        "mtllib a.mtl\n"
        + lines
        + "".join("f " + " ".join(f"{k + 1}//1" for k in face) + "\n" for face in faces)
    )
    text = (
        "solid a\n"
        + "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join("vertex {} {} {}\n".format(*points[k]) for k in face)
            + "endloop\nendfacet\n"
            for face in faces
        )
        + "endsolid a\n"
    )
    return {
        "binary.stl": bytes(80) + struct.pack("<I", len(faces)) + facets,
        "text.stl": text.encode(),
        "a.obj": obj.encode(),
        "a.dae": _dae(points, faces).encode(),
        "a.gltf": json.dumps(_gltf(points, faces, True)).encode(),
        "a.glb": _glb(points, faces),
    }  # fmt: skip


def _gltf(points: Any, faces: Any, inside: bool) -> dict[str, Any]:
    data = points.tobytes() + faces.astype("<u2").tobytes()
    uri = {"uri": "data:;base64," + base64.b64encode(data).decode()} if inside else {}
    return {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"children": [1], "scale": [2, 2, 2]},
            {"mesh": 0, "rotation": [0, 0, 0, 1], "translation": [1, 0, 0]},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": len(data), **uri}],
    }


def _glb(points: Any, faces: Any) -> bytes:
    data = points.tobytes() + faces.astype("<u2").tobytes()
    text = json.dumps(_gltf(points, faces, False)).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _dae(points: Any, faces: Any) -> str:
    numbers, corners = (
        " ".join(str(x) for x in points.reshape(-1)),
        " ".join(str(k) for k in faces.reshape(-1)),
    )
    names = "".join(f'<param name="{name}" type="float"/>' for name in "XYZ")
    return f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/></asset><library_effects><effect id="e"><profile_COMMON><technique sid="c"><phong><diffuse>
<color>1 0 0 1</color></diffuse></phong></technique></profile_COMMON></effect></library_effects><library_materials>
<material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">{numbers}</float_array>
<technique_common><accessor source="#a" count="4" stride="3">{names}</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="4" material="s"><input semantic="VERTEX" source="#v" offset="0"/><vcount>3 3 3 3</vcount>
<p>{corners}</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node><translate>1 0 0</translate><rotate>0 0 1 90</rotate>
<scale>2 2 2</scale><instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="s" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>"""
