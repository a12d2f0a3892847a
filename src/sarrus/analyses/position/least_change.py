"""Along the constraints to the nearest coordinates: q = argmin ½ (q - q₀)ᵀ W (q - q₀) with Φ(q) = 0."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array

from ...algebra import Array
from ...linalg.factors import SingularSystem
from ...linalg.kkt import KKT
from ...linalg.minimum_step import MinimumStep
from ...linalg.rank import divided, row_lengths
from ...system import System
from ..equations.length import scaled, units
from .feasible import Feasible

STATIONARY = 1e-12  # of the gradient along the constraints, relative to W (q - q₀)
ITERATIONS = 60
SHIFTS = (0.0, 0.3, 1.0, 3.0, 10.0)  # times W, added until the step goes downhill
HALVINGS = 12
CLOSE = 1e-5  # a step so short that round-off hides how the distance falls, and that needs no such test
LITTLE = 1e-3  # a change, in parts of the system's length, whose gradient need not be smaller
LONGEST = 0.5  # largest entry of a step
RETRACTIONS = 12  # steps back onto the constraints


@dataclass(frozen=True)
class Nearest:
    """q (nq,), its multipliers λ (m,), Newton steps, and whether W (q - q₀) + Φ_qᵀλ = 0 within round-off."""

    q: Array
    lam: Array
    steps: int
    stationary: bool


class LeastChange:
    """Newton's method with the exact curvature (Φ_qᵀλ)_q, each step followed by one back onto the constraints.

    Parameters
    ----------
    system : System
    weight : (nq,) the diagonal of W
    free : (nq,) which coordinates are not held
    t : time [s]
    """

    def __init__(self, system: System, weight: Array, free: Array, t: float) -> None:
        self.system, self.weight, self.free, self.t = system, weight, np.flatnonzero(free), t
        self._inverse = np.where(free, 1 / weight, 0.0)
        self._feasible = Feasible(system, self._inverse, t)
        self._unit = units(system.nq, self._feasible.length)
        self._heaviest = float((self._unit**2 * weight).max(initial=0.0))

    def __call__(self, q: Array, guess: Array, tolerance: float) -> Nearest:
        """Descend from q, on the constraints, towards the guess (both (nq,))."""
        for steps in range(ITERATIONS):
            J = self.system.Phi_q(q, self.t)
            lam, slope = self._multipliers(J, q - guess)
            size = np.linalg.norm(self._unit * self.weight * (q - guess))
            if np.linalg.norm(self._unit * slope) <= STATIONARY * (size + LITTLE * self._heaviest):
                return Nearest(q, lam, steps, True)
            there = self._descend(q, guess, J, lam, slope, tolerance)
            if there is None:
                return Nearest(q, lam, steps, False)
            q = there
        return Nearest(q, lam, ITERATIONS, False)

    def _multipliers(self, J: csr_array, change: Array) -> tuple[Array, Array]:
        """λ that makes W (q - q₀) + Φ_qᵀλ least in the metric, and this remainder."""
        rows = row_lengths(scaled(J, self._feasible.length))
        step, lam, slope = (
            MinimumStep(divided(J, rows), self._inverse),
            np.zeros(len(rows)),
            self.weight * change,
        )
        for _ in range(2):
            lam = lam + step.multipliers(-(J @ (self._inverse * slope)) / rows) / rows
            slope = self.weight * change + J.T @ lam
        return lam, np.where(self._inverse > 0, slope, 0.0)

    def _descend(
        self, q: Array, guess: Array, J: csr_array, lam: Array, slope: Array, tolerance: float
    ) -> Array | None:
        step = self._direction(q, J, lam, slope)
        longest = float(abs(step / self._unit).max())
        if longest < CLOSE:
            return self._feasible(q + step, tolerance, RETRACTIONS).q
        before, length = self._distance(q, guess), min(1.0, LONGEST / longest)
        for _ in range(HALVINGS):
            there = self._feasible(q + length * step, tolerance, RETRACTIONS)
            if there.ok and self._distance(there.q, guess) <= before + 0.1 * length * float(slope @ step):
                return there.q
            length /= 2
        return None

    def _direction(self, q: Array, J: csr_array, lam: Array, slope: Array) -> Array:
        """Newton's step along the constraints, its curvature shifted until it goes downhill."""
        F = self.free
        J_F, H = csr_array(J[:, F]), csr_array(self.system.Phi_qT_lam_q(q, lam, self.t))[F][:, F]
        step, W = np.zeros(len(q)), csr_array(diags_array(self.weight[F]))
        for shift in SHIFTS:
            A = (1 + shift) * W + H
            try:
                step[F], _ = KKT(A, J_F, self.weight[F]).step(-slope[F], np.zeros(len(lam)))
            except SingularSystem:  # this shift meets an eigenvalue
                continue
            if step[F] @ A @ step[F] > 1e-3 * (step[F] @ W @ step[F]) and slope @ step < 0:
                return step
        step[F], _ = KKT(self.weight[F], J_F).step(-slope[F], np.zeros(len(lam)))
        return step

    def _distance(self, q: Array, guess: Array) -> float:
        return 0.5 * float(np.sum(self.weight * (q - guess) ** 2))
