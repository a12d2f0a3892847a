"""Loops beside a URDF as pairs of frames, and as links with marked names; far open at zero, they are closed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.io.robot.tree.closing import _Search, closed
from sarrus.io.urdf.load import describe
from sarrus.io.urdf.loops import with_frame_pairs

INERTIAL = """<inertial><origin xyz="0 0 0.5"/><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.02"/></inertial>"""
FAR = 2.6  # [rad] between the frames at zero: their equations of right angles lead to the overturned orientation


def _joint(name: str, parent: str, child: str, xyz: str, kind: str = "continuous", rpy: str = "0 0 0") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}" rpy="{rpy}"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="0 1 0"/></joint>'
    )


@pytest.fixture
def linkage(tmp_path: Path) -> Path:
    """A four-bar linkage in the plane xz with two cranks of 1 m, whose coupler is cut into halves of 1 m."""
    links = "".join(f'<link name="{name}">{INERTIAL}</link>' for name in ("a", "b", "c", "d"))
    ends = ("A", "B", "closing_e_1", "closing_e_1_z", "closing_e_2", "closing_e_2_z")
    joints = [
        _joint("left", "world", "a", "0 0 0"),
        _joint("half_a", "a", "b", "0 0 1"),
        _joint("right", "world", "c", "2 0 0"),
        _joint("half_c", "c", "d", "0 0 1"),
        _joint("A_frame", "b", "A", "0 0 1", "fixed"),
        _joint("B_frame", "d", "B", "0 0 1", "fixed", f"0 {FAR} 0"),
        _joint("e1", "b", "closing_e_1", "0 0 1", "fixed", "1.5707963267948966 0 0"),
        _joint("e1z", "closing_e_1", "closing_e_1_z", "0 0 0.1", "fixed"),
        _joint("e2", "d", "closing_e_2", "0 0 1", "fixed", "1.5707963267948966 0 0"),
        _joint("e2z", "closing_e_2", "closing_e_2_z", "0 0 0.1", "fixed"),
    ]
    names = "".join(f'<link name="{name}"/>' for name in ("world", *ends))
    path = tmp_path / "linkage.urdf"
    path.write_text(f'<robot name="linkage">{names}{links}{"".join(joints)}</robot>')
    return path


def _side(linkage: Path, text: str) -> Path:
    path = linkage.with_name("robot.yaml")
    path.write_text(text)
    return path


def _opening(robot: sr.Robot, first: str, second: str) -> tuple[float, float]:
    """The distance of two links in the assembled position, and the angle between their axes."""
    system = sr.System(robot)
    found = sr.assemble(system)
    assert found.success, found.message
    poses = [robot.link(name).place for name in (first, second)]
    bodies = [found.q[system.coordinates_of(robot.link(name).body.name)] for name in (first, second)]
    from sarrus.model.geometry.motion import compose, pose

    i, j = (compose(pose(q[:3], q[3:]), place) for q, place in zip(bodies, poses, strict=True))
    return float(np.linalg.norm(i.r - j.r)), float(np.linalg.norm(i.A - j.A))


def test_frames_of_a_rigid_pair_coincide_and_are_not_turned_over(linkage: Path) -> None:
    side = _side(linkage, "closed_loop: [[A, B]]\ntype: ['6d']\nname_mot: [left]\n")
    robot = sr.load_urdf(linkage, loops=side)
    distance, turned = _opening(robot, "A", "B")
    assert distance < 1e-11
    assert turned < 1e-11
    assert any("name_mot" in note for note in robot.notes)


def test_a_joint_means_the_frame_of_its_child(linkage: Path) -> None:
    side = _side(linkage, "closed_loop: [[A_frame, B_frame]]\ntype: ['3D']\n")
    robot = sr.load_urdf(linkage, loops=side)
    assert _opening(robot, "A", "B")[0] < 1e-11
    assert isinstance(robot.joints[-1], sr.Spherical)


def test_other_kinds_of_joints(linkage: Path) -> None:
    kinds = "joint_name: [half_a, half_c, left]\njoint_type: [SPHERICAL, UJOINT_YX, FIXED]\n"
    robot = sr.load_urdf(linkage, loops=_side(linkage, f"closed_loop: [[A, B]]\ntype: ['3d']\n{kinds}"))
    found = {joint.name: type(joint) for joint in robot.joints}
    assert found["half_a"] is sr.Spherical
    assert found["half_c"] is sr.Universal
    assert "left" not in found
    assert _opening(robot, "A", "B")[0] < 1e-11


def test_given_coordinates_are_kept(linkage: Path) -> None:
    side = _side(linkage, "closed_loop: [[A, B]]\ntype: ['3d']\n")
    robot = sr.load_urdf(linkage, loops=side, q0={"left": 0.4})
    tip = next(body for body in robot.bodies if body.name == "b").pose().r  # where the crank ends
    np.testing.assert_allclose(tip, [np.sin(0.4), 0, np.cos(0.4)], atol=1e-14)
    assert _opening(robot, "A", "B")[0] < 1e-11


def _limited(joint: str, limit: str) -> str:
    return joint.replace('"continuous"', '"revolute"').replace("</joint>", f"{limit}</joint>")


@pytest.mark.parametrize("sign", [1, -1])
def test_loops_are_closed_within_limits(linkage: Path, sign: int) -> None:
    """A crank and its half of the coupler bend to either side; the limit of a joint leaves one."""
    limit = f'<limit lower="{min(0, sign * 3)}" upper="{max(0, sign * 3)}" effort="1" velocity="1"/>'
    free = _joint("half_c", "c", "d", "0 0 1")
    linkage.write_text(linkage.read_text().replace(free, _limited(free, limit)))
    side = _side(linkage, "closed_loop: [[A, B]]\ntype: ['3d']\n")
    description, _ = with_frame_pairs(describe(linkage, (0, 0, -9.81)), side)
    found = closed(description, {"left": np.array([0.4])}, {"left"})
    assert 0 < sign * found["half_c"][0] < 3
    assert sr.assemble(sr.System(sr.load_urdf(linkage, loops=side, q0={"left": 0.4}))).success


def test_limits_that_no_closed_position_meets_are_exceeded(linkage: Path) -> None:
    limit = '<limit lower="-0.1" upper="0.1" effort="1" velocity="1"/>'
    for name, *rest in (("half_a", "a", "b", "0 0 1"), ("half_c", "c", "d", "0 0 1")):
        free = _joint(name, *rest)
        linkage.write_text(linkage.read_text().replace(free, _limited(free, limit)))
    side = _side(linkage, "closed_loop: [[A, B]]\ntype: ['3d']\n")
    robot = sr.load_urdf(linkage, loops=side, q0={"left": -0.8})
    assert _opening(robot, "A", "B")[0] < 1e-11
    assert any("outside of its limits" in note for note in robot.notes)


def test_trees_without_loops_are_not_searched(linkage: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    description = replace(describe(linkage, (0, 0, -9.81)), loops=())
    monkeypatch.setattr("sarrus.io.robot.tree.closing._Search", None)
    assert closed(description, {"left": np.ones(1)}, ()) == {"left": 1}


def test_links_with_marked_names_are_a_revolute_joint(linkage: Path) -> None:
    robot = sr.load_urdf(linkage)
    assert [type(joint) for joint in robot.joints if joint.name == "closing_e"] == [sr.Revolute]
    assert _opening(robot, "closing_e_1", "closing_e_2")[0] < 1e-11
    side = _side(linkage, "closed_loop: [[A, B]]\ntype: ['3d']\n")
    robot = sr.load_urdf(linkage, loops=side)
    assert "closing_e" not in {joint.name for joint in robot.joints}
    assert any('links mark, "closing_e": left out' in note for note in robot.notes)


@pytest.mark.parametrize("text", ["forces: {}\n", "joints: {}\n", "closed_loop:\n"])
def test_marked_loops_remain_with_a_file_without_loops(linkage: Path, text: str) -> None:
    robot = sr.load_urdf(linkage, loops=_side(linkage, text))
    assert "closing_e" in {joint.name for joint in robot.joints}
    assert not any("links mark" in note for note in robot.notes)


def test_a_marked_loop_without_an_axis_is_noted(linkage: Path) -> None:
    linkage.write_text(linkage.read_text().replace("_z", "_q"))
    with pytest.warns(sr.SarrusWarning, match="left open"):
        robot = sr.load_urdf(linkage)
    assert "closing_e" not in {joint.name for joint in robot.joints}
    assert any('"closing_e_1" and "closing_e_2", left open' in note for note in robot.notes)


END = "{{body: closing_e_{}, at: [0, 0, 0]}}"
JOINT = f"joints:\n  e:\n    type: spherical\n    points: [{END.format(1)}, {END.format(2)}]\n"


@pytest.mark.parametrize("text", ["closed_loop: [[closing_e_1, closing_e_2]]\ntype: ['3d']\n", JOINT])
def test_a_marked_loop_that_a_file_closes_is_not_noted(linkage: Path, text: str) -> None:
    linkage.write_text(linkage.read_text().replace("_z", "_q"))
    robot = sr.load_urdf(linkage, loops=_side(linkage, text))
    assert not any("left open" in note for note in robot.notes)
    between_others = text.replace("closing_e_2", "c")
    with pytest.warns(sr.SarrusWarning, match="left open"):
        robot = sr.load_urdf(linkage, loops=_side(linkage, between_others))
    assert any("left open" in note for note in robot.notes)


def test_what_joints_of_another_kind_had_is_left_out_with_a_note(linkage: Path) -> None:
    more = '<dynamics damping="0.5"/><limit lower="-3" upper="3" effort="1" velocity="1"/>'
    urdf = linkage.read_text().replace('<axis xyz="0 1 0"/>', f'<axis xyz="0 1 0"/>{more}')
    urdf = urdf.replace('<child link="c"/>', '<child link="c"/><mimic joint="left"/>')
    motor = '<transmission name="t"><joint name="half_c"/><actuator name="motor"/></transmission>'
    linkage.write_text(urdf.replace("</robot>", f"{motor}</robot>"))
    kinds = "joint_name: [half_a, half_c, left]\njoint_type: [SPHERICAL, UJOINT_YX, FIXED]\n"
    robot = sr.load_urdf(linkage, loops=_side(linkage, f"closed_loop: [[A, B]]\ntype: ['3d']\n{kinds}"))
    notes = [note.split(": left out")[0] for note in robot.notes if "joint_type" in note]
    assert notes == [
        'dynamics of "left", "half_c"',
        'limits of "left", "half_a", "half_c"',
        'mimics of "right"',
        'actuators of "motor"',
    ]
    assert set(robot.limits) == {"right"}
    assert {force.name for force in robot.forces} == {"right_spring", "half_a_spring"}
    assert not robot.mimics


def test_the_jacobian_of_the_openings(linkage: Path) -> None:
    kinds = "joint_name: [half_a]\njoint_type: [SPHERICAL]\n"
    side = _side(linkage, f"closed_loop: [[A, B]]\ntype: ['6d']\n{kinds}")
    description, _ = with_frame_pairs(describe(linkage, (0, 0, -9.81)), side)
    search = _Search(description, {}, ())
    theta = search.start + 0.3 * np.random.default_rng(1).normal(size=len(search.start))
    h, columns = 1e-6, np.eye(len(theta))
    differences = [
        (search.openings(theta + h * e) - search.openings(theta - h * e)) / (2 * h) for e in columns
    ]
    np.testing.assert_allclose(search.jacobian(theta), np.array(differences).T, atol=1e-8)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("closed_loop: [[A, C]]\ntype: ['6d']", 'closed_loop: has "C", which the robot does not have'),
        (
            "closed_loop: [[A]]\ntype: ['6d']",
            "closed_loop: has a list. Give the names of two links or joints",
        ),
        ("closed_loop: [[A, B]]\ntype: ['5d']", 'type: has "5d". Choose from 3d, 6d'),
        ("closed_loop: [[A, B]]\ntype: []", "type: must have one value for each of the 1 in closed_loop"),
        ("closed_loop: [[A, B]]\ntype: 6d", 'type: must be a list, got "6d"'),
        ("closed_loop: [[A, B]]\ntipe: ['6d']", 'tipe: is no key of frame pairs. Did you mean "type"?'),
        (
            "closed_loop: [[A, B]]\ntype: ['6d']\njoint_name: [left]\njoint_type: [UJOINT_YW]",
            'joint_type: has "UJOINT_YW". Choose from SPHERICAL, FIXED',
        ),
        (
            "closed_loop: [[A, B]]\ntype: ['6d']\njoint_name: [left]\njoint_type: [UJOINT_YY]",
            'joint_type: has "UJOINT_YY". Choose from SPHERICAL, FIXED',
        ),
        ("closed_loop: [[[A], B]]\ntype: ['6d']", "closed_loop: has a list, which the robot does not have"),
        (
            "closed_loop: [[A, B]]\ntype: ['6d']\njoint_name: [[left]]\njoint_type: [FIXED]",
            "joint_name: has a list, which the robot does not have",
        ),
    ],
)
def test_wrong_files_are_refused(linkage: Path, text: str, message: str) -> None:
    with pytest.raises(sr.ModelError) as refused:
        sr.load_urdf(linkage, loops=_side(linkage, text))
    assert message in str(refused.value)
    assert "robot.yaml:" in str(refused.value)
