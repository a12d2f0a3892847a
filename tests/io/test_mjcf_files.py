"""MJCF in several files, with defaults, classes and missing meshes."""

from pathlib import Path

import pytest
from tests.io.beside_mujoco import compare, compare_accelerations

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

INERTIAL = '<inertial pos="0.1 0 0" mass="{}" diaginertia="1 2 2"/>'
PART = """<mujocoinclude><body name="p" pos="0 0 1" childclass="stiff"><joint name="k"/>{more}</body></mujocoinclude>"""
FILE = """<mujoco><compiler meshdir="meshes"/>
  <default><joint damping="0.3"/>
    <default class="stiff"><joint stiffness="20" axis="0 1 0" armature="0.1"/></default></default>
  <asset>{assets}</asset><worldbody><body name="b"><joint name="j" axis="1 0 0"/>{more}<include file="part.xml"/></body>
  </worldbody></mujoco>
"""
MESH = '<mesh name="m" file="gone.stl"/>'
SHAPE = '<geom type="mesh" mesh="m"/>'


def written(folder: Path, assets: str, first: str, second: str) -> Path:
    (folder / "part.xml").write_text(PART.format(more=second))
    path = folder / "model.xml"
    path.write_text(FILE.format(assets=assets, more=first))
    return path


def test_includes_and_defaults(tmp_path: Path) -> None:
    path = written(tmp_path, "", INERTIAL.format(2), INERTIAL.format(3))
    compare(path)
    compare_accelerations(path)
    names = [force.name for force in sr.load_mjcf(path).forces]
    assert names == ["j_spring", "k_spring", "k_inertia"]


def test_missing_meshes_do_not_matter_where_inertials_are_given(tmp_path: Path) -> None:
    with_meshes = written(tmp_path, MESH, INERTIAL.format(2) + SHAPE, INERTIAL.format(3) + SHAPE)
    robot = sr.load_mjcf(with_meshes)
    assert [body.mass for body in robot.bodies] == [2, 3]
    assert any("1 mesh whose file is missing: it is neither" in note for note in robot.notes)


def test_a_missing_mesh_with_the_mass_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, MESH, INERTIAL.format(2), SHAPE)
    with pytest.raises(sr.ModelError, match=r"cannot be read by MuJoCo.*gone\.stl"):
        sr.load_mjcf(path)


def test_meshes_are_searched_in_other_folders(tmp_path: Path) -> None:
    """A tetrahedron of 1/6 m³ with MuJoCo's density, 1000 kg/m³."""
    path = written(tmp_path, MESH.replace(".stl", ".obj"), INERTIAL.format(2), SHAPE)
    (tmp_path / "elsewhere").mkdir()
    corners, faces = ("0 0 0", "1 0 0", "0 1 0", "0 0 1"), ("1 3 2", "1 2 4", "1 4 3", "2 3 4")
    lines = [*(f"v {corner}" for corner in corners), *(f"f {face}" for face in faces)]
    (tmp_path / "elsewhere" / "gone.obj").write_text("\n".join(lines))
    robot = sr.load(path, search=[tmp_path / "elsewhere"])
    assert [body.mass for body in robot.bodies] == pytest.approx([2, 1000 / 6])
    assert not any("missing" in note for note in robot.notes)
