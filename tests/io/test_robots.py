"""Real robots that nobody here has written, against Pinocchio: masses, poses of all links, mass matrix."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.io.poses import link_poses, pose_difference

import sarrus as sr

pin = pytest.importorskip("pinocchio")
pytestmark = pytest.mark.needs("pinocchio")

EXACT = 1e-10  # rounding of two programs, through dozens of bodies
POSES = 100


def robots() -> Path:
    """Return the folder of the package example-robot-data; an empty path if it is not installed."""
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        return Path()
    return Path(str(package.locate_file("cmeel.prefix/share/example-robot-data/robots")))


CHOSEN = {
    "panda_description/urdf/panda.urdf": "fixed",
    "ur_description/urdf/ur5_robot.urdf": "fixed",
    "xarm_description/urdf/xarm7.urdf": "fixed",
    "z1_description/urdf/z1.urdf": "fixed",
    "kinova_description/robots/kinova.urdf": "fixed",
    "solo_description/robots/solo12.urdf": "floating",
    "anymal_c_simple_description/urdf/anymal.urdf": "floating",
    "g1_description/urdf/g1_29dof_rev_1_0.urdf": "floating",
    "talos_data/robots/talos_reduced.urdf": "floating",
    "tiago_description/robots/tiago.urdf": "fixed",
}


@pytest.mark.one_in(2)
@pytest.mark.skipif(not robots().name, reason="example-robot-data is not installed")
@pytest.mark.parametrize("file", CHOSEN)
def test_robot_agrees_with_pinocchio(file: str) -> None:
    path, base = robots() / file, CHOSEN[file]
    robot = sr.load_urdf(path, base=base, mimic="free", inertia="given")  # type: ignore[arg-type]
    space = sr.JointSpace(sr.System(robot))
    root = [pin.JointModelFreeFlyer()] if base == "floating" else []
    model = pin.buildModelFromUrdf(str(path), *root)
    data, rng = model.createData(), np.random.default_rng(6)
    mass = sum(inertia.mass for inertia in list(model.inertias)[1:])
    assert sum(body.mass for body in robot.bodies) == pytest.approx(mass, rel=1e-13)
    for _ in range(POSES):
        theta, q, P = random_configuration(space, model, rng)
        pin.framesForwardKinematics(model, data, q)
        for link, pose in link_poses(robot, space, theta).items():
            frame = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
            assert pose_difference(pose, frame.translation, frame.rotation) < EXACT, link
        upper = np.triu(pin.crba(model, data, q))
        M = upper + np.triu(upper, 1).T
        assert abs(P.T @ space.M(theta) @ P - M).max() < EXACT * max(1, abs(M).max())


def random_configuration(space: sr.JointSpace, model: Any, rng: np.random.Generator) -> tuple[Any, Any, Any]:
    """Coordinates here and there, and P with θ̇ = P v_pinocchio."""
    theta, q, P = space.zero(), pin.neutral(model), np.zeros((space.freedoms, model.nv))
    for k in range(1, model.njoints):
        name, joint = model.names[k], model.joints[k]
        name = "base" if name == "root_joint" else name
        there = slice(joint.idx_q, joint.idx_q + joint.nq)
        rates = space.velocities_of[name], slice(joint.idx_v, joint.idx_v + joint.nv)
        if joint.nq == 7:
            r, p = rng.normal(size=3), rng.normal(size=4)
            p /= np.linalg.norm(p)
            theta[space.coordinates_of[name]], q[there] = [*r, *p], [*r, *p[1:], p[0]]
            P[rates] = np.eye(6)
            P[rates[0], rates[1]][:3, :3] = pin.Quaternion(*p).matrix()  # its linear velocity is in body axes
        else:
            angle = rng.uniform(-3, 3)
            theta[space.coordinates_of[name]] = angle
            q[there] = angle if joint.nq == 1 else (np.cos(angle), np.sin(angle))
            P[rates] = 1
    return theta, q, P
