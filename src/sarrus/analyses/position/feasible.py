"""From rough coordinates onto the constraints: a globalised Gauss-Newton method for Jacobians of any rank."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.minimum_step import MinimumStep
from ...linalg.rank import divided
from ...system import System
from ..equations.length import lever, row_sizes, unit_displacement
from ..equations.projection.closure import allowed

FIRST_DAMPING = 1e-2  # of the largest diagonal entry, for a residual of 1
LARGEST_DAMPING = 1e8
GOOD, POOR = 0.75, 0.25  # parts of the predicted fall that change the damping
STALL = 1e-3  # the relative fall of |Φ| within `PATIENCE` steps that still counts as progress
PATIENCE = 8


@dataclass
class Reached:
    """Result of a search: q (nq,), Φ (m,), number of steps, and whether Φ is within the tolerance."""

    q: Array
    Phi: Array
    steps: int
    ok: bool

    @property
    def residual(self) -> float:
        """Largest entry of |Φ|."""
        return float(abs(self.Phi).max(initial=0.0))


class Feasible:
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
        self.system, self.inverse_weight, self.t = system, inverse_weight, t
        self.renormalized = Renormalization(inverse_weight)
        self.length = lever(system, system.q0, system.Phi_q(system.q0, t))
        self.unit = unit_displacement(system, system.q0)

    def __call__(self, q: Array, tolerance: float, iterations: int) -> Reached:
        """Search from q (nq,)."""
        at = self._at(self.renormalized(q), 0, tolerance)
        rows = row_sizes(self.system.Phi_q(at.q, self.t), self.unit)
        strength, history = FIRST_DAMPING, [np.inf]
        while not at.ok and at.steps < iterations and strength < LARGEST_DAMPING:
            at, strength = self._step(at, strength, tolerance, rows)
            history.append(float(np.linalg.norm(at.Phi / rows)))
            if len(history) > PATIENCE and history[-1] > (1 - STALL) * history[-1 - PATIENCE]:
                break
        return at

    def _at(self, q: Array, steps: int, tolerance: float) -> Reached:
        Phi, J = self.system.Phi(q, self.t), self.system.Phi_q(q, self.t)
        return Reached(q, Phi, steps, bool(np.all(abs(Phi) <= allowed(J, q, self.length, tolerance))))

    def _step(self, at: Reached, strength: float, tolerance: float, rows: Array) -> tuple[Reached, float]:
        """The next point: damped more and more until |Φ| falls; and the strength of the damping to go on with.

        Equations are divided by their sizes `rows`.
        """
        P, before = self.renormalized.tangent(at.q), at.Phi / rows
        size = float(before @ before)
        J = csr_array(self.system.Phi_q(at.q, self.t) @ P)
        step = MinimumStep(divided(J, rows), self.inverse_weight)
        while strength < LARGEST_DAMPING:
            change = P @ step(before, strength * step.scale * min(size, 1.0))
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


class Renormalization:
    """Brings Euler parameters back to unit length, except where one of them is held."""

    def __init__(self, inverse_weight: Array) -> None:
        self._free = np.all(inverse_weight.reshape(-1, 7)[:, 3:] > 0, axis=1)
        first = 7 * np.arange(len(self._free))[:, None, None] + np.arange(3, 7)
        rows, columns = np.broadcast_arrays(first.transpose(0, 2, 1), first)
        n = np.arange(len(inverse_weight))
        self._rows = np.concatenate([n, rows.reshape(-1)])
        self._columns = np.concatenate([n, columns.reshape(-1)])

    def __call__(self, q: Array) -> Array:
        """A copy of q (nq,) with unit Euler parameters; (1, 0, 0, 0) for those that vanish."""
        q = q.copy()
        p = q.reshape(-1, 7)[:, 3:]
        length = np.linalg.norm(p, axis=1)
        p[self._free & (length == 0)] = (1, 0, 0, 0)
        p[self._free & (length > 0)] /= length[self._free & (length > 0), None]
        return q

    def tangent(self, q: Array) -> csr_array:
        """The projection I - p pᵀ of every body's p, I where one of them is held (nq, nq)."""
        p = q.reshape(-1, 7)[:, 3:] * self._free[:, None]
        numbers = np.concatenate([np.ones(len(q)), -(p[:, :, None] * p[:, None, :]).reshape(-1)])
        return csr_array((numbers, (self._rows, self._columns)), shape=(len(q), len(q)))
