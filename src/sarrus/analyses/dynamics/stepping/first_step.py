"""The first step of a run whose tolerances follow its motion: as long as accelerations change little over it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....system import System
from ...equations.length import extent
from .motion_scale import LENGTH, SHARE, SPAN, Tolerance, follow_motion

# Of the velocity that is reached: what accelerations change by over the first step, times the step
LITTLE = 0.03
TRIALS = 60  # steps that are tried
SAVED = ("base", "motion", "size", "states")  # of tolerances that follow a motion
SAME = 0.5  # a change that falls by less than this factor in a much shorter step is not the step's


class Accelerations(Protocol):
    """Solver of the equations of motion, see `Motion`."""

    def acceleration(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """a (nq,) and lam (m,) at a state."""


def begin_motion(
    tolerance: Tolerance, system: System, t: float, q: Array, until: float | None = None
) -> None:
    """Let tolerances follow the motion from a position on, if they do and have not started.

    `until` is the end of the run, for methods whose tolerances depend on the number of periods.
    """
    if not np.any(tolerance.atol_q) and tolerance.size[LENGTH] == 0.0:
        tolerance.base[:] = q
        tolerance.size[LENGTH], tolerance.size[SPAN] = extent(system, q), 0.0 if until is None else until - t


def saved(tolerance: Tolerance) -> dict[str, Array]:
    """Return the data that a continued run needs."""
    return {f"tolerance_{name}": np.array(getattr(tolerance, name)) for name in SAVED}


def take_over(tolerance: Tolerance, state: Mapping[str, Array]) -> None:
    """Go on from such a state."""
    for name in SAVED:
        getattr(tolerance, name)[:] = state[f"tolerance_{name}"]


def _over_length(v: Array, a: Array, length: float) -> float:
    """The time in which a body moves by a length, or rotates by a radian, with v or a of a state [s]."""
    unit = np.where(np.arange(len(v)) % 7 < 3, 1.0, length)
    speed, gain = (float(abs(unit * x).max(initial=0.0)) for x in (v, a))
    return min(length / speed if speed else np.inf, (2 * length / gain) ** 0.5 if gain else np.inf)


def first_step(
    motion: Accelerations, tolerance: Tolerance, t: float, q: Array, v: Array, a: Array, longest: float
) -> float:
    """A step over which the accelerations of the motion from a state change its velocities little.

    Where they change by the same part of the velocities whatever the step, as in motions from rest that begin with
    higher powers of the time, the step is not shortened any more.
    """
    follow, before = link(follow_motion), np.inf
    moving = 7 * len(tolerance.motion)
    h = min(longest, _over_length(v[:moving], a[:moving], float(tolerance.size[LENGTH])))
    for _ in range(TRIALS):
        try:
            later = motion.acceleration(t + h, q + h * (v + 0.5 * h * a), v + h * a)[0]
        except SingularSystem:
            h *= 0.1
            continue
        largest = np.where(abs(later) > abs(a), later, a)
        follow(tolerance, h, q, v, largest, True)
        fast = tolerance.atol_v / (tolerance.share_v * tolerance.size[SHARE])
        change = float(np.sqrt(np.mean((h * (later - a) / fast) ** 2)))
        if change <= LITTLE or SAME * before < change < 2.0:
            return h
        shorter = min(max(0.8 * (LITTLE / change) ** 0.5, 0.1), 0.5) if change < np.inf else 0.1
        before, h = change, h * shorter
    return h
