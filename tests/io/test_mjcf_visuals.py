"""Visuals of MJCF bodies have the sizes and poses of MuJoCo's shapes, which have half lengths and centred meshes."""

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.views.meshes.read import given_meshes

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")

SHAPES = {
    "box": 'type="box" size="0.1 0.2 0.3"',
    "sphere": 'type="sphere" size="0.1"',
    "capsule": 'type="capsule" size="0.1 0.3"',
    "cylinder": 'type="cylinder" size="0.1 0.3"',
    "ellipsoid": 'type="ellipsoid" size="0.1 0.2 0.3"',
    "mesh": 'type="mesh" mesh="m"',
}
MESH = "v 0 0 0\nv 300 0 0\nv 0 200 0\nv 0 0 400\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
FILE = """<mujoco><compiler meshdir="meshes"/><asset><mesh name="m" file="one.obj" scale="1e-3 2e-3 1e-3"/></asset>
<worldbody><body><joint/><geom {} pos="1 2 3" euler="10 20 30"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_is_drawn_as_large_as_in_mujoco(name: str, tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "one.obj").write_text(MESH)
    path = tmp_path / "model.xml"
    path.write_text(FILE.format(SHAPES[name]))
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    (look,) = sr.load_mjcf(path).looks()
    (drawn,) = given_meshes(look)
    points = (drawn.mesh.vertices - data.geom_xpos[0]) @ data.geom_xmat[0].reshape(3, 3)
    center, half = model.geom_aabb[0, :3], model.geom_aabb[0, 3:]
    np.testing.assert_allclose(points.max(axis=0), center + half, atol=2e-3)  # round ones have flat faces
    np.testing.assert_allclose(points.min(axis=0), center - half, atol=2e-3)
    if name == "mesh":
        expected = np.unique(model.mesh_vert.round(6), axis=0)
        np.testing.assert_allclose(np.unique(points.round(6), axis=0), expected, atol=2e-6)
