"""A curve of positions on the constraints, from a simulated motion or from a function of one parameter."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline

from ...algebra import Array
from ...results import Trajectory
from ...system import System
from ..position.feasible import Feasible

TOLERANCE, STEPS = 1e-13, 30


class Path:
    """q(s), brought onto Φ = 0 by the least change.

    Parameters
    ----------
    system : System
    motion : a trajectory (s is time, in between cubic Hermite interpolation), or a function of s that returns q (nq,)
    grid : values of s, rising; by default the times of the trajectory

    Raises
    ------
    ValueError
        If a function comes without a grid, or the grid does not rise.
    """

    def __init__(
        self, system: System, motion: Trajectory | Callable[[float], ArrayLike], grid: ArrayLike | None
    ) -> None:
        if not isinstance(motion, Trajectory) and grid is None:
            raise ValueError(
                "grid: a function of positions needs one. Give the parameters at which it is evaluated."
            )
        values = motion.t if grid is None and isinstance(motion, Trajectory) else grid
        self.grid = np.asarray(values, dtype=float)
        if self.grid.ndim != 1 or len(self.grid) < 2 or np.any(np.diff(self.grid) <= 0):
            raise ValueError("grid: it must rise. Give at least two numbers.")
        self._guess = _interpolant(motion) if isinstance(motion, Trajectory) else motion
        self._system, self._timed = system, isinstance(motion, Trajectory)

    def time(self, s: float) -> float:
        """The time at s [s]: s itself on a trajectory, 0 in a family of positions."""
        return s if self._timed else 0.0

    def __call__(self, s: float) -> Array:
        """q (nq,) at s."""
        onto = Feasible(self._system, np.ones(self._system.nq), self.time(s))
        return onto(np.asarray(self._guess(s), dtype=float), TOLERANCE, STEPS).q


def _interpolant(motion: Trajectory) -> Callable[[float], ArrayLike]:
    return CubicHermiteSpline(motion.t, motion.q, motion.v)  # type: ignore[no-any-return]
