"""Mesh files of every kind give the same box, and bodies are drawn with it."""

from __future__ import annotations

import json
import struct
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.views.page_parts import read
from tests.views.test_shapes import volume

import sarrus as sr
from sarrus import mechanisms
from sarrus.views.looks import sketch
from sarrus.views.meshes import MeshError, read_mesh, solids
from sarrus.views.meshes.read import thinned
from sarrus.views.meshes.solids import turned

BOX = solids.box((1.0, 2.0, 3.0)).moved(np.array([0.5, 0.0, 0.0]))
PANDA = Path(__file__).parents[1] / "io" / "data" / "panda.urdf"


def binary_stl(path: Path) -> None:
    records = [
        struct.pack("<12fH", 0, 0, 0, *corners.reshape(-1), 0)
        for corners in BOX.vertices[BOX.faces].astype("<f4")
    ]
    path.write_bytes(b"solid, but binary".ljust(80) + struct.pack("<I", len(records)) + b"".join(records))


def text_stl(path: Path) -> None:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners)
        + "endloop\nendfacet\n"
        for corners in BOX.vertices[BOX.faces]
    )
    path.write_text(f"solid box\n{facets}endsolid box\n")


def obj(path: Path) -> None:
    """With a material, a quadrilateral, normals, and corners counted from the end."""
    path.with_suffix(".mtl").write_text("newmtl red\nKd 1 0 0\n")
    corners = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (-1, 1) for z in (-1.5, 1.5))
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "-8 -6 -2 -4", "2//1 6//1 8//1 4//1"]
    text = "".join(f"f {face}\n" for face in faces)
    path.write_text(f"mtllib {path.stem}.mtl\n{corners}vn 0 0 1\nusemtl red\n{text}")


def glb(path: Path) -> None:
    """A node within a node: scales multiply."""
    points, faces = BOX.vertices.astype("<f4"), BOX.faces.astype("<u2")
    data = points.tobytes() + faces.tobytes()
    told = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "scale": [2, 2, 2]}, {"mesh": 0, "scale": [0.5, 0.5, 0.5]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": faces.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": faces.nbytes},
        ],
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(told).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01" name="centimeter"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="c"><phong><diffuse><color>1 0 0 1</color></diffuse>
</phong></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="24">{points}</float_array>
<technique_common><accessor source="#pa" count="8" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="6" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
<vcount>4 4 4 4 4 4</vcount><p>{faces}</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node><translate>50 0 0</translate><rotate>0 0 1 90</rotate>
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="s" target="#m"/>
</technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""


def dae(path: Path) -> None:
    """In centimetres, turned and shifted by its node."""
    corners = [(x, y, z) for x in (-100, 100) for y in (-50, 50) for z in (-150, 150)]
    faces = "0 1 3 2 4 6 7 5 0 4 5 1 2 3 7 6 0 2 6 4 1 5 7 3"
    path.write_text(DAE.format(points=" ".join(str(x) for corner in corners for x in corner), faces=faces))


WRITERS = {"binary.stl": binary_stl, "text.stl": text_stl, "box.obj": obj, "box.glb": glb, "box.dae": dae}


@pytest.mark.parametrize("name", WRITERS)
def test_every_kind_of_file_gives_the_box(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path / name)
    (piece,) = read_mesh(tmp_path / name)
    assert piece.mesh.vertices.min(axis=0) == pytest.approx([0.0, -1.0, -1.5], abs=1e-6)
    assert piece.mesh.vertices.max(axis=0) == pytest.approx([1.0, 1.0, 1.5])
    assert volume(piece.mesh) == pytest.approx(6.0)
    assert piece.color == ("" if name.endswith(".stl") else "#ff0000")


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("a.step", "", "meshes must end in .stl, .obj, .gltf, .glb, .dae, .ply. Convert it"),
        ("a.stl", "solid nothing\nendsolid", "is no mesh that can be read"),
        ("a.obj", "v 0 0 0\nf 1 2 9\n", "is no mesh that can be read"),
        ("a.dae", "<COLLADA>", "is no mesh that can be read"),
        ("a.gltf", "{}", "is no mesh that can be read"),
        ("a.glb", "glTF", "is no mesh that can be read"),
    ],
)
def test_wrong_files_are_told(name: str, text: str, told: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(MeshError, match=told):
        read_mesh(tmp_path / name)


def test_without_trimesh_the_command_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    binary_stl(tmp_path / "box.stl")
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(MeshError, match=r"pip install 'sarrus\[mesh\]'"):
        read_mesh(tmp_path / "box.stl")
    with pytest.raises(sr.ModelError, match=r"body \"b\": .*pip install 'sarrus\[mesh\]'"):
        sr.Body.from_mesh("b", tmp_path / "box.stl", mass=1.0)
    (tmp_path / "arm.urdf").write_text(URDF.replace("package://parts/meshes/", ""))
    with pytest.warns(sr.SarrusWarning, match=r"pip install 'sarrus\[mesh\]'"):
        assert sketch(sr.load_urdf(tmp_path / "arm.urdf")).parts


def with_shape(shape: sr.Shape) -> sr.Model:
    model = sr.load(mechanisms.path("slider_crank"))
    return replace(
        model, bodies=[replace(body, shape=shape) if body.name == "rod" else body for body in model.bodies]
    )


def test_a_body_is_drawn_with_its_mesh(tmp_path: Path) -> None:
    binary_stl(tmp_path / "box.stl")
    turned = sr.AxisAngle((0, 0, 1), np.pi / 2)
    shape = sr.Shape(
        str(tmp_path / "box.stl"), scale=0.1, position=(0, 0, 1), orientation=turned, color="#123456"
    )
    (rod,) = [part for part in sketch(with_shape(shape)).parts if part.name == "rod"]
    assert rod.color == "#123456"
    assert rod.mesh.vertices.min(axis=0) == pytest.approx([-0.1, 0.0, 0.85])
    assert rod.mesh.vertices.max(axis=0) == pytest.approx([0.1, 0.1, 1.15])


def test_a_model_file_names_its_mesh(tmp_path: Path) -> None:
    binary_stl(tmp_path / "box.stl")
    text = "name: block\nbodies:\n  block:\n    mass: 1\n    inertia: [1, 1, 1]\n"
    turn = "{axis: [0, 0, 1], angle: 0}"
    shape = f"    shape: {{file: box.stl, scale: 0.5, position: [0, 0, 10 mm], orientation: {turn}}}\n"
    (tmp_path / "block.yaml").write_text(text + shape)
    (block,) = sketch(sr.load(tmp_path / "block.yaml")).parts
    assert block.mesh.vertices.max(axis=0) == pytest.approx([0.5, 0.5, 0.76])


def test_a_shape_of_another_kind_is_refused_by_name() -> None:
    wrong: object = (sr.Shape("box.stl"),)
    with pytest.raises(sr.ModelError, match=r'body "rod".*shape must be a sarrus\.Shape, but is a tuple'):
        sketch(with_shape(wrong))  # type: ignore[arg-type]


def test_a_missing_mesh_is_an_error_with_the_body() -> None:
    with pytest.raises(sr.ModelError, match=r'body "rod".*none\.stl: does not exist. Check the path'):
        sketch(with_shape(sr.Shape("none.stl")))
    with pytest.raises(sr.ModelError, match=r'body "rod".*color must be like "#3b76b5", but is "red"'):
        sketch(with_shape(sr.Shape("none.stl", color="red")))


def test_a_robot_without_its_meshes_is_drawn_and_says_so(tmp_path: Path) -> None:
    robot = sr.load_urdf(PANDA, mimic="free")
    parts = read(robot.view(tmp_path / "arm.html"))
    assert parts.told["subtitle"] == "9 bodies, 11 meshes not found"
    assert "panda_link5" in {part["name"] for part in parts.told["sketches"][0]["parts"]}


URDF = """<robot name="arm"><link name="base"><visual>
<geometry><cylinder radius="0.1" length="0.2"/></geometry></visual>
</link><link name="tip"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><origin xyz="0 0 0.5"/>
<geometry><mesh filename="package://parts/meshes/box.stl" scale="0.1 0.1 0.1"/></geometry>
<material name="red"><color rgba="1 0 0 1"/></material></visual></link>
<joint name="pin" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>"""


def test_visuals_of_a_robot(tmp_path: Path) -> None:
    folder = tmp_path / "parts" / "meshes"
    folder.mkdir(parents=True)
    (tmp_path / "parts" / "urdf").mkdir()
    binary_stl(folder / "box.stl")
    (tmp_path / "parts" / "urdf" / "arm.urdf").write_text(URDF)
    drawn = sketch(sr.load_urdf(tmp_path / "parts" / "urdf" / "arm.urdf"))
    base, tip = (next(part for part in drawn.parts if part.name == name) for name in ("ground", "tip"))
    assert volume(base.mesh) == pytest.approx(np.pi * 0.01 * 0.2, rel=0.02)
    assert tip.color == "#ff0000"
    assert tip.mesh.vertices.max(axis=0) == pytest.approx([0.1, 0.1, 0.65])
    assert not drawn.notes


def test_large_meshes_are_thinned() -> None:
    """A fine ball keeps its shape with a tenth of its triangles; what is small enough is left as it is."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 160)
    fine = turned([np.column_stack([np.cos(angles), np.sin(angles)])], around=320)
    coarse = thinned(fine, 10_000)
    assert len(fine.faces) > 100_000
    assert 4_000 < len(coarse.faces) <= 10_000
    assert np.linalg.norm(coarse.vertices, axis=1) == pytest.approx(1.0, abs=0.02)
    a, b, c = (coarse.vertices[coarse.faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(4 / 3 * np.pi, rel=0.02)
    assert thinned(coarse) is coarse
