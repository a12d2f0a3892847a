"""Mesh files from elsewhere: they read nothing outside of their folder, and are refused in time."""

from __future__ import annotations

import base64
import json
import os
import struct
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.patience import within
from tests.views.test_meshes import binary_stl

import sarrus as sr
from sarrus.views.looks import sketch
from sarrus.views.meshes import MeshError, read_mesh

SECONDS = 5.0  # of processor time


def gltf(path: Path, **changes: Any) -> Path:
    """A triangle whose numbers are in the file itself."""
    points = np.eye(3, dtype="<f4").tobytes()
    told: dict[str, Any] = {
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:;base64," + base64.b64encode(points).decode()}],
    }
    path.write_text(json.dumps(told | changes))
    return path


COLLADA = """<?xml version="1.0"?>{doctype}<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"
version="1.4.1"><asset/><library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="9">
0 0 0 1 0 0 0 1 {last}</float_array><technique_common><accessor source="#a" count="3" stride="3"><param name="X"
type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
</source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 1 {corner}</p></triangles></mesh></geometry></library_geometries>
<library_nodes>{library}</library_nodes><library_visual_scenes><visual_scene id="s">{scene}</visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
PLACED = '<node><instance_geometry url="#g"/></node>'


def dae(path: Path, scene: str = PLACED, library: str = "", **parts: str) -> Path:
    told = {"doctype": "", "last": "0", "corner": "2"} | parts
    path.write_text(COLLADA.format(scene=scene, library=library, **told))
    return path


def instances(*names: str) -> str:
    return "".join(f'<instance_node url="#{name}"/>' for name in names)


def refused(file: Path, why: str) -> None:
    with within(SECONDS), pytest.raises(MeshError, match=why):
        read_mesh(file)


def test_the_files_are_good_without_the_attack(tmp_path: Path) -> None:
    assert len(read_mesh(gltf(tmp_path / "a.gltf"))) == len(read_mesh(dae(tmp_path / "a.dae"))) == 1


@pytest.mark.parametrize(
    "uri", ["../../../../../../etc/passwd", "/etc/passwd", "..%2Fsecret.bin", "link.bin"]
)
def test_a_buffer_outside_of_the_folder_is_not_read(uri: str, tmp_path: Path) -> None:
    folder = tmp_path / "model"
    folder.mkdir()
    (tmp_path / "secret.bin").write_bytes(bytes(36))
    (folder / "link.bin").symlink_to(tmp_path / "secret.bin")
    refused(gltf(folder / "a.gltf", buffers=[{"byteLength": 36, "uri": uri}]), "outside of its folder")
    (folder / "a.bin").write_bytes(np.eye(3, dtype="<f4").tobytes())
    assert read_mesh(gltf(folder / "b.gltf", buffers=[{"byteLength": 36, "uri": "a.bin"}]))


def test_a_material_file_outside_of_the_folder_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("mtllib ../../etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    refused(tmp_path / "a.obj", "outside of its folder")


@pytest.mark.parametrize(
    "nodes",
    [
        [{"children": [0]}],
        [{"children": [0, 0, 0]}],
        [{"children": [1]}, {"children": [0], "mesh": 0}],
        [*({"children": [n + 1]} for n in range(500)), {"mesh": 0}],
        [*({"children": [n + 1] * 10} for n in range(9)), {"mesh": 0}],
    ],
)
def test_a_scene_that_contains_itself_or_explodes_ends(nodes: list[Any], tmp_path: Path) -> None:
    """A node of glTF has one place; one that has several is drawn once."""
    with within(SECONDS), suppress(MeshError):
        assert len(read_mesh(gltf(tmp_path / "a.gltf", nodes=nodes))) == 1


@pytest.mark.parametrize(
    ("scene", "library"),
    [
        ('<node id="n"><instance_node url="#n"/></node>', ""),
        (f'<node id="n">{instances("n", "n")}</node>', ""),
        ("<node>" * 500 + "</node>" * 500, ""),
        (
            f"<node>{instances('n0')}</node>",
            "".join(f'<node id="n{k}">{instances(*[f"n{k + 1}"] * 10)}</node>' for k in range(9))
            + '<node id="n9"><instance_geometry url="#g"/></node>',
        ),
    ],
)
def test_a_collada_scene_that_contains_itself_or_explodes_is_refused(
    scene: str, library: str, tmp_path: Path
) -> None:
    refused(dae(tmp_path / "a.dae", scene, library), "nested deeper|places more than 5000 nodes")


def test_entities_are_refused(tmp_path: Path) -> None:
    doctype = '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd"><!ENTITY y "0">]>'
    refused(dae(tmp_path / "a.dae", doctype=doctype, last="&y;"), "declares a document type")


@pytest.mark.parametrize(
    ("last", "corner"), [("nan", "2"), ("1e300", "2"), ("0", "7"), ("0", "-9"), ("0", "x")]
)
def test_corners_are_finite_and_exist(last: str, corner: str, tmp_path: Path) -> None:
    refused(dae(tmp_path / "a.dae", last=last, corner=corner), "is no mesh that can be read")


@pytest.mark.parametrize(
    "changes",
    [
        {"accessors": [{"bufferView": 0, "componentType": 5126, "count": 10**12, "type": "VEC3"}]},
        {"accessors": [{"bufferView": 0, "componentType": 5126, "count": -3, "type": "VEC3"}]},
        {"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "byteOffset": -8}]},
        {"bufferViews": [{"buffer": 0, "byteLength": 36, "byteStride": 0}], "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 10**9, "type": "VEC3"}]},
        {"nodes": [{"mesh": 0, "scale": [1e40, 1, 1]}]},
        {"nodes": [{"mesh": 0, "rotation": "turned"}]},
        {"nodes": 7},
        {"buffers": [{"byteLength": 36, "uri": 5}]},
        {"scene": "first"},
    ],
)  # fmt: skip
def test_wrong_numbers_of_a_gltf_are_refused(changes: dict[str, Any], tmp_path: Path) -> None:
    refused(gltf(tmp_path / "a.gltf", **changes), "is no mesh that can be read")


@pytest.mark.parametrize("counts", ["1000000000", "4", "-3 6", "2 2"])
def test_polygons_have_the_corners_that_the_file_lists(counts: str, tmp_path: Path) -> None:
    file = dae(tmp_path / "a.dae")
    polygons = file.read_text().replace("triangles>", "polylist>").replace("<triangles", "<polylist")
    file.write_text(polygons.replace("<p>", f"<vcount>{counts}</vcount><p>"))
    refused(file, "is no mesh that can be read")


def test_nesting_of_the_text_itself_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_text("[" * 100_000)
    refused(tmp_path / "a.gltf", "is no mesh that can be read")
    (tmp_path / "a.dae").write_text("<a>" * 100_000)
    refused(tmp_path / "a.dae", "is no mesh that can be read")


def test_large_and_special_files_are_refused(tmp_path: Path) -> None:
    with (tmp_path / "large.stl").open("wb") as stream:
        stream.truncate(65 * 2**20)
    refused(tmp_path / "large.stl", "larger than 64 MB")
    os.mkfifo(tmp_path / "pipe.obj")
    refused(tmp_path / "pipe.obj", "not a regular file")
    (tmp_path / "count.stl").write_bytes(bytes(80) + struct.pack("<I", 2**32 - 1))
    refused(tmp_path / "count.stl", "is no mesh that can be read")


BLOCK = "name: block\nbodies:\n  block:\n    mass: 1\n    inertia: [1, 1, 1]\n    shape: {{file: {}}}\n"


def test_a_model_file_names_meshes_of_its_folder_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, elsewhere = tmp_path / "model", tmp_path / "elsewhere"
    for place in (folder, elsewhere):
        place.mkdir()
        binary_stl(place / "box.stl")
    file = folder / "block.yaml"
    for name in (str(elsewhere / "box.stl"), "../elsewhere/box.stl", "a/../../elsewhere/box.stl"):
        file.write_text(BLOCK.format(name))
        with pytest.raises(
            sr.ModelError, match=r"block\.yaml:6: body \"block\".* outside of the model's folder"
        ):
            sr.load(file)
    file.write_text(BLOCK.format(elsewhere / "box.stl"))
    monkeypatch.setenv("SARRUS_MESH_PATH", str(elsewhere))
    assert sketch(sr.load(file)).parts
    file.write_text(BLOCK.format('""'))
    with pytest.raises(sr.ModelError, match="must name a mesh file"):
        sr.load(file)


ROBOT = """<robot name="arm"><link name="base"/><link name="tip"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="{}" {}/></geometry></visual></link>
<joint name="pin" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>"""


def robot(tmp_path: Path, name: str, more: str = "", folder: str = "arm") -> Any:
    file = tmp_path / folder / "arm.urdf"
    file.parent.mkdir(exist_ok=True)
    file.write_text(ROBOT.format(name, more))
    return sr.load_urdf(file)


def test_a_robot_names_meshes_of_its_package_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "meshes").mkdir()
    binary_stl(tmp_path / "meshes" / "box.stl")
    outside = f"file://{tmp_path / 'meshes' / 'box.stl'}"
    above = f"package://{tmp_path / 'meshes' / 'box.stl'}", "package://../meshes/box.stl"
    for name in (outside, "../meshes/box.stl", "package://arm/../meshes/box.stl", *above):
        (note,) = sketch(robot(tmp_path, name)).notes
        assert "outside of the model's folder" in note
    assert not sketch(robot(tmp_path, "../meshes/box.stl", folder="urdf")).notes
    assert not sketch(robot(tmp_path, "package://meshes/box.stl")).notes
    monkeypatch.setenv("SARRUS_MESH_PATH", str(tmp_path / "meshes"))
    assert not sketch(robot(tmp_path, outside)).notes


@pytest.mark.parametrize(
    ("name", "more", "why"), [("", "", "no filename"), ("a.stl", 'scale="2 1"', "scale must be 3")]
)
def test_a_wrong_visual_is_noted_and_left_out(name: str, more: str, why: str, tmp_path: Path) -> None:
    (note,) = [note for note in robot(tmp_path, name, more).notes if "visual" in note]
    assert note.startswith('a visual of link "tip" is left out, line 3')
    assert why in note
