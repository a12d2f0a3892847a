"""The joints of an MJCF body as motions, with their ranges and initial values."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...model.geometry.motion import Ball, Free, Motion, Slide, Turn
from ..robot import Limit
from .compiled import name_of

FREE, BALL, SLIDE, HINGE = range(4)  # mjtJoint


def motions_of(compiled: Any, body: int) -> tuple[Motion, ...]:
    """Return the motions of a body in its parent, in their order."""
    first, count = int(compiled.body_jntadr[body]), int(compiled.body_jntnum[body])
    return tuple(_motion(compiled, k) for k in range(first, first + count))


def joint_names(compiled: Any) -> list[str]:
    """Return the names of the joints."""
    return [name_of(compiled.joint(k), "joint") for k in range(compiled.njnt)]


def zeros_of(compiled: Any) -> dict[str, list[float]]:
    """Return where free bodies stand in the file: [r, p] by joint name."""
    names = joint_names(compiled)
    free = [k for k in range(compiled.njnt) if compiled.jnt_type[k] == FREE]
    places = {k: int(compiled.jnt_qposadr[k]) for k in free}
    return {names[k]: [float(x) for x in compiled.qpos0[at : at + 7]] for k, at in places.items()}


def limits_of(compiled: Any) -> dict[str, Limit]:
    """Return the ranges of the rotations and slides that have one."""
    limited = [k for k in range(compiled.njnt) if compiled.jnt_limited[k] and compiled.jnt_type[k] > BALL]
    names = joint_names(compiled)
    return {names[k]: Limit(*(float(x) for x in compiled.jnt_range[k])) for k in limited}


def _motion(compiled: Any, k: int) -> Motion:
    name, kind = name_of(compiled.joint(k), "joint"), int(compiled.jnt_type[k])
    axis, point = np.array(compiled.jnt_axis[k]), np.array(compiled.jnt_pos[k])
    if kind == FREE:
        return Free(name)
    if kind == BALL:
        return Ball(name, point)
    return Slide(name, axis) if kind == SLIDE else Turn(name, axis, point)
