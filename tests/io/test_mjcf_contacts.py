"""Contacts of MJCF planes with spheres, capsules, boxes and meshes, against MuJoCo's depth and forces at rest."""

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.needs("mujoco")
MUJOCO = tuple(int(word) for word in mujoco.__version__.split(".")[:2])

FILE = """<mujoco><option timestep="0.001"/><default><geom condim="1" solimp="0.95 0.95 0.001"/></default>
  <asset><mesh name="m" vertex="0 0 0  0.3 0 0  0 0.3 0  0 0 0.4  0.05 0.05 0.1"/></asset>
  <worldbody><geom name="floor" type="plane" size="5 5 1" {floor}/>{body}</worldbody>
  <contact>{contact}</contact></mujoco>"""
DOWN = '<body name="b" pos="0 0 1"><joint name="j" type="slide" axis="0 0 1"/>{}</body>'
SHAPES = {
    "sphere": ('<geom name="g" size="0.1"/>', 0.1, 1),
    "sphere beside": ('<geom name="g" size="0.1" pos="0.1 0.2 0.3"/>', -0.2, 1),
    "capsule": ('<geom name="g" type="capsule" size="0.1 0.3" euler="0 90 0"/>', 0.1, 2),
    "box": ('<geom name="g" type="box" size="0.1 0.2 0.3"/>', 0.3, 8),
}


def written(folder: Path, body: str, floor: str = "", contact: str = "") -> Path:
    path = folder / "model.xml"
    path.write_text(FILE.format(body=body, floor=floor, contact=contact))
    return path


def resting(path: Path, height: float) -> float:
    """How deep MuJoCo's body is at rest."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[0] = height - 1
    for _ in range(3000):
        mujoco.mj_step(model, data)
    assert abs(data.qvel[0]) < 1e-9
    return float(height - 1 - data.qpos[0])


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_rests_as_deep_as_in_mujoco(name: str, tmp_path: Path) -> None:
    geom, height, count = SHAPES[name]
    path = written(tmp_path, DOWN.format(geom))
    robot = sr.load_mjcf(path, q0={"j": height - 1 - 1e-4})
    assert len(robot.forces) == count
    rest = sr.equilibrium(sr.System(robot))
    assert rest.success, rest.message
    depth = height - 1 - rest["j.displacement"]
    expected = resting(path, height)
    assert depth == pytest.approx(expected, rel=1e-3 if expected > 5e-5 else 0.02)  # less is in the rounding
    assert depth > 3e-5


MARGINS = {
    "gap": 'gap="0.003"',
    "negative": 'margin="-0.003" gap="0.003"',
    "margin": 'margin="0.002" gap="0.001"',
}


@pytest.mark.skipif(MUJOCO < (3, 9), reason="margins and gaps of MuJoCo have had other meanings")
@pytest.mark.parametrize("given", MARGINS)
@pytest.mark.parametrize("name", ["sphere", "box"])
def test_margins_and_gaps_are_those_of_mujoco(name: str, given: str, tmp_path: Path) -> None:
    """Margins of both shapes add up, also to less than the radius of a corner; gaps are without force."""
    geom, height, _ = SHAPES[name]
    path = written(tmp_path, DOWN.format(geom.replace("<geom", f"<geom {MARGINS[given]}")), MARGINS[given])
    expected = resting(path, height)
    rest = sr.equilibrium(sr.System(sr.load_mjcf(path, q0={"j": height - 1 - expected - 1e-5})))
    assert rest.success, rest.message
    assert height - 1 - rest["j.displacement"] == pytest.approx(expected, abs=1e-7)


def test_a_shape_on_a_link_without_mass_rests_as_deep_as_in_mujoco(tmp_path: Path) -> None:
    pad = '<body name="pad" pos="0 0 -0.2"><geom name="g" size="0.1" mass="0"/></body>'
    path = written(tmp_path, DOWN.format(f'<geom size="0.05" contype="0" conaffinity="0" mass="2"/>{pad}'))
    expected = resting(path, 0.3)
    rest = sr.equilibrium(sr.System(sr.load_mjcf(path, q0={"j": 0.3 - 1 - 1e-4})))
    assert rest.success, rest.message
    assert 0.3 - 1 - rest["j.displacement"] == pytest.approx(expected, rel=1e-3)


def test_corners_of_a_mesh_are_those_of_its_hull(tmp_path: Path) -> None:
    path = written(tmp_path, DOWN.format('<geom name="g" type="mesh" mesh="m" euler="10 20 30"/>'))
    robot, model = sr.load_mjcf(path), mujoco.MjModel.from_xml_path(str(path))
    assert len(robot.forces) == 4  # the fifth vertex is inside
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    expected = data.geom_xpos[1] + model.mesh_vert[:4] @ data.geom_xmat[1].reshape(3, 3).T
    poses = {body.name: body.pose() for body in robot.bodies}
    found = np.array([one.center.resolve(poses, "center").s for one in robot.forces]) + (0, 0, 1)
    np.testing.assert_allclose(found[np.lexsort(found.T)], expected[np.lexsort(expected.T)], atol=1e-7)


@pytest.mark.parametrize("mu", [0.2, 2.0])
def test_a_box_on_a_slope_slides_or_sticks(mu: float, tmp_path: Path) -> None:
    """tan 20° = 0.36: with less friction it slides at g (sin 20° − mu cos 20°)."""
    given = f'type="box" size="0.3 0.3 0.1" condim="3" friction="{mu} 0 0"'
    box = f'<body name="b" pos="0 0 0.0998"><freejoint name="f"/><geom name="g" {given}/></body>'
    path = written(tmp_path, box, 'friction="0.1 0 0"')
    text = path.read_text().replace("<option", '<option gravity="3.355178 0 -9.218385"', 1)
    path.write_text(text)
    run = sr.simulate(sr.System(sr.load_mjcf(path)), until=1.0)
    assert run.success, run.message
    speed = max(9.81 * (np.sin(np.radians(20)) - mu * np.cos(np.radians(20))), 0.0)
    assert run["b.velocity.x"][-1] == pytest.approx(speed, abs=5e-3)


FILTERS = {
    "types": ('contype="2" conaffinity="2"', "", 0),
    "exclusion": ("", '<exclude body1="world" body2="b"/>', 0),
    "pair": ('contype="2" conaffinity="2"', '<pair geom1="g" geom2="floor" solref="0.04 1"/>', 1),
    "both": ("", '<pair geom1="g" geom2="floor" friction="0.5 0.5 0 0 0" condim="3"/>', 1),
}


@pytest.mark.parametrize("name", FILTERS)
def test_filters_and_pairs(name: str, tmp_path: Path) -> None:
    floor, contact, count = FILTERS[name]
    path = written(tmp_path, DOWN.format('<geom name="g" size="0.1"/>'), floor, contact)
    forces = sr.load_mjcf(path).forces
    assert len(forces) == count
    if name == "both":
        assert forces[0].mu == 0.5
    assert sr.load_mjcf(path, ignore=["contacts"]).forces == ()


@pytest.mark.parametrize("priority", [0, 1])
def test_numbers_of_two_shapes_are_mixed_as_in_mujoco(priority: int, tmp_path: Path) -> None:
    given = f'solref="0.03 1" solimp="0.8 0.9 0.001" solmix="3" friction="0.3 0 0" priority="{priority}"'
    geom = f'<geom name="g" size="0.1" condim="3" {given}/>'
    path = written(tmp_path, DOWN.format(geom), 'friction="0.7 0 0" solmix="1"')
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[0] = 0.1 - 1 - 1e-3
    mujoco.mj_forward(model, data)
    (contact,) = sr.load_mjcf(path).forces
    assert contact.mu == pytest.approx(data.contact[0].friction[0])
    time, limit = data.contact[0].solref[0], data.contact[0].solimp[1]
    mass = model.body_mass[1]
    assert contact.stiffness == pytest.approx(mass / (1 - limit) / time**2, rel=1e-6)


def test_overridden_friction_counts_where_the_shapes_have_none(tmp_path: Path) -> None:
    geom = '<geom name="g" size="0.1" condim="{}" friction="0 0 0"/>'
    override = '<option o_friction="0.6 0.5"><flag override="enable"/></option><option'
    for dimension, mu in ((3, 0.6), (1, 0.0)):
        path = written(tmp_path, DOWN.format(geom.format(dimension)), 'friction="0 0 0"')
        path.write_text(path.read_text().replace("<option", override, 1))
        robot = sr.load_mjcf(path)
        assert robot.forces[0].mu == mu
        assert any("two coefficients" in note for note in robot.notes) == (dimension == 3)
