"""Positions that satisfy the constraints: a feasible one, then the nearest, q = argmin ½ (q - q₀)ᵀ W (q - q₀)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array

from ...algebra import Array
from ...linalg.factors import SingularSystem
from ...linalg.kkt import FLOOR, KKT
from ...system import System
from ...system.cached import once
from ...system.layout import Layout
from ..equations.length import lever, row_sizes, unit_displacement
from ..equations.projection import allowed

FIRST_DAMPING = 1e-2  # of the largest diagonal entry, for a residual of 1
LARGEST_DAMPING = 1e8
GOOD, POOR = 0.75, 0.25  # parts of the predicted fall that change the damping
STALL = 1e-3  # the relative fall of |Φ| within `PATIENCE` steps that still counts as progress
PATIENCE = 8


@dataclass
class SearchEnd:
    """Result of a search: q (nq,), Φ (m,), number of steps, and whether Φ is within the tolerance."""

    q: Array
    Phi: Array
    steps: int
    ok: bool

    @property
    def residual(self) -> float:
        """Largest entry of |Φ|."""
        return float(abs(self.Phi).max(initial=0.0))


class FeasibleSearch:
    """Searches of one system from any number of starts, with some coordinates held.

    Steps are the damped steps of least size in the metric, along the spheres of the Euler parameters, which are brought
    back to unit length after every step. The damping is proportional to |Φ|², so that convergence stays quadratic where
    equations are dependent but consistent (Yamashita and Fukushima 2001).

    Parameters
    ----------
    system : System
    inverse_weight : (nq,) 1/w for every coordinate, zero for those that are held
    t : time [s]
    """

    def __init__(self, system: System, inverse_weight: Array, t: float = 0.0) -> None:
        self.system, self.t = system, t
        with np.errstate(divide="ignore"):
            self._weight = 1 / inverse_weight
        self.renormalized = Renormalization(system.layout, inverse_weight)
        self.length, self.unit = lengths_of(system, t)

    def __call__(self, q: Array, tolerance: float, iterations: int) -> SearchEnd:
        at = self._at(self.renormalized(q), 0, tolerance)
        rows = row_sizes(self.system.Phi_q(at.q, self.t), self.system.layout, self.unit)
        strength, history = FIRST_DAMPING, [np.inf]
        while not at.ok and at.steps < iterations and strength < LARGEST_DAMPING:
            at, strength = self._step(at, strength, tolerance, rows)
            history.append(float(np.linalg.norm(at.Phi / rows)))
            if len(history) > PATIENCE and history[-1] > (1 - STALL) * history[-1 - PATIENCE]:
                break
        return at

    def _at(self, q: Array, steps: int, tolerance: float) -> SearchEnd:
        Phi, J = self.system.Phi(q, self.t), self.system.Phi_q(q, self.t)
        limits = allowed(self.system.layout, J, q, self.length, tolerance)
        return SearchEnd(q, Phi, steps, bool(np.all(abs(Phi) <= limits)))

    def _step(self, at: SearchEnd, strength: float, tolerance: float, rows: Array) -> tuple[SearchEnd, float]:
        """The next point: damped more and more until |Φ| falls; and the strength of the damping to go on with.

        Equations are divided by their sizes `rows`.
        """
        P, before = self.renormalized.tangent(at.q), at.Phi / rows
        size = float(before @ before)
        J = csr_array(self.system.Phi_q(at.q, self.t) @ P)
        kkt, still = KKT(None, J, self._weight, rows), np.zeros(len(at.q))
        while strength < LARGEST_DAMPING:
            change = P @ kkt.step(still, -at.Phi, strength * min(size, 1.0) + FLOOR)[0]
            there = self._at(self.renormalized(at.q + change), at.steps + 1, tolerance)
            linear = (at.Phi + self.system.Phi_q_xi(at.q, change, self.t)) / rows
            fall = size - float(np.sum((there.Phi / rows) ** 2))
            ratio = fall / max(size - float(linear @ linear), np.finfo(float).tiny)
            if ratio > GOOD:
                strength = max(strength / 10, 1e-10)
            elif ratio < POOR:
                strength *= 4
            if ratio > 0:
                return there, strength
        return at, strength


@once
def lengths_of(system: System, t: float) -> tuple[float, float]:
    """Lever and unit displacement in the model's position."""
    return lever(system, system.q0, system.Phi_q(system.q0, t)), unit_displacement(system, system.q0)


class Renormalization:
    """Brings Euler parameters back to unit length, except where one of them is held."""

    def __init__(self, layout: Layout, inverse_weight: Array) -> None:
        self._places = layout.rotations
        self._free = np.all(inverse_weight[self._places] > 0, axis=1)
        rows, columns = np.broadcast_arrays(self._places[:, :, None], self._places[:, None])
        n = np.arange(len(inverse_weight))
        self._rows = np.concatenate([n, rows.reshape(-1)])
        self._columns = np.concatenate([n, columns.reshape(-1)])

    def __call__(self, q: Array) -> Array:
        """A copy of q (nq,) with unit Euler parameters; (1, 0, 0, 0) for those that vanish."""
        q, p = q.copy(), q[self._places]
        length = np.linalg.norm(p, axis=1)
        p[self._free & (length == 0)] = (1, 0, 0, 0)
        p[self._free & (length > 0)] /= length[self._free & (length > 0), None]
        q[self._places] = p
        return q

    def tangent(self, q: Array) -> csr_array:
        """The projection I - p pᵀ of every body's p, I where one of them is held (nq, nq)."""
        p = q[self._places] * self._free[:, None]
        numbers = np.concatenate([np.ones(len(q)), -(p[:, :, None] * p[:, None, :]).reshape(-1)])
        return csr_array((numbers, (self._rows, self._columns)), shape=(len(q), len(q)))


STATIONARY = 1e-12  # of the gradient along the constraints, relative to W (q - q₀)
ITERATIONS = 60
SHIFTS = (0.0, 0.3, 1.0, 3.0, 10.0)  # times W, added until the step goes downhill
HALVINGS = 12
CLOSE = 1e-5  # a step so short that round-off hides how the distance falls, and that needs no such test
LITTLE = 1e-3  # a change, in parts of the system's length, whose gradient need not be smaller
LONGEST = 0.5  # largest entry of a step
RETRACTIONS = 12  # steps back onto the constraints


@dataclass(frozen=True)
class NearestPoint:
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
        self._is_free, self._feasible = free, FeasibleSearch(system, np.where(free, 1 / weight, 0.0), t)
        self._unit = system.layout.scales(self._feasible.length)
        self._heaviest = float((self._unit**2 * weight).max(initial=0.0))

    def __call__(self, q: Array, guess: Array, tolerance: float) -> NearestPoint:
        """Descend from q, on the constraints, towards the guess (both (nq,))."""
        for steps in range(ITERATIONS):
            J = self.system.Phi_q(q, self.t)
            lam, slope = self._multipliers(J, q - guess)
            size = np.linalg.norm(self._unit * self.weight * (q - guess))
            if np.linalg.norm(self._unit * slope) <= STATIONARY * (size + LITTLE * self._heaviest):
                return NearestPoint(q, lam, steps, True)
            there = self._descend(q, guess, J, lam, slope, tolerance)
            if there is None:
                return NearestPoint(q, lam, steps, False)
            q = there
        return NearestPoint(q, lam, ITERATIONS, False)

    def _multipliers(self, J: csr_array, change: Array) -> tuple[Array, Array]:
        """λ that makes W (q - q₀) + Φ_qᵀλ least in the metric, and this remainder."""
        kkt = KKT(None, J, np.where(self._is_free, self.weight, np.inf))
        lam = kkt.solve(-self.weight * change, np.zeros(J.shape[0]))[1]
        return lam, np.where(self._is_free, self.weight * change + J.T @ lam, 0.0)

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
        step[F], _ = KKT(None, J_F, self.weight[F]).step(-slope[F], np.zeros(len(lam)))
        return step

    def _distance(self, q: Array, guess: Array) -> float:
        return 0.5 * float(np.sum(self.weight * (q - guess) ** 2))
