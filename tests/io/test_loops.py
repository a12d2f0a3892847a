"""A four-bar linkage: three bars in a URDF, the fourth joint from Python or from a side file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sarrus as sr

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
