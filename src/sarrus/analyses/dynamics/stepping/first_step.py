"""The start of a run: tolerances that follow its motion, and the first step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....system import System
from ...equations.length import extent
from ..methods.leading_error import ErrorTerm
from .motion_scale import LENGTH, SPAN, Tolerance, follow_motion

TRIALS = 20  # lengths that are tried, each at most half of the one before
FIRST = ErrorTerm(3, 1.0)  # of a solver whose own is not known: h² times the change of a
SAVED = ("base", "motion", "size", "states")  # of tolerances that follow a motion


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
    motion: Accelerations,
    tolerance: Tolerance,
    error: ErrorTerm,
    t: float,
    q: Array,
    v: Array,
    a: Array,
    longest: float,
) -> float:
    """A step whose estimated error, h² times the change of a over it, is within the tolerance.

    Tolerances that follow the motion are those of the longest step that is tried.
    """
    exponent, constant = error
    moving, length = 7 * len(tolerance.motion), float(tolerance.size[LENGTH])
    h = min(longest, _over_length(v[:moving], a[:moving], length) if length else np.inf)
    states = tolerance.states.copy()
    link(follow_motion)(tolerance, h, q, v, a, True)
    tolerance.states[:] = states  # whose largest values stay
    allowed = tolerance.atol_q + tolerance.rtol_q * abs(q)
    for _ in range(TRIALS):
        try:
            later = motion.acceleration(t + h, q + h * (v + 0.5 * h * a), v + h * a)[0]
        except SingularSystem:
            h *= 0.1
            continue
        change = (later - a if exponent > 2 else later) / allowed
        size = constant * h**2 * float(np.sqrt(np.mean(change**2)))
        if size <= 1.0:
            break
        h *= min(max(0.8 * size ** (-1 / min(exponent, 3)), 0.1), 0.5) if size < np.inf else 0.1
    return h
