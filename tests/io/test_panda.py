"""A real arm, read from its maker's URDF: links, masses, kinematics and mass matrix as Pinocchio has them; a fall."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.io.poses import link_poses, pose_difference

import sarrus as sr

DATA = Path(__file__).parent / "data"
EXACT = 1e-10  # rounding of two programs, through nine bodies


@pytest.fixture(scope="module")
def robot() -> sr.Robot:
    return sr.load_urdf(DATA / "panda.urdf", mimic="free", ignore=["dynamics"])


@pytest.fixture(scope="module")
def space(robot: sr.Robot) -> sr.JointSpace:
    return sr.JointSpace(sr.System(robot))


@pytest.fixture(scope="module")
def reference() -> Any:
    return json.loads((DATA / "panda-pinocchio.json").read_text())


def test_links_that_move_are_bodies(robot: sr.Robot) -> None:
    assert len(robot.bodies) == 9
    assert robot.link("panda_hand").body.name == "panda_link7"
    assert robot.link("panda_link0").body is sr.ground
    assert robot.limits["panda_joint4"].lower == -3.0718
    assert robot.mimics == {"panda_finger_joint2": ("panda_finger_joint1", 1.0, 0.0, ())}
    assert robot.visuals[0].file.endswith("meshes/visual/link0.dae")


def test_mass_is_that_of_the_file(robot: sr.Robot) -> None:
    inside = [
        float(part.split('"')[1]) for part in (DATA / "panda.urdf").read_text().split("<mass value=")[1:]
    ]
    assert sum(body.mass for body in robot.bodies) == pytest.approx(sum(inside[1:]), abs=1e-12)


def test_links_stand_where_pinocchio_has_them(robot: sr.Robot, space: sr.JointSpace, reference: Any) -> None:
    for case in reference["poses"]:
        found = link_poses(robot, space, _theta(space, reference, case))
        for link, r, A in zip(reference["links"], case["r"], case["A"], strict=True):
            assert pose_difference(found[link], np.array(r), np.array(A)) < EXACT, link


def test_mass_matrix_is_pinocchios(space: sr.JointSpace, reference: Any) -> None:
    order = [space.velocities_of[name].start for name in reference["joints"]]
    for case in reference["poses"]:
        M = space.M(_theta(space, reference, case))[np.ix_(order, order)]
        np.testing.assert_allclose(M, case["M"], rtol=0, atol=EXACT)


def test_tangent_map_spans_the_null_space(space: sr.JointSpace, reference: Any) -> None:
    system = space.system
    for case in reference["poses"]:
        theta = _theta(space, reference, case)
        assert abs(system.Phi(space.q(theta))).max() < 1e-14
        assert abs(system.Phi_q(space.q(theta)) @ space.T(theta)).max() < 1e-14
    assert system.nq - system.m == space.freedoms == 9


def test_it_falls_and_keeps_its_energy(robot: sr.Robot, space: sr.JointSpace) -> None:
    system = space.system
    motion = sr.simulate(
        system, until=1.0, t_eval=np.linspace(0, 1, 11), method=sr.ODE(rtol=1e-9, atol=1e-11)
    )
    assert motion.success
    energy = [
        system.kinetic_energy(q, v) + _potential(robot, system, q)
        for q, v in zip(motion.q, motion.v, strict=True)
    ]
    assert system.kinetic_energy(motion.q[-1], motion.v[-1]) > 1.0
    assert np.ptp(energy) < 1e-5


def test_its_joints_are_damped(robot: sr.Robot, space: sr.JointSpace) -> None:
    damped = sr.System(sr.load_urdf(DATA / "panda.urdf", mimic="free"))
    theta, rates = space.zero() + 0.01, np.linspace(0.5, 1, 9)
    q, v = space.q(theta), space.T(theta) @ rates
    torques = space.T(theta).T @ (damped.Q(q, v) - space.system.Q(q, v))
    damping = [0.003] * 7 + [0.3] * 2
    np.testing.assert_allclose(torques, -np.array(damping) * rates, rtol=1e-11)


def test_fixed_links_may_stay_bodies(space: sr.JointSpace, reference: Any) -> None:
    kept = sr.load_urdf(DATA / "panda.urdf", mimic="free", keep_fixed=True)
    assert "panda_hand" in {body.name for body in kept.bodies}
    other = sr.JointSpace(sr.System(kept))
    theta = _theta(space, reference, reference["poses"][0])
    np.testing.assert_allclose(other.M(theta), space.M(theta), atol=EXACT)


def test_a_floating_base_adds_six_freedoms(space: sr.JointSpace) -> None:
    floating = sr.load_urdf(
        DATA / "panda.urdf", mimic="free", base="floating", q0={"base": [0, 0, 1, 1, 0, 0, 0]}
    )
    system = sr.System(floating)
    assert system.nq - system.m == space.freedoms + 6
    np.testing.assert_array_equal(system.q0[:7], [0, 0, 1, 1, 0, 0, 0])
    other = sr.JointSpace(system)
    M = other.M(other.pack({"panda_joint4": -1.0}))
    assert np.trace(M[:3, :3]) == pytest.approx(3 * sum(body.mass for body in floating.bodies))
    np.testing.assert_allclose(M[6:, 6:], space.M(space.pack({"panda_joint4": -1.0})), atol=EXACT)


def test_joints_start_at_q0_and_followers_follow(robot: sr.Robot, space: sr.JointSpace) -> None:
    q0 = {"panda_joint2": 0.5, "panda_finger_joint1": 0.02}
    started = sr.System(sr.load_urdf(DATA / "panda.urdf", mimic="free", q0=q0))
    np.testing.assert_allclose(
        started.q0, space.q(space.pack({**q0, "panda_finger_joint2": 0.02})), atol=1e-15
    )
    locked = sr.load_urdf(DATA / "panda.urdf", mimic="lock", q0=q0)
    assert sr.System(locked).counts()["degrees_of_freedom"] == 8
    assert locked.link("panda_rightfinger").body.name == "panda_link7"


def _theta(space: sr.JointSpace, reference: Any, case: Any) -> Any:
    return space.pack(dict(zip(reference["joints"], case["q"], strict=True)))


def _potential(robot: sr.Robot, system: sr.System, q: Any) -> float:
    heights = 0.0
    for body in robot.bodies:
        r, p = np.split(q[system.coordinates_of(body.name)], [3])
        heights += body.mass * (r + sr.model.geometry.rotation.matrix(p) @ np.array(body.center_of_mass))[2]
    return 9.81 * heights
