"""Multipliers of minimum norm, where constraints are redundant: the one answer that runs report and derivatives have.

Φ_qᵀλ fixes λ up to the left null space of Φ_q. Of all λ with the same constraint forces the reported one has the least
Σ λ_k² over all equations, in their own units: λ - N Nᵀλ, with an orthonormal basis N of that null space.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.factors import DENSE_BELOW
from ...system import System
from .minimum_norm_loop import LeftOut
from .saddle_point import Saddle


class MinimumNorm:
    """The left null space of Φ_q at one position after another, for one choice of independent equations.

    Parameters
    ----------
    system : System
    rows : places in Φ of independent equations

    Attributes
    ----------
    dropped : places of the others
    """

    def __init__(self, system: System, rows: Array) -> None:
        self._nq, self._m = system.nq, system.m
        self._saddle = Saddle(system, "I", rows)
        self.dropped = np.setdiff1d(np.arange(system.m), rows)
        self._small = system.nq < DENSE_BELOW

    def combinations(self, J: csr_array) -> Array:
        """For every equation left out, itself less what it follows from (m, k): nᵀΦ_q = 0.

        Raises
        ------
        SingularSystem
            If the equations chosen are dependent there.
        """
        self._saddle.factor(np.ones(self._nq), J.data)
        found = -self.forces(J.toarray()[self.dropped].T if self._small else J[self.dropped].toarray().T)
        found[self.dropped, np.arange(len(self.dropped))] = 1
        return found

    def null(self, J: csr_array) -> Array:
        """An orthonormal basis (m, k) of the left null space; what follows is at the same position."""
        return np.asarray(qr(self.combinations(J), mode="economic")[0])

    def forces(self, f: Array) -> Array:
        """Multipliers of the equations chosen whose constraint forces come nearest to f, (nq, k) -> (m, k)."""
        return self._saddle.solve(f, np.zeros((self._m, f.shape[1])))[1]

    def motions(self, g: Array) -> Array:
        """The least ξ with Φ_q ξ = g in the equations chosen, (m, k) -> (nq, k)."""
        return self._saddle.solve(np.zeros((self._nq, g.shape[1])), g)[0]


def shortest(lam: Array, null: Array) -> Array:
    """The part of multipliers (m,) or (m, k) that is across the left null space."""
    return np.asarray(lam - null @ (null.T @ lam))


def multipliers_of(system: System, rows: Array, lam: Array, q: Array, t: float, b: Array) -> Array:
    """The multipliers (m,) of independent equations, at places `rows`, with the constraint forces of `lam` (m,)."""
    J = system.Phi_q(q, t, b=b)
    minimum = MinimumNorm(system, rows)
    minimum.null(J)
    return minimum.forces((J.T @ lam)[:, None])[:, 0]


def left_out(system: System, rows: Array | None) -> LeftOut:
    """The equations that are not among the independent `rows` (None: all are), for compiled code."""
    others = np.delete(np.arange(system.m), slice(None) if rows is None else rows)
    pattern, whole = system.pattern("Phi_q"), np.int64
    numbers = np.zeros(pattern.size), np.zeros((len(others), system.m))
    return LeftOut(others, pattern.indptr.astype(whole), pattern.indices.astype(whole), *numbers)
