"""Whether a motion about a state may be fast: a cheap test before what only fast motions need.

Random changes of a state have components of the same size, displacements in parts of the extent of the system. A mode
of any direction, frequency and damping accelerates some coordinate by it, also one of few bodies among many.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ....algebra import Array
from ....linalg.factors import SingularSystem
from ..chain.start import Start

DRAWS = 4  # random changes of states: for a mode to have a small part in one of them is not rare


def fast_motions(start: Start, omega: float) -> bool:
    """Whether there may be modes faster than omega [rad/s] at a state.

    Mechanisms whose motion is prescribed, or that are stuck, have none.
    """
    if not start.freedom:
        return False
    by_q, by_v = _signs(len(start.units)) * start.units
    try:
        return fast_changes(start, by_q, omega * by_v, np.zeros((start.width, DRAWS)), omega, rounds=1)
    except SingularSystem:
        return False


@cache
def _signs(size: int) -> Array:
    """Random signs of changes of coordinates and velocities (2, size, DRAWS)."""
    return np.random.default_rng(5).choice([-1.0, 1.0], (2, size, DRAWS))


def fast_changes(start: Start, q: Array, v: Array, none: Array, omega: float, rounds: int) -> bool:
    """Whether changes of states (nq, k) may contain motions faster than omega, by the accelerations that they cause.

    In further rounds, these are caused by the rates of the changes.
    """
    for _ in range(rounds):
        a = start.along(q, v, none)[0]
        of_q, of_v, of_a = (float(abs(x / start.units).max()) for x in (q, v, a))
        if of_a > omega * max(omega * of_q, of_v):
            return True
        q, v = v, a
    return False
