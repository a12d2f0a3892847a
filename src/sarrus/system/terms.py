"""Sizes of the terms of the equations of motion before they cancel, and the errors of eigenvalues that follow."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ..algebra import Array
from ..linalg.eigenvalues import Eigenvalues, eigenvalues
from .system import System

RELATIVE = 1e-13  # error of every term of the equations of motion: some hundred operations


class Terms(NamedTuple):
    """Sizes of what M, D, K and the forces consist of, before the elements' contributions cancel, full (nq, nq)."""

    M: csr_array
    D: csr_array
    K: csr_array
    force: Array

    def eigenvalues(self, A: Array, M: Array, q_x: Array, v_x: Array, moving: int) -> Eigenvalues:
        """Return the eigenvalues of the equations ẋ = A x of small changes.

        Parameters
        ----------
        A : (nx, nx)
        M : (d, d) mass matrix along the free directions
        q_x, v_x : (nq, nx) changes of the coordinates and velocities by x, whose last d entries are rates and states
        moving : number of coordinates before those of states
        """
        rates = len(A) - len(M) + np.flatnonzero(~v_x[moving:, len(A) - len(M) :].any(axis=0))
        return eigenvalues(A, partial(self._errors, M, q_x, v_x), rates)

    def _errors(self, M: Array, q_x: Array, v_x: Array, s: Array, y: Array, x: Array) -> Array:
        """|y|ᵀ |δA| |x| for every pair of columns of s (k,), y and x (nx, k), with δA by small errors in M, D and K."""
        d = len(M)
        force = abs(v_x[:, -d:] @ np.linalg.solve(M.T, y[-d:]))
        shape, speed = abs(q_x @ x), abs(v_x @ x)
        change = self.K @ shape + self.D @ speed + self.M @ (abs(s) * speed)
        return np.asarray(RELATIVE * (force * change).sum(axis=0))


def terms_of(system: System, t: float, q: Array, v: Array, a: Array, lam: Array, b: Array) -> Terms:
    """The sizes of the terms at a state."""
    K = system.magnitude("Phi_qT_lam_q", q=q, lam=lam, t=t, b=b) + system.magnitude("Q_q", q=q, v=v, t=t, b=b)
    K = K + system.magnitude("M_a_q", q=q, a=a, b=b) + system.magnitude("S_q", q=q, v=v, b=b)
    D = system.magnitude("Q_v", q=q, v=v, t=t, b=b) + system.magnitude("S_v", q=q, v=v, b=b)
    M = system.magnitude("M", q=q, b=b)
    force = system.magnitude("Q", q=q, v=v, t=t, b=b) + system.magnitude("Phi_qT_lam", q=q, lam=lam, t=t, b=b)
    return Terms(M, D, K, force + system.magnitude("S", q=q, v=v, b=b) + M @ abs(a))
