"""Nothing of a URDF file is ignored in silence: each element and attribute is used, or a note says what is left out."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.io.urdf.load import ELSEWHERE, NOTED, USED

SPECIFICATION = Path(__file__).parent / "data" / "urdf-specification.txt"
ROBOT = """\
<robot name="arm" version="1.0">
  <material name="blue"><color rgba="0.1 0.2 0.9 1"/><texture filename="blue.png"/></material>
  <link name="base" type="plain"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.1 0.2 0.5" rpy="0.3 0.2 0.1"/>
      <mass value="2"/>
      <inertia ixx="0.3" ixy="0.01" ixz="0.02" iyy="0.4" iyz="0.03" izz="0.5"/>
    </inertial>
    <visual name="v"><origin xyz="0 0 1" rpy="0.1 0.2 0.3"/><geometry><box size="0.1 0.2 0.3"/></geometry>
      <material name="red"><color rgba="0.9 0.2 0.1 1"/><texture filename="red.png"/></material></visual>
    <visual><geometry><cylinder radius="0.1" length="0.4"/></geometry><material name="blue"/></visual>
    <visual><geometry><capsule radius="0.1" length="0.4"/></geometry></visual>
    <visual><geometry><sphere radius="0.1"/></geometry></visual>
    <visual><geometry><mesh filename="arm.stl" scale="-0.001 0.001 0.001"/></geometry></visual>
    <collision name="c"><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <link name="lower">
    <inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/>
    <parent link="base"/> <child link="upper"/>
    <axis xyz="0 0.6 0.8"/>
    <dynamics damping="0.5" friction="0.2"/>
    <limit lower="-1" upper="1" effort="9" velocity="3"/>
    <safety_controller soft_lower_limit="-0.9" soft_upper_limit="0.9" k_position="10" k_velocity="1"/>
    <calibration rising="0.1"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="upper"/> <child link="lower"/>
    <mimic joint="shoulder" multiplier="2" offset="0.1"/>
  </joint>
  <transmission name="t" type="transmission_interface/SimpleTransmission">
    <joint name="shoulder"/><actuator name="motor"><mechanicalReduction>50</mechanicalReduction></actuator>
  </transmission>
  <transmission name="d" type="transmission_interface/DifferentialTransmission"/>
  <gazebo reference="shoulder"><springStiffness>3</springStiffness><springReference>0.2</springReference></gazebo>
  <gazebo reference="lower"><turnGravityOff>true</turnGravityOff><mu1>0.2</mu1></gazebo>
  <gazebo><plugin name="control"/></gazebo>
  <sensor name="s"/>
  <novelty/>
</robot>
"""
TEXTS = {"robot": ["name"], "robot/link/visual/geometry/mesh": ["filename"]}  # that are copied
LABELS = {  # that name things, and no number depends on
    ("robot", "version"),
    ("robot/link", "type"),
    ("robot/link/visual", "name"),
    ("robot/joint/safety_controller", "k_position"),
    ("robot/joint/safety_controller", "k_velocity"),
}


def specified() -> dict[str, list[str]]:
    rows = (line.split(":") for line in SPECIFICATION.read_text().splitlines())
    return {path: names.split() for path, names in rows}


def loaded(folder: Path, text: str = ROBOT) -> sr.Robot:
    path = folder / "arm.urdf"
    path.write_text(text)
    return sr.load_urdf(path)


def contents(robot: sr.Robot) -> str:
    """Everything that the model has of its file."""
    system = sr.System(robot)
    numbers = np.concatenate([system.b, system.q0, *(look.pose.r for look in robot.looks())])
    looks = [(look.shape, *map(float, look.size), str(look.file), look.color) for look in robot.looks()]
    turns = [look.pose.p.tolist() for look in robot.looks()]
    parts = [(part.name, type(part)) for parts in robot.sections().values() for part in parts]
    return repr(
        (robot.name, numbers.tolist(), looks, turns, parts, robot.limits, robot.mimics, [*robot.links])
    )


def test_each_item_of_the_specification_is_used_or_noted() -> None:
    for path, names in specified().items():
        if path.split("/")[1:2] and path.split("/")[1] in ELSEWHERE:
            continue
        noted = any(path == one or path.startswith(f"{one}/") for one in NOTED)
        assert path in USED or noted, path
        assert noted or not {*names} - {*USED[path].split()}, path


NUMBERS = [
    (path, name)
    for path, names in USED.items()
    for name in names.split()
    if (path, name) not in LABELS and name not in ("name", "link", "type", "joint", "filename")
]


def elements(text: str, path: str) -> list[re.Match[str]]:
    """Return the elements with a path, as they are in the text."""
    tags, found = [], []
    for match in re.finditer(r"<(/?)([\w]+)([^>]*?)(/?)>", text):
        if match[1]:
            tags.pop()
            continue
        tags.append(match[2])
        if "/".join(tags) == path:
            found.append(match)
        if match[4]:
            tags.pop()
    return found


@pytest.mark.parametrize(("path", "name"), NUMBERS, ids=lambda word: word)
def test_each_number_that_is_used_is_in_the_model(path: str, name: str, tmp_path: Path) -> None:
    element = next(match for match in elements(ROBOT, path) if f' {name}="' in match[0])
    value = re.search(rf' {name}="([^"]*)"', element[0])
    assert value
    words = [f"{float(word) * 1.01 + 0.001:.6g}" for word in value[1].split()]
    at = element.start() + value.start(1)
    changed = ROBOT[:at] + " ".join(words) + ROBOT[at + len(value[1]) :]
    assert contents(loaded(tmp_path, changed)) != contents(loaded(tmp_path))


@pytest.mark.parametrize("word", ["springStiffness", "springReference", "mechanicalReduction"])
def test_texts_of_elements_are_in_the_model(word: str, tmp_path: Path) -> None:
    changed = re.sub(rf"(<{word}>)(.*?)<", r"\g<1>0.7<", ROBOT)
    assert contents(loaded(tmp_path, changed)) != contents(loaded(tmp_path))


NOTES = [
    "2 textures are left out",
    "1 collision shape is left out: there is no contact",
    "limits of 1 joint are stored",
    "soft limits of 1 joint are stored",
    "calibrations of 1 joint",
    "1 sensor is left out",
    "1 transmission is left out",
    "1 <mu1> of <gazebo> is left out: there is no contact",
    "1 <plugin> of <gazebo> is left out: what it does to the motion is not known",
    "1 element <novelty> is left out",
]


@pytest.mark.parametrize("note", NOTES)
def test_what_is_left_out_is_noted(note: str, tmp_path: Path) -> None:
    assert any(note in one for one in loaded(tmp_path).notes)


def test_unknown_attributes_are_noted(tmp_path: Path) -> None:
    robot = loaded(
        tmp_path, ROBOT.replace('<axis xyz="0 0.6 0.8"/>', '<axis xyz="0 0.6 0.8" frame="{world}"/>')
    )
    assert "the attribute frame of 1 element <axis> is left out: its meaning is not known" in robot.notes


def test_a_motor_acts_by_its_reduction(tmp_path: Path) -> None:
    """The torque of the motor, 0.1 Nm, is 5 Nm on the joint."""
    (tmp_path / "arm.urdf").write_text(ROBOT)
    still, driven = (
        sr.load_urdf(tmp_path / "arm.urdf", controls=controls, mimic="lock", ignore=["dynamics"])
        for controls in ({}, {"motor": 0.1})
    )
    forces = [sr.System(robot).Q(sr.System(robot).q0, np.zeros(7), 0.0) for robot in (still, driven)]
    space = sr.JointSpace(sr.System(driven))
    load = space.T(space.zero()).T @ (forces[1] - forces[0])
    assert load == pytest.approx([5.0])


def test_a_link_without_gravity_has_no_weight(tmp_path: Path) -> None:
    robot = loaded(tmp_path)
    (lift,) = (force for force in robot.forces if force.name == "lower_gravcomp")
    np.testing.assert_allclose(lift.force, [0, 0, 9.81])


def test_a_start_outside_of_limits_is_noted(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(ROBOT)
    robot = sr.load_urdf(tmp_path / "arm.urdf", q0={"shoulder": 1.5})
    assert any('"shoulder" starts at 1.5, outside of its limits -1 and 1' in note for note in robot.notes)


@pytest.mark.parametrize(
    ("kind", "limit", "ends"),
    [
        ("revolute", 'lower="-1"', (-1, 0)),
        ("revolute", 'upper="1"', (0, 1)),
        ("revolute", "", (-np.inf, np.inf)),
        ("continuous", 'lower="-1" upper="1"', (-np.inf, np.inf)),
    ],
)
def test_one_end_of_a_range_has_the_other_at_zero(
    kind: str, limit: str, ends: tuple[float, float], tmp_path: Path
) -> None:
    """The default of the format; a continuous joint has no range."""
    (tmp_path / "arm.urdf").write_text(
        '<robot name="r"><link name="base"/><link name="a"><inertial><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        f'<joint name="j" type="{kind}"><parent link="base"/><child link="a"/>'
        f'<limit {limit} effort="3" velocity="1"/></joint></robot>'
    )
    robot = sr.load_urdf(tmp_path / "arm.urdf")
    assert robot.limits["j"].range() == ends
    assert robot.limits["j"].effort == 3


def test_meshes_are_searched_in_folders_or_left_out(tmp_path: Path) -> None:
    (tmp_path / "robot").mkdir()
    (tmp_path / "meshes" / "parts").mkdir(parents=True)
    mesh = tmp_path / "meshes" / "parts" / "arm.stl"
    mesh.write_text("")
    path = tmp_path / "robot" / "arm.urdf"
    path.write_text(ROBOT.replace('"arm.stl"', '"package://parts/arm.stl"'))
    files = [look.file for look in sr.load_urdf(path, search=[tmp_path / "meshes"]).looks() if look.file]
    assert files == [mesh]
    assert not any(look.file for look in sr.load_urdf(path, meshes="ignore").looks())


@pytest.mark.parametrize(("kind", "motions"), [("planar", 3), ("floating", 1)])
def test_damping_of_planar_and_floating_joints(kind: str, motions: int, tmp_path: Path) -> None:
    """Each of the velocities is damped by the same number."""
    text = (
        f'<joint name="j" type="{kind}"><parent link="b"/><child link="a"/><dynamics damping="0.5"/></joint>'
    )
    inertial = '<mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    body = f'<link name="b"/><link name="a"><inertial>{inertial}</inertial></link>'
    system = sr.System(loaded(tmp_path, f'<robot name="r">{body}{text}</robot>'))
    space = sr.JointSpace(system)
    T, rates = space.T(space.zero()), np.arange(1.0, space.freedoms + 1)
    loads = T.T @ (system.Q(system.q0, T @ rates, 0.0) - system.Q(system.q0, 0 * (T @ rates), 0.0))
    np.testing.assert_allclose(loads, -0.5 * rates, atol=1e-12)


def test_the_same_file_has_the_same_contents(tmp_path: Path) -> None:
    assert contents(loaded(tmp_path)) == contents(loaded(tmp_path))
