"""Muscles of an MJCF model: gains and biases by the curves of MuJoCo, and the dynamics of their activation."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...robot import Contraction, MuscleDynamics

DYNAMICS, GAIN, BIAS = 4, 2, 2  # mjtDyn, mjtGain, mjtBias
RANGE, FORCE, SCALE, SHORTEST, LONGEST, SPEED, PASSIVE, ECCENTRIC = slice(0, 2), *range(2, 9)
STATIONARY = 1e-12  # [1/kg] acceleration by a unit force below which the length is stationary
OF_BIAS = [0, 1, FORCE, SCALE, LONGEST, PASSIVE]


def is_muscle(compiled: Any, k: int) -> bool:
    """Return whether an actuator has the gain of a muscle that can be imported, and its bias or none."""
    return int(compiled.actuator_gaintype[k]) == GAIN and not obstacle(compiled, k)


def obstacle(compiled: Any, k: int) -> str:
    """Return what an actuator with the gain of a muscle has that is not supported; empty without such a thing."""
    gains, biases = compiled.actuator_gainprm[k], compiled.actuator_biasprm[k]
    bias, same = int(compiled.actuator_biastype[k]), np.array_equal(gains[OF_BIAS], biases[OF_BIAS])
    obstacles = {
        "a bias other than that of its gain": bias and not (bias == BIAS and same),
        "a lengthrange without length": np.ptp(compiled.actuator_lengthrange[k]) <= 0,
        "a range without length": gains[0] >= gains[1],
        "lmin that is not from 0 to below 1": not 0 <= gains[SHORTEST] < 1,
        "lmax of 1 or less": gains[LONGEST] <= 1,
        "fvmax of 1 or less": gains[ECCENTRIC] <= 1,
        "vmax of 0 or less": gains[SPEED] <= 0,
        "negative fpmax": gains[PASSIVE] < 0,
        "a force that follows from scale, but a stationary length in the pose of the file, for which it needs a "
        "force": gains[FORCE] < 0 and compiled.actuator_acc0[k] < STATIONARY,
    }
    return next((text for text, is_so in obstacles.items() if is_so), "")


def contraction(compiled: Any, k: int) -> Contraction:
    """Return the tension of a muscle.

    Its ends of ``lengthrange`` are those of ``range`` in optimal lengths, and a negative force is replaced by the scale
    over the acceleration that a unit force causes in the pose of the file, as in MuJoCo.
    """
    given = compiled.actuator_gainprm[k]
    first, last = (float(x) for x in compiled.actuator_lengthrange[k])
    low, high = (float(x) for x in given[RANGE])
    optimal = (last - first) / (high - low)
    peak = given[FORCE] if given[FORCE] >= 0 else given[SCALE] / compiled.actuator_acc0[k]
    return Contraction(
        peak_force=float(peak),
        optimal_length=optimal,
        tendon_length=first - low * optimal,
        min_length=float(given[SHORTEST]),
        max_length=float(given[LONGEST]),
        max_velocity=float(given[SPEED]),
        passive_force=float(given[PASSIVE]) if compiled.actuator_biastype[k] else 0.0,
        eccentric_force=float(given[ECCENTRIC]),
    )


def muscle_dynamics(compiled: Any, k: int) -> MuscleDynamics | None:
    """Return the activation dynamics of a muscle; None for others, and with limits within 0 and 1."""
    rise, fall, smoothing = (float(x) for x in compiled.actuator_dynprm[k, :3])
    lower, upper = compiled.actuator_actrange[k]
    limited = compiled.actuator_actlimited[k] and (lower > 0 or upper < 1)
    if compiled.actuator_dyntype[k] != DYNAMICS or limited or min(rise, fall) <= 0:
        return None
    return MuscleDynamics(rise, fall, max(smoothing, 0.0))
