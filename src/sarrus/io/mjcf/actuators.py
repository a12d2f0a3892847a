"""Actuators of an MJCF model that act on one joint, with a gain and a bias linear in its coordinate and rate."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..robot import Actuator
from .bodies import BALL, joint_names
from .compiled import name_of
from .flags import disabled

UNLIMITED = (-np.inf, np.inf)
PASSIVE = ("actuator_armature", "actuator_damping", "actuator_dampingpoly")  # since MuJoCo 4


def actuators_of(compiled: Any) -> dict[str, Actuator]:
    """Return the supported actuators by name."""
    chosen = [k for k in active_actuators(compiled) if is_linear(compiled, k)]
    return {name_of(compiled.actuator(k), "actuator"): _actuator(compiled, k) for k in chosen}


def active_actuators(compiled: Any) -> list[int]:
    """Return the actuators that no flag and no group of the file switches off."""
    if disabled(compiled, "ACTUATION"):
        return []
    groups = int(compiled.opt.disableactuator)
    return [k for k in range(compiled.nu) if not groups >> int(compiled.actuator_group[k]) & 1]


def is_linear(compiled: Any, k: int) -> bool:
    """Return whether an actuator acts on one hinge or slide with a force linear in control, coordinate and rate."""
    joint, transmission = int(compiled.actuator_trnid[k, 0]), int(compiled.actuator_trntype[k])
    return (
        transmission <= 1  # a joint, whose gear has one number
        and compiled.jnt_type[joint] > BALL
        and not compiled.jnt_actfrclimited[joint]
        and compiled.actuator_dyntype[k] == 0
        and compiled.actuator_gaintype[k] == 0
        and compiled.actuator_biastype[k] <= 1
        and not is_passive(compiled, k)
        and not getattr(compiled, "actuator_delay", np.zeros(compiled.nu))[k]
    )


def is_passive(compiled: Any, k: int) -> bool:
    """Return whether an actuator has an armature or a damping of its own."""
    return any(np.any(getattr(compiled, name)[k]) for name in PASSIVE if hasattr(compiled, name))


def acts_without_control(compiled: Any, k: int) -> bool:
    """Return whether an actuator has a force where its control is zero."""
    return bool(compiled.actuator_biastype[k]) or is_passive(compiled, k)


def _actuator(compiled: Any, k: int) -> Actuator:
    """Return force = gear · (gain u + b0 + b1 l + b2 l̇), l = gear · (x + the coordinate in the file's pose)."""
    joint, gear = int(compiled.actuator_trnid[k, 0]), float(compiled.actuator_gear[k, 0])
    b0, b1, b2 = (float(b) for b in compiled.actuator_biasprm[k, :3] * (compiled.actuator_biastype[k] == 1))
    start = float(compiled.qpos0[compiled.jnt_qposadr[joint]])
    forces, controls = UNLIMITED, UNLIMITED
    if compiled.actuator_forcelimited[k]:
        forces = _limits(gear * compiled.actuator_forcerange[k])
    if compiled.actuator_ctrllimited[k] and not disabled(compiled, "CLAMPCTRL"):
        controls = _limits(compiled.actuator_ctrlrange[k])
    return Actuator(
        joint_names(compiled)[joint],
        gain=gear * float(compiled.actuator_gainprm[k, 0]),
        offset=gear * (b0 + b1 * gear * start),
        kp=-b1 * gear**2,
        kv=-b2 * gear**2,
        forces=forces,
        controls=controls,
    )


def _limits(ends: Any) -> tuple[float, float]:
    return float(min(ends)), float(max(ends))
