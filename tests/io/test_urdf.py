"""URDF, kind by kind: what each joint leaves free, what is merged, and how links are addressed."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from tests.io.poses import link_poses

import sarrus as sr

INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
FREEDOMS = {"fixed": 0, "revolute": 1, "continuous": 1, "prismatic": 1, "planar": 3, "floating": 6}


def robot(tmp_path: Path, body: str, **wishes: object) -> sr.Robot:
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="robot"><link name="world"/>{body}</robot>')
    return sr.load_urdf(path, **wishes)  # type: ignore[arg-type]


def link(name: str, inside: str = INERTIAL) -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(name: str, kind: str, parent: str, child: str, inside: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


@pytest.mark.parametrize("kind", FREEDOMS)
def test_a_joint_leaves_its_freedoms(kind: str, tmp_path: Path) -> None:
    inside = '<origin xyz="1 2 3" rpy="0.3 -0.4 0.5"/><axis xyz="1 2 2"/>'
    told = (
        link("a")
        + joint("first", "revolute", "world", "a")
        + link("b")
        + joint("second", kind, "a", "b", inside)
    )
    system = sr.System(robot(tmp_path, told, keep_fixed=True))
    space = sr.JointSpace(system)
    theta = space.zero() + np.random.default_rng(2).uniform(-1, 1, space.width)
    q = space.q(theta)
    assert space.freedoms == system.nq - system.m == 1 + FREEDOMS[kind]
    assert np.linalg.matrix_rank(system.Phi_q(q).toarray()) == system.m
    assert abs(system.Phi(q)).max() < 1e-14
    assert abs(system.Phi_q(q) @ space.T(theta)).max() < 1e-14
    assert np.linalg.matrix_rank(space.T(theta)) == space.freedoms


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "planar", "floating"])
def test_the_tangent_map_is_the_derivative(kind: str, tmp_path: Path) -> None:
    inside = '<origin xyz="1 2 3" rpy="0.3 -0.4 0.5"/><axis xyz="1 2 2"/>'
    told = (
        link("a")
        + joint("first", "revolute", "world", "a")
        + link("b")
        + joint("second", kind, "a", "b", inside)
    )
    space = sr.JointSpace(sr.System(robot(tmp_path, told)))
    theta = space.pack({"first": 0.4})
    h = 1e-6
    for column, step in enumerate(_steps(space, h)):
        change = (space.q(theta + step) - space.q(theta - step)) / (2 * h)
        np.testing.assert_allclose(space.T(theta)[:, column], change, atol=1e-9)


def _steps(space: sr.JointSpace, h: float) -> list[np.ndarray]:
    """Coordinate steps that are one unit of each velocity, at zero: ω is twice the rate of e there."""
    steps = []
    for motion in space.motions:
        at = space.coordinates_of[motion.name].start
        places = (
            [(at, 1.0)]
            if motion.width == 1
            else [(at + n, 1.0) for n in range(3)] + [(at + 4 + n, 0.5) for n in range(3)]
        )
        steps += [h * scale * np.eye(space.width)[place] for place, scale in places]
    return steps


def test_rpy_is_about_fixed_axes(tmp_path: Path) -> None:
    inside = '<origin xyz="0 0 0" rpy="0.3 -0.4 0.5"/>'
    found = robot(tmp_path, link("a") + joint("j", "revolute", "world", "a", inside))
    cx, sx, cy, sy, cz, sz = (f(a) for a in (0.3, -0.4, 0.5) for f in (np.cos, np.sin))
    x, y = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]]), np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    np.testing.assert_allclose(found.bodies[0].pose().A, z @ y @ x, atol=1e-15)


def test_fixed_links_are_merged_with_their_inertia(tmp_path: Path) -> None:
    offset = '<origin xyz="0 0 2" rpy="0 0 1.5707963267948966"/>'
    heavy = '<inertial><mass value="3"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/></inertial>'
    told = (
        link("a")
        + joint("j", "revolute", "world", "a")
        + link("b", heavy)
        + joint("weld", "fixed", "a", "b", offset)
    )
    found = robot(tmp_path, told)
    (body,) = found.bodies
    assert body.mass == 4
    np.testing.assert_allclose(body.center_of_mass, [0, 0, 1.5])
    np.testing.assert_allclose(body.inertia, np.diag([1 + 2 + 3, 1 + 1 + 3, 3]), atol=1e-15)


def test_points_and_frames_of_a_merged_link_are_said_in_its_axes(tmp_path: Path) -> None:
    offset = '<origin xyz="0 0 2" rpy="0 0 1.5707963267948966"/>'
    tool = joint("weld", "fixed", "a", "tool", offset)
    found = robot(tmp_path, link("a") + joint("j", "revolute", "world", "a") + link("tool", "") + tool)
    poses = {body.name: body.pose() for body in found.bodies}
    np.testing.assert_allclose(found.point("tool", (1, 0, 0)).resolve(poses, "p").s, [0, 1, 2], atol=1e-15)
    frame = found.frame("tool").resolve(poses, "f")
    np.testing.assert_allclose([frame.f, frame.g, frame.h], [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-15)
    turned = found.link("tool").frame((0, 0, 1), z=(1, 0, 0)).resolve(poses, "f")
    np.testing.assert_allclose([turned.s, turned.h], [[0, 0, 3], [0, 1, 0]], atol=1e-15)
    with pytest.raises(sr.ModelError, match='Did you mean "tool"'):
        found.link("tol")


def test_any_name_becomes_a_legal_one(tmp_path: Path) -> None:
    told = link("1/arm") + joint("1/arm", "revolute", "world", "1/arm") + link("ground")
    found = robot(tmp_path, told + joint("j", "revolute", "1/arm", "ground"))
    assert [body.name for body in found.bodies] == ["_1_arm", "ground_link"]
    assert [one.name for one in found.joints] == ["_1_arm_joint", "j"]
    assert found.link("1/arm").body.name == "_1_arm"
    assert sr.JointSpace(sr.System(found)).freedoms == 2


def test_a_locked_joint_is_fixed_where_it_starts(tmp_path: Path) -> None:
    told = (
        link("a") + joint("j", "revolute", "world", "a") + link("b", "") + joint("k", "prismatic", "a", "b")
    )
    found = robot(tmp_path, told, lock=["k"], q0={"k": 0.25})
    assert len(found.bodies) == 1
    np.testing.assert_allclose(found.point("b").coordinates, [0.25, 0, 0])


def test_gravity_is_a_wish(tmp_path: Path) -> None:
    assert tuple(robot(tmp_path, link("a") + joint("j", "revolute", "world", "a")).gravity) == (0, 0, -9.81)


def test_a_planar_joint_slides_and_turns(tmp_path: Path) -> None:
    found = robot(tmp_path, link("a") + joint("j", "planar", "world", "a", '<axis xyz="0 0 1"/>'))
    space = sr.JointSpace(sr.System(found))
    place = link_poses(found, space, space.pack({"j.x": 1.0, "j.y": 2.0, "j.angle": np.pi / 2}))["a"]
    np.testing.assert_allclose(place.r, [1, 2, 0], atol=1e-15)
    np.testing.assert_allclose(place.A[:, 0], [0, 1, 0], atol=1e-15)


def test_hinges_through_links_without_mass_are_one_joint(tmp_path: Path) -> None:
    x, y, z = (f'<axis xyz="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    told = link("a", "") + joint(
        "roll", "revolute", "world", "a", x + '<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>'
    )
    told += link("b", "") + joint("pitch", "revolute", "a", "b", y + '<origin xyz="0 0 0" rpy="0 0 0.5"/>')
    told += link("c") + joint("yaw", "revolute", "b", "c", z + '<origin xyz="0 0 0" rpy="0.5 0 0"/>')
    found = robot(tmp_path, told)
    assert [type(one).__name__ for one in found.joints] == ["Spherical"]
    space = sr.JointSpace(sr.System(found))
    theta = space.pack({"roll": 0.3, "pitch": -0.4, "yaw": 0.5})
    assert space.freedoms == space.system.nq - space.system.m == 3
    assert abs(space.system.Phi_q(space.q(theta)) @ space.T(theta)).max() < 1e-14
    with pytest.raises(sr.ModelError, match="no link"):
        found.link("b")


@pytest.mark.filterwarnings("ignore:.*reaches 1 m from the centre of mass")  # a comparison with a tiny mass
def test_hinges_through_links_without_mass_that_do_not_meet(tmp_path: Path) -> None:
    """A massless frame between them moves as a link of a millionth of a gram does."""

    def mass_matrix(mass: str) -> np.ndarray:
        parts = link("a", mass) + joint("roll", "revolute", "world", "a") + link("b")
        parts += joint("pitch", "revolute", "a", "b", '<origin xyz="0 1 0"/><axis xyz="0 0 1"/>')
        system = sr.System(robot(tmp_path, parts))
        assert sr.mobility(system).degrees_of_freedom == 2
        space = sr.JointSpace(system)
        return space.M(space.pack({"roll": 0.3, "pitch": 0.5}))

    light = re.sub(r'="1"', '="1e-9"', INERTIAL)
    np.testing.assert_allclose(mass_matrix(""), mass_matrix(light), atol=1e-8)


def test_one_motion_of_several_may_be_locked(tmp_path: Path) -> None:
    told = link("a") + joint("j", "planar", "world", "a", '<axis xyz="0 0 1"/>')
    free = robot(tmp_path, told)
    there = link_poses(free, sr.JointSpace(sr.System(free)), np.array([0.3, -0.2, 0.4]))["a"]
    found = robot(tmp_path, told, lock=["j.y", "j.angle"], q0={"j.y": -0.2, "j.angle": 0.4})
    space = sr.JointSpace(sr.System(found))
    place = link_poses(found, space, space.pack({"j.x": 0.3}))["a"]
    assert [type(one).__name__ for one in found.joints] == ["Translational"]
    np.testing.assert_allclose([place.r, *place.A], [there.r, *there.A], atol=1e-15)
    chain = robot(tmp_path, told, lock=["j.x"], q0={"j.x": 0.3})
    space = sr.JointSpace(sr.System(chain))
    place = link_poses(chain, space, space.pack({"j.y": -0.2, "j.angle": 0.4}))["a"]
    assert [type(one).__name__ for one in chain.joints] == ["Translational", "Revolute"]
    np.testing.assert_allclose([place.r, *place.A], [there.r, *there.A], atol=1e-15)


def test_a_joint_called_base_and_a_floating_base_are_refused(tmp_path: Path) -> None:
    with pytest.raises(sr.ModelError, match="Rename"):
        robot(tmp_path, link("a") + joint("base", "revolute", "world", "a"), base="floating")


def test_links_without_mass_at_an_end_are_locked_with_a_note(tmp_path: Path) -> None:
    parts = link("a") + joint("arm", "revolute", "world", "a") + link("tip", "")
    found = robot(tmp_path, parts + joint("wrist", "continuous", "a", "tip", '<origin xyz="1 0 0"/>'))
    assert [body.name for body in found.bodies] == ["a"]
    assert found.link("tip").body.name == "a"
    assert any("wrist" in note for note in found.notes)
    with pytest.raises(sr.ModelError, match="has no mass"):
        robot(tmp_path, link("a", "") + joint("arm", "revolute", "world", "a"))


@pytest.mark.filterwarnings("ignore:.*m from the centre of mass")
def test_a_link_without_mass_that_carries_two_is_a_frame(tmp_path: Path) -> None:
    """It moves as one of a millionth of a gram does."""

    def mass_matrix(mass: str) -> np.ndarray:
        parts = link("a", mass) + joint("yaw", "revolute", "world", "a", '<axis xyz="0 0 1"/>')
        for n, name in enumerate(("b", "c")):
            at = f'<origin xyz="{n + 1} 0.5 0"/><axis xyz="1 {n} 0"/>'
            parts += link(name) + joint(f"to_{name}", "revolute", "a", name, at)
        space = sr.JointSpace(sr.System(robot(tmp_path, parts)))
        return space.M(space.pack({"yaw": 0.3, "to_b": 0.5, "to_c": -0.4}))

    light = re.sub(r'="1"', '="1e-9"', INERTIAL)
    np.testing.assert_allclose(mass_matrix(""), mass_matrix(light), atol=1e-8)


def test_a_world_that_is_not_declared_is_the_ground(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r">{link("a")}{joint("arm", "revolute", "world", "a")}</robot>')
    found = sr.load_urdf(path)
    assert [body.name for body in found.bodies] == ["a"]
    assert found.link("world").body is sr.ground


@pytest.mark.parametrize("kind", ["ball", "spherical"])
def test_a_ball_joint(kind: str, tmp_path: Path) -> None:
    found = robot(tmp_path, link("a") + joint("j", kind, "world", "a", '<origin xyz="1 2 3"/>'))
    assert [type(one).__name__ for one in found.joints] == ["Spherical"]


def test_an_inertia_of_zero_may_be_negative_by_round_off(tmp_path: Path) -> None:
    """Negative moments of a radius of gyration of 0.3 nm are accepted, of 2 µm not; both only with inertia="given"."""
    path = tmp_path / "robot.urdf"
    for moment, fine in ((-5e-20, True), (-4e-12, False)):
        tensor = f'<inertia ixx="{moment}" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
        inner = f'<inertial><mass value="1"/><origin xyz="0 0 1"/>{tensor}</inertial>'
        joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
        path.write_text(f'<robot name="r"><link name="a"/><link name="b">{inner}</link>{joint}</robot>')
        with pytest.raises(sr.ModelError, match="positive definite"):
            sr.load_urdf(path)
        if fine:
            assert sr.simulate(sr.System(sr.load_urdf(path, inertia="given")), until=0.01).success
        else:
            with pytest.raises(sr.ModelError, match="negative kinetic energy"):
                sr.load_urdf(path, inertia="given")
