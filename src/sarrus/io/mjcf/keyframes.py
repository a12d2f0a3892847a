"""Keyframes of an MJCF model, relative to the file's pose."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..robot import Keyframe, activation_name
from .bodies import BALL, joint_names
from .compiled import name_of
from .loads.actuators import control_of, count

WIDTHS = ((7, 6), (4, 3), (1, 1), (1, 1))  # of coordinates and velocities, by mjtJoint


def keyframes_of(compiled: Any) -> dict[str, Keyframe]:
    """Return the keyframes by name."""
    return {name_of(compiled, "key", k): _keyframe(compiled, k) for k in range(compiled.nkey)}


def _keyframe(compiled: Any, k: int) -> Keyframe:
    values, rates = dict[str, Any](), dict[str, Any]()
    for joint, name in enumerate(joint_names(compiled)):
        kind = int(compiled.jnt_type[joint])
        at, first = int(compiled.jnt_qposadr[joint]), int(compiled.jnt_dofadr[joint])
        width, freedoms = WIDTHS[kind]
        start = compiled.qpos0[at : at + width] if kind > BALL else np.zeros(width)
        values[name] = np.array(compiled.key_qpos[k, at : at + width] - start)
        rates[name] = np.array(compiled.key_qvel[k, first : first + freedoms])
    return Keyframe(values, rates, *_of_actuators(compiled, k), float(compiled.key_time[k]))


def _of_actuators(compiled: Any, k: int) -> tuple[dict[str, float], dict[str, float]]:
    """Return activations and controls."""
    states, controls = dict[str, float](), dict[str, float]()
    for n in range(count(compiled)):
        name, at = name_of(compiled, "actuator", n), int(compiled.actuator_actadr[n])
        if at >= 0:
            states[activation_name(name)] = float(compiled.key_act[k, at])
        controls[name] = float(compiled.key_ctrl[k, control_of(compiled, n)])
    return states, controls
