"""Joints of an MJCF model: ranges as limits and soft stops, springs, dampers, friction and armature."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....model.errors import ModelError
from ....model.show import quote
from ...robot import Dynamics, Limit, Stop
from ..bodies import BALL, joint_names
from ..compiled import disabled
from .compliance import compliance


def limits_of(compiled: Any) -> dict[str, Limit]:
    """Return the ranges of the rotations and slides that have one, relative to the file's pose."""
    names = joint_names(compiled)
    return {names[k]: Limit(*_range(compiled, k)) for k in _limited(compiled)}


def stops_of(compiled: Any) -> dict[str, Stop]:
    """Return the stops of the rotations and slides with a range, relative to the file's pose."""
    names = joint_names(compiled)
    limited = [] if disabled(compiled, "LIMIT") else _limited(compiled)
    return {names[k]: _stop(compiled, k, names[k]) for k in limited}


def balls_with_limit(compiled: Any) -> int:
    """Return how many ball joints have a range, which is no stop."""
    balls = ((compiled.jnt_type == BALL) & (compiled.jnt_limited != 0)).sum()
    return 0 if disabled(compiled, "LIMIT") else int(balls)


def _limited(compiled: Any) -> list[int]:
    return [k for k in range(compiled.njnt) if compiled.jnt_limited[k] and compiled.jnt_type[k] > BALL]


def _range(compiled: Any, k: int) -> tuple[float, float]:
    lower, upper = (float(x - compiled.qpos0[compiled.jnt_qposadr[k]]) for x in compiled.jnt_range[k])
    return lower, upper


def _stop(compiled: Any, k: int, name: str) -> Stop:
    lower, upper = _range(compiled, k)
    margin, inverse = float(compiled.jnt_margin[k]), float(compiled.dof_invweight0[compiled.jnt_dofadr[k]])
    law = compliance(
        compiled, compiled.jnt_solref[k], compiled.jnt_solimp[k], inverse, f"joint {quote(name)}"
    )
    if lower + margin >= upper - margin:
        remedy = 'Reduce its `margin`, or import it with ignore=["limits"].'
        message = f"has a margin of {margin:g} at both ends, which overlap in its range of {upper - lower:g}"
        raise ModelError(f"{message}. {remedy}", part=f"joint {quote(name)}")
    return Stop(lower + margin, upper - margin, *law)


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
