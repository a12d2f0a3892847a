"""A four-bar linkage: three bars in a URDF, the fourth joint from Python or from a side file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.cli import main

BAR = """<inertial><origin xyz="{half} 0 0" rpy="0 0 0"/><mass value="1"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>"""
LOOP = """\
joints:
  closing:
    type: revolute
    frames:
      - {body: tip, at: [0, 0, 0], z: [0, 0, 1]}
      - {body: rocker, at: [2, 0, 0], z: [0, 0, 1]}
forces:
  push:
    type: point_force
    point: {body: tip, at: [0, 0, 0]}
    force: [1, 0, 0]
"""
Q0 = {"pin_a": np.pi / 2, "pin_b": -np.pi / 2, "pin_c": np.pi / 2}


@pytest.fixture
def linkage(tmp_path: Path) -> Path:
    """A parallelogram: crank 2 m up from (0, 0), rocker 2 m up from (3, 0), coupler 3 m with a link `tip`."""
    z = '<axis xyz="0 0 1"/>'
    bars = {"crank": 1.0, "coupler": 1.5, "rocker": 1.0}
    links = "".join(f'<link name="{name}">{BAR.format(half=half)}</link>' for name, half in bars.items())
    joints = [
        f'<joint name="pin_a" type="continuous"><parent link="world"/><child link="crank"/>{z}</joint>',
        '<joint name="pin_b" type="continuous"><origin xyz="2 0 0" rpy="0 0 0"/>'
        f'<parent link="crank"/><child link="coupler"/>{z}</joint>',
        '<joint name="pin_c" type="continuous"><origin xyz="3 0 0" rpy="0 0 0"/>'
        f'<parent link="world"/><child link="rocker"/>{z}</joint>',
        '<joint name="end" type="fixed"><origin xyz="3 0 0" rpy="0 0 1"/>'
        '<parent link="coupler"/><child link="tip"/></joint>',
    ]
    path = tmp_path / "four_bar.urdf"
    path.write_text(
        f'<robot name="four-bar"><link name="world"/><link name="tip"/>{links}{"".join(joints)}</robot>'
    )
    (tmp_path / "loop.yaml").write_text(LOOP)
    return path


def test_a_loop_closed_in_python(linkage: Path) -> None:
    robot = sr.load_urdf(linkage, q0=Q0)
    end_i, end_j = robot.point("tip"), robot.point("rocker", (2, 0, 0))
    system = sr.System(robot.adding(sr.Spherical("closing", point_i=end_i, point_j=end_j)))
    assert abs(system.Phi(system.q0)).max() < 1e-15
    _check_loop(system)


def test_a_loop_closed_by_a_side_file(linkage: Path) -> None:
    robot = sr.load_urdf(linkage, q0=Q0, loops=linkage.with_name("loop.yaml"))
    assert [joint.name for joint in robot.joints] == ["pin_a", "pin_b", "pin_c", "closing"]
    assert [force.name for force in robot.forces] == ["push"]
    system = sr.System(robot)
    assert abs(system.Phi(system.q0)).max() < 1e-15
    _check_loop(system)


def test_the_tree_keeps_its_joint_space(linkage: Path) -> None:
    open_, closed = (
        sr.JointSpace(sr.System(sr.load_urdf(linkage, q0=Q0, loops=loops)))
        for loops in (None, linkage.with_name("loop.yaml"))
    )
    theta = open_.pack(Q0)
    np.testing.assert_array_equal(open_.M(theta), closed.M(theta))


def _check_loop(system: sr.System) -> None:
    """One freedom, and the velocity of the parallelogram: all bars but the coupler turn alike."""
    Phi_q = system.Phi_q(system.q0).toarray()
    _, singular, directions = np.linalg.svd(Phi_q)
    assert np.sum(singular > 1e-9) == system.nq - 1
    rates = directions[-1]
    spin = {
        body: rates[system.coordinates_of(body)][6] / system.q0[system.coordinates_of(body)][3]
        for body in system.bodies
    }
    assert spin["crank"] == pytest.approx(spin["rocker"])
    assert spin["coupler"] == pytest.approx(0, abs=1e-12)


WRONG = {
    "unknown link": ("body: tip, at: [0, 0, 0], z", "body: tipp, at: [0, 0, 0], z", 5, 'Did you mean "tip"'),
    "taken": ("closing:", "pin_a:", 2, "is taken"),
    "same body": ("body: rocker", "body: coupler", 6, "to itself"),
    "other section": ("forces:", "bodies:", 7, "no key"),
    "misspelt type": ("revolute", "revolut", 3, "Did you mean"),
    "no mapping": (LOOP, "- 1", 1, "mapping"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_side_file_is_refused(name: str, linkage: Path) -> None:
    old, new, line, words = WRONG[name]
    loops = linkage.with_name("loop.yaml")
    loops.write_text(LOOP.replace(old, new, 1))
    with pytest.raises(sr.ModelError) as error:
        sr.load_urdf(linkage, loops=loops)
    told = str(error.value)
    assert words in told
    assert "\n" not in told
    assert told.startswith(f"{loops}:{line}: "), told


LINK = """<link name="{}"><inertial><origin xyz="{}"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{}" type="continuous"><origin xyz="{}"/><parent link="{}"/><child link="{}"/>
<axis xyz="0 0 1"/></joint>"""
PARALLELOGRAM = "".join(
    [
        '<robot name="bars"><link name="world"/>',
        *(LINK.format(*one) for one in (("ab", "0 -0.15 0"), ("be", "0.1 0 0"), ("cd", "0 -0.15 0"))),
        JOINT.format("A", "0 0 0", "world", "ab") + JOINT.format("B", "0 -0.3 0", "ab", "be"),
        JOINT.format("D", "0.2 0 0", "world", "cd"),
        """<gazebo><joint name="C" type="revolute"><pose>0 -0.3 0 0 1.5707963267948966 0</pose><parent>be</parent>
<child>cd</child><axis><xyz>-1 0 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint></gazebo>
<gazebo><plugin name="p"/></gazebo></robot>""",
    ]
)


def test_joints_for_gazebo_close_loops(tmp_path: Path) -> None:
    """A parallelogram with the acceleration of a pendulum, in closed form; the joint's axis is in its own frame."""
    file = tmp_path / "bars.urdf"
    file.write_text(PARALLELOGRAM)
    robot = sr.load_urdf(file, q0={"A": 0.5}, gravity=(0, -9.81, 0))
    system = sr.System(robot)
    assert sr.mobility(system, sr.assemble(system).q).degrees_of_freedom == 1
    run = sr.simulate(system, until=1e-3)
    inertia, moment = 2 * (0.01 + 0.15**2) + 0.3**2, 9.81 * (2 * 0.15 + 0.3)
    assert run["A.angle"][0] == pytest.approx(0.5, abs=1e-12)
    assert run["A.angle.acceleration"][0] == pytest.approx(-moment * np.sin(0.5) / inertia, rel=1e-9)
    assert np.ptp(run["C.angle"] - run["D.angle"]) < 1e-9
    assert robot.notes == ("1 <plugin> of <gazebo> is left out: what it does to the motion is not known",)
    file.write_text(PARALLELOGRAM.replace("<parent>be</parent>", "<parent>bee</parent>"))
    with pytest.raises(
        sr.ModelError, match=r'joint "C": there is no link or frame "bee"\. Did you mean "be"'
    ):
        sr.load_urdf(file)
    file.write_text(PARALLELOGRAM.replace('joint name="C"', 'joint name="A"', 1))
    with pytest.raises(sr.ModelError, match=r'joint "A": has the name of another joint'):
        sr.load_urdf(file)


def test_notes_of_an_import_reach_the_shell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "bars.urdf"
    file.write_text(PARALLELOGRAM)
    note = "1 <plugin> of <gazebo> is left out"
    assert main(["convert", str(file), str(tmp_path / "a.yaml")]) == 0
    assert note in capsys.readouterr().err
    assert main(["convert", str(file), str(tmp_path / "a.yaml"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["notes"] == [f"{note}: what it does to the motion is not known"]
    assert not any("left" in warning for warning in found["warnings"])
    marked = '<link name="closing_c_{0}"/>' + JOINT.format("m{0}", "0 0 0", "{1}", "closing_c_{0}").replace(
        "continuous", "fixed"
    )
    file.write_text(
        PARALLELOGRAM.replace("</robot>", marked.format(1, "ab") + marked.format(2, "cd") + "</robot>")
    )
    assert main(["convert", str(file), str(tmp_path / "a.yaml"), "--json"]) == 0
    shown = capsys.readouterr()
    assert "left open" in shown.err
    assert any("left open" in warning for warning in json.loads(shown.out)["warnings"])
