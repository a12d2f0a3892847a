"""The length of the first step of a described method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....linalg.factors import SingularSystem
from ..methods.leading_error import Leading
from ..step_loop.newton import NEWTON_SHARE
from ..stepping.first_step import Accelerations, first_step
from ..stepping.motion_scale import Tolerance
from ..stepping.stepper import Settings
from ..stepping.tolerance import Tolerances

TRIALS = 20  # lengths that are tried, each at most half of the one before


def finest(tolerances: Tolerances, q: Array, v: Array) -> float:
    """The step at which round-off in Φ, over h, is as large in v as what Newton's method may leave there."""
    noise = 2 * np.finfo(float).eps * abs(q).max(initial=0.0)
    relative = noise / (tolerances.atol_v + tolerances.rtol_v * abs(v))
    return float(np.sqrt(np.mean(relative**2))) / NEWTON_SHARE


class Beginning(NamedTuple):
    """A consistent state from which a run begins.

    motion : of the system
    t, q, v, a : the state
    span : duration of the run [s]
    settings, tolerance : of the run, as the loop has it
    error : of the first step
    """

    motion: Accelerations
    t: float
    q: Array
    v: Array
    a: Array
    span: float
    settings: Settings
    tolerance: Tolerance
    error: Leading

    def step(self) -> float:
        """A step whose error is well below the tolerance: h² a, or h³ ȧ, ȧ by a difference along the motion."""
        settings, (exponent, constant) = self.settings, self.error
        if settings.first_step:
            return min(settings.first_step, settings.max_step)
        if settings.tolerances.follow:
            state, longest = (self.t, self.q, self.v, self.a), min(0.01 * self.span, settings.max_step)
            return self._within_tolerance(first_step(self.motion, self.tolerance, *state, longest))
        longest = max(0.01 * self.span, finest(settings.tolerances, self.q, self.v))  # it is cut at the end
        ahead = 1e-5 * self.span
        try:
            a = self._acceleration(ahead, self.q + ahead * self.v)
        except SingularSystem:
            a = self.a
        slope = (a - self.a) / ahead if exponent > 2 else a
        size = float(np.sqrt(np.mean((constant * slope / self._tolerance_of_q()) ** 2)))
        guess = 0.4 * size ** (-1 / min(exponent, 3)) if size > 0 else self.span
        guess = float(min(max(guess, 1e-7 * self.span), longest, settings.max_step))
        return max(self._within_tolerance(guess), min(1e-7 * self.span, guess))

    def _acceleration(self, h: float, q: Array) -> Array:
        """Accelerations after a time, at a position there."""
        return self.motion.acceleration(self.t + h, q, self.v + h * self.a)[0]

    def _ahead(self, h: float) -> Array:
        """The same after a step with constant acceleration."""
        return self._acceleration(h, self.q + h * (self.v + 0.5 * h * self.a))

    def _tolerance_of_q(self) -> Array:
        return np.asarray(self.tolerance.atol_q + self.tolerance.rtol_q * abs(self.q))

    def _within_tolerance(self, h: float) -> float:
        """A first step shortened until its estimated error, h² times the change of a over it, is within the tolerance.

        ȧ vanishes where a spring is released at rest: there it does not predict the steps that follow.
        """
        tolerance, (exponent, constant) = self._tolerance_of_q(), self.error
        for _ in range(TRIALS):
            try:
                change = self._ahead(h) - (self.a if exponent > 2 else 0.0)
            except SingularSystem:
                return h
            error = constant * h**2 * float(np.sqrt(np.mean((change / tolerance) ** 2)))
            if not error > 1.0:
                break
            h *= min(max(0.8 * error ** (-1 / min(exponent, 3)), 0.1), 0.5)
        return h
