"""Springs, dampers, dry friction and armature of the joints of an MJCF model."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...robot import Dynamics
from ..bodies import BALL, joint_names
from ..flags import disabled


def dynamics_of(compiled: Any) -> dict[str, Dynamics]:
    """Return the dynamics of each joint that has any; the free value of a spring is relative to the file's pose."""
    names = joint_names(compiled)
    found = {names[k]: _dynamics(compiled, k) for k in range(compiled.njnt)}
    return {name: dynamics for name, dynamics in found.items() if dynamics != Dynamics()}


def _dynamics(compiled: Any, k: int) -> Dynamics:
    first, at = int(compiled.jnt_dofadr[k]), int(compiled.jnt_qposadr[k])
    stiffness = 0.0 if disabled(compiled, "SPRING") else float(compiled.jnt_stiffness[k])
    has_spring = stiffness and compiled.jnt_type[k] > BALL
    return Dynamics(
        stiffness=stiffness,
        free=float(compiled.qpos_spring[at] - compiled.qpos0[at]) if has_spring else 0.0,
        damping=0.0 if disabled(compiled, "DAMPER") else float(compiled.dof_damping[first]),
        friction=0.0 if disabled(compiled, "FRICTIONLOSS") else float(compiled.dof_frictionloss[first]),
        inertia=float(compiled.dof_armature[first]),
    )


def has_nonlinear_springs(compiled: Any) -> int:
    """Return how many joints have a polynomial spring or damper, or a spring that yields."""
    names = ("jnt_stiffnesspoly", "dof_dampingpoly", "jnt_springyield")
    arrays = [getattr(compiled, name, np.zeros(0)) for name in names]
    return sum(int(np.any(array.reshape(len(array), -1), axis=1).sum()) for array in arrays if array.size)
