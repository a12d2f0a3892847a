"""Actuators of an MJCF model: on a joint, a tendon or a site, linear in control, length and rate, or muscles."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....model.geometry.motion import unit
from ....model.geometry.rotation import matrix
from ....model.quantity import triple
from ...robot import Activation, Actuator, Contraction, MuscleDynamics, Path, Wrench
from ..bodies import BALL, names_of
from ..compiled import ActuatorDynamics, Gain, Transmission, disabled, name_of, no_passive_forces
from . import tendons

UNLIMITED = (-np.inf, np.inf)
PASSIVE = ("actuator_armature", "actuator_damping", "actuator_dampingpoly")  # since MuJoCo 4
RANGE, FORCE, SCALE, SHORTEST, LONGEST, SPEED, MUSCLES_PASSIVE, ECCENTRIC = slice(0, 2), *range(2, 9)
STATIONARY = 1e-12  # [1/kg] acceleration by a unit force below which the length is stationary
OF_BIAS = [0, 1, FORCE, SCALE, LONGEST, MUSCLES_PASSIVE]


def actuators_of(compiled: Any) -> dict[str, Actuator]:
    """Return the supported actuators by name."""
    chosen = [k for k in active_actuators(compiled) if is_supported(compiled, k)]
    return {name_of(compiled, "actuator", k): _actuator(compiled, k) for k in chosen}


def active_actuators(compiled: Any) -> list[int]:
    """Return the actuators that no flag and no group of the file switches off."""
    if disabled(compiled, "ACTUATION"):
        return []
    groups = int(compiled.opt.disableactuator)
    return [k for k in range(count(compiled)) if not groups >> int(compiled.actuator_group[k]) & 1]


def count(compiled: Any) -> int:
    """Return the number of actuators, some of which have several controls since MuJoCo 4."""
    return len(compiled.actuator_group)


def control_of(compiled: Any, k: int) -> int:
    """Return the place of the first control of an actuator."""
    return int(compiled.actuator_ctrladr[k]) if hasattr(compiled, "actuator_ctrladr") else k


def gears_of(compiled: Any, k: int) -> Any:
    """Return the gears of the first output of an actuator, some of which have several. (6,)"""
    return compiled.actuator_gear[
        int(compiled.actuator_outadr[k]) if hasattr(compiled, "actuator_outadr") else k
    ]


def is_supported(compiled: Any, k: int) -> bool:
    """Return whether an actuator is linear in control, length and rate, or a muscle, with one state at most."""
    linear = compiled.actuator_gaintype[k] <= Gain.AFFINE and compiled.actuator_biastype[k] <= Gain.AFFINE
    return (
        _has_place(compiled, k)
        and (linear or (is_muscle(compiled, k) and _is_free(compiled, k)))
        and (
            compiled.actuator_dyntype[k] <= ActuatorDynamics.EXACT or muscle_dynamics(compiled, k) is not None
        )
        and not is_passive(compiled, k)
        and not np.any(getattr(compiled, "actuator_delay", np.zeros(count(compiled)))[k])
    )


def _is_free(compiled: Any, k: int) -> bool:
    """Return whether an actuator is on a joint or tendon, and its force has no limits."""
    place, kind = int(compiled.actuator_trnid[k, 0]), int(compiled.actuator_trntype[k])
    limited: dict[int, str] = {
        Transmission.TENDON: "tendon_actfrclimited",
        Transmission.JOINT: "jnt_actfrclimited",
        Transmission.IN_PARENT: "jnt_actfrclimited",
    }
    free = kind in limited and not getattr(compiled, limited[kind])[place]
    return bool(free and not compiled.actuator_forcelimited[k])


def muscle_obstacle(compiled: Any, k: int) -> str:
    """Return what a muscle has that is not supported; empty for other actuators, and without such a thing."""
    if compiled.actuator_gaintype[k] != Gain.MUSCLE:
        return ""
    return (
        obstacle(compiled, k)
        if _is_free(compiled, k)
        else "a limited force (forcerange), or on no joint or tendon"
    )


def is_passive(compiled: Any, k: int) -> bool:
    """Return whether an actuator has an armature or a damping of its own."""
    return any(np.any(getattr(compiled, name)[k]) for name in PASSIVE if hasattr(compiled, name))


def acts_without_control(compiled: Any, k: int) -> bool:
    """Return whether an actuator has a force where its control is zero, or whether it cannot be zero."""
    controls, states = _controls(compiled, k), _states(compiled, k)
    is_zero = all(lower <= 0 <= upper for lower, upper in (controls, states))
    return bool(compiled.actuator_biastype[k]) or is_passive(compiled, k) or not is_zero


def early_activations(compiled: Any) -> int:
    """Return how many supported actuators have the activation of the end of a step of MuJoCo."""
    chosen = [k for k in active_actuators(compiled) if is_supported(compiled, k)]
    return sum(bool(compiled.actuator_actearly[k] and compiled.actuator_dyntype[k]) for k in chosen)


def _has_place(compiled: Any, k: int) -> bool:
    """Return whether what an actuator acts on is a hinge, a slide, a tendon, or a site by itself."""
    place, kind = int(compiled.actuator_trnid[k, 0]), int(compiled.actuator_trntype[k])
    if kind in (Transmission.JOINT, Transmission.IN_PARENT):
        one_number = compiled.jnt_type[place] > BALL
        return bool(one_number and (not compiled.jnt_actfrclimited[place] or _is_alone(compiled, k, place)))
    if kind == Transmission.TENDON:
        others = [n for n in _of_tendon(compiled, place) if n != k]
        return not (compiled.tendon_actfrclimited[place] and others)
    if kind != Transmission.SITE:
        return False
    bias = compiled.actuator_biastype[k] and np.any(compiled.actuator_biasprm[k, 1:3])
    reference = int(compiled.actuator_trnid[k, 1])
    return not (bias or np.any(compiled.actuator_gainprm[k, 1:3])) and (
        reference < 0 or compiled.site_bodyid[reference] == 0
    )


def _is_alone(compiled: Any, k: int, joint: int) -> bool:
    """Return whether no other actuator acts on a joint, the sum of whose forces is limited."""
    kinds, places = compiled.actuator_trntype, compiled.actuator_trnid[:, 0]
    others = [n for n in range(count(compiled)) if n != k]
    return all(
        kinds[n] in (Transmission.JOINT, Transmission.IN_PARENT) and places[n] != joint for n in others
    )


def _of_tendon(compiled: Any, tendon: int) -> list[int]:
    """Return the actuators of a tendon."""
    kinds, places = compiled.actuator_trntype, compiled.actuator_trnid[:, 0]
    return [n for n in range(count(compiled)) if kinds[n] == Transmission.TENDON and places[n] == tendon]


def _actuator(compiled: Any, k: int) -> Actuator:
    """Return a muscle, or gear · ((g0 + g1 l + g2 l̇) u + b0 + b1 l + b2 l̇).

    l = gear · (x + the length in the file's pose).
    """
    place, kind = int(compiled.actuator_trnid[k, 0]), int(compiled.actuator_trntype[k])
    on: Any = None
    gear, forces, start = float(gears_of(compiled, k)[0]), UNLIMITED, 0.0
    if kind == Transmission.SITE:
        gear, on = 1.0, _wrench(compiled, k, place)
    elif kind == Transmission.TENDON:
        on = tendons.path_of(compiled, place)
        start = on.start
        if compiled.tendon_actfrclimited[place]:
            forces = _limits(gear * compiled.tendon_actfrcrange[place])  # of the force before the gear
    else:
        on, start = name_of(compiled, "joint", place), float(compiled.qpos0[compiled.jnt_qposadr[place]])
        if compiled.jnt_actfrclimited[place]:
            forces = _limits(compiled.jnt_actfrcrange[place])
    controls, activation = _controls(compiled, k), _activation(compiled, k)
    if is_muscle(compiled, k):
        path = on if isinstance(on, Path) else Path({on: 1.0}, start=start)
        return Actuator(
            path.scaled(gear),
            0.0,
            controls=controls,
            activation=activation,
            contraction=contraction(compiled, k),
        )
    g0, g1, g2 = _affine(compiled.actuator_gainprm[k], compiled.actuator_gaintype[k], True)
    b0, b1, b2 = _affine(compiled.actuator_biasprm[k], compiled.actuator_biastype[k], False)
    if compiled.actuator_forcelimited[k]:
        forces = _within(forces, _limits(gear * compiled.actuator_forcerange[k]))
    return Actuator(
        on,
        gain=gear * (g0 + g1 * gear * start),
        offset=gear * (b0 + b1 * gear * start),
        kp=-b1 * gear**2,
        kv=-b2 * gear**2,
        forces=forces,
        controls=controls,
        gain_x=g1 * gear**2,
        gain_v=g2 * gear**2,
        activation=activation,
    )


def _affine(numbers: Any, kind: Any, has_constant: bool) -> tuple[float, float, float]:
    """Return the factors of 1, length and rate of a gain, which always has a constant, or of a bias."""
    first, second, third = (float(x) for x in numbers[:3])
    return (first, second, third) if kind == Gain.AFFINE else (first * has_constant, 0.0, 0.0)


def _activation(compiled: Any, k: int) -> Activation | MuscleDynamics | None:
    dynamics = int(compiled.actuator_dyntype[k])
    if not dynamics:
        return None
    if dynamics > ActuatorDynamics.EXACT:
        return muscle_dynamics(compiled, k)
    time = float(compiled.actuator_dynprm[k, 0]) if dynamics != ActuatorDynamics.INTEGRATOR else 0.0
    return Activation(time, 0.0, *_states(compiled, k), arrest=float(compiled.opt.timestep))


def _controls(compiled: Any, k: int) -> tuple[float, float]:
    """Return the limits of the first control."""
    control = control_of(compiled, k)
    limited = compiled.actuator_ctrllimited[control] and not disabled(compiled, "CLAMPCTRL")
    return _limits(compiled.actuator_ctrlrange[control]) if limited else UNLIMITED


def _states(compiled: Any, k: int) -> tuple[float, float]:
    """Return the limits of the activation."""
    return _limits(compiled.actuator_actrange[k]) if compiled.actuator_actlimited[k] else UNLIMITED


def _wrench(compiled: Any, k: int, site: int) -> Wrench:
    reference = int(compiled.actuator_trnid[k, 1])  # of the world, or none
    A = matrix(unit(np.array(compiled.site_quat[site if reference < 0 else reference], dtype=float)))
    force, torque = A @ gears_of(compiled, k)[:3], A @ gears_of(compiled, k)[3:]
    link = name_of(compiled, "body", compiled.site_bodyid[site])
    return Wrench(
        link,
        triple(compiled.site_pos[site]),
        triple(force),
        triple(torque),
        "global" if reference >= 0 else "body",
    )


def _limits(ends: Any) -> tuple[float, float]:
    return float(min(ends)), float(max(ends))


def _within(outer: tuple[float, float], inner: tuple[float, float]) -> tuple[float, float]:
    """Return inner limits, between outer ones."""
    lower, upper = (min(max(end, outer[0]), outer[1]) for end in inner)
    return lower, upper


def is_muscle(compiled: Any, k: int) -> bool:
    """Return whether an actuator has the gain of a muscle that can be imported, and its bias or none."""
    return int(compiled.actuator_gaintype[k]) == Gain.MUSCLE and not obstacle(compiled, k)


def obstacle(compiled: Any, k: int) -> str:
    """Return what an actuator with the gain of a muscle has that is not supported; empty without such a thing."""
    gains, biases = compiled.actuator_gainprm[k], compiled.actuator_biasprm[k]
    bias, same = int(compiled.actuator_biastype[k]), np.array_equal(gains[OF_BIAS], biases[OF_BIAS])
    obstacles = {
        "a bias other than that of its gain": bias and not (bias == Gain.MUSCLE and same),
        "a lengthrange without length": np.ptp(compiled.actuator_lengthrange[k]) <= 0,
        "a range without length": gains[0] >= gains[1],
        "lmin that is not from 0 to below 1": not 0 <= gains[SHORTEST] < 1,
        "lmax of 1 or less": gains[LONGEST] <= 1,
        "fvmax of 1 or less": gains[ECCENTRIC] <= 1,
        "vmax of 0 or less": gains[SPEED] <= 0,
        "negative fpmax": gains[MUSCLES_PASSIVE] < 0,
        "a force that follows from scale, but a stationary length in the pose of the file, for which it needs a "
        "force": gains[FORCE] < 0 and compiled.actuator_acc0[k] < STATIONARY,
    }
    return next((text for text, is_so in obstacles.items() if is_so), "")


def contraction(compiled: Any, k: int) -> Contraction:
    """Return the tension of a muscle.

    Its ends of ``lengthrange`` are those of ``range`` in optimal lengths, and a negative force is replaced by the scale
    over the acceleration that a unit force causes in the pose of the file, as in MuJoCo.
    """
    gains = compiled.actuator_gainprm[k]
    first, last = (float(x) for x in compiled.actuator_lengthrange[k])
    low, high = (float(x) for x in gains[RANGE])
    optimal = (last - first) / (high - low)
    peak = gains[FORCE] if gains[FORCE] >= 0 else gains[SCALE] / compiled.actuator_acc0[k]
    return Contraction(
        peak_force=float(peak),
        optimal_length=optimal,
        tendon_length=first - low * optimal,
        min_length=float(gains[SHORTEST]),
        max_length=float(gains[LONGEST]),
        max_velocity=float(gains[SPEED]),
        passive_force=float(gains[MUSCLES_PASSIVE]) if compiled.actuator_biastype[k] else 0.0,
        eccentric_force=float(gains[ECCENTRIC]),
    )


def muscle_dynamics(compiled: Any, k: int) -> MuscleDynamics | None:
    """Return the activation dynamics of a muscle; None for others, and with limits within 0 and 1."""
    rise, fall, smoothing = (float(x) for x in compiled.actuator_dynprm[k, :3])
    lower, upper = compiled.actuator_actrange[k]
    limited = compiled.actuator_actlimited[k] and (lower > 0 or upper < 1)
    if compiled.actuator_dyntype[k] != ActuatorDynamics.MUSCLE or limited or min(rise, fall) <= 0:
        return None
    return MuscleDynamics(rise, fall, max(smoothing, 0.0))


def lifted_by(compiled: Any) -> dict[str, float]:
    """Return the part of its weight that is taken from each body."""
    if disabled(compiled, "GRAVITY") or no_passive_forces(compiled):
        return {}
    return dict(zip(names_of(compiled), map(float, compiled.body_gravcomp), strict=True))


def limited_lifts(compiled: Any) -> int:
    """Return how many joints compensate weights by their actuators, which are limited, switched off or missing."""
    if not any(lifted_by(compiled).values()):
        return 0
    missing = disabled(compiled, "ACTUATION") or not count(compiled)
    return int(((compiled.jnt_actgravcomp != 0) & ((compiled.jnt_actfrclimited != 0) | missing)).sum())
