"""Where the links of an imported robot are, for comparison with other programs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sarrus import JointSpace, Robot
from sarrus.model.geometry.motion import compose, pose
from sarrus.model.geometry.pose import GROUND_POSE, Pose


def link_poses(robot: Robot, space: JointSpace, theta: NDArray[np.float64]) -> dict[str, Pose]:
    """Return the pose of every link in a configuration."""
    q = space.q(theta)
    bodies = {
        name: pose(*np.split(q[space.system.coordinates_of(name)], [3])) for name in space.system.bodies
    }
    bodies["ground"] = GROUND_POSE
    return {name: compose(bodies[link.body.name], link.place) for name, link in robot.links.items()}


def pose_difference(got: Pose, r: NDArray[np.float64], A: NDArray[np.float64]) -> float:
    """Return the largest difference of the position [m] and of the rotation matrix."""
    return float(max(abs(got.r - r).max(), abs(got.A - A).max()))
