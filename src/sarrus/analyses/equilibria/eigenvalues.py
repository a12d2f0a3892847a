"""Eigenvalues of the linearized equations, each with its round-off error from its condition number.

A perturbation δA changes a simple eigenvalue by yᴴ δA x / yᴴx, with its left and right vectors y and x. Errors in the
equations of motion are small parts of their terms before they cancel: that of a free motion, whose stiffness cancels,
is compared with what has cancelled, and not with the largest eigenvalue of the system.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, matrix_balance

from ...algebra import Array
from .linearization import Linear, Terms

RELATIVE = 1e-13  # error of every term of the equations of motion: some hundred operations
SOLVER = (
    20 * np.finfo(float).eps
)  # backward error of the eigenvalue solver, relative to the norm of its matrix


class Eigenvalues(NamedTuple):
    """Eigenvalues s (n,), right vectors as columns (n, n), and the round-off of each eigenvalue (n,)."""

    s: Array
    vectors: Array
    round_off: Array


def eigenvalues(linear: Linear, terms: Terms) -> Eigenvalues:
    """Return the eigenvalues of A in balanced coordinates.

    A multiple zero is found to a root of its errors only. The bound does not exceed that of a double one, so that an
    exactly double eigenvalue, as in critical damping, whose yᴴx is zero, is not taken for zero.
    """
    if not linear.A.size:
        return Eigenvalues(np.zeros(0, dtype=complex), linear.A, np.zeros(0))
    balanced, (scale, order) = matrix_balance(linear.A, separate=True)
    place = np.argsort(order)
    s, left, right = eig(balanced, left=True, right=True)
    norm = float(np.linalg.norm(balanced, 2))
    error = SOLVER * norm + _of_terms(
        linear, terms, s, (left / scale[:, None])[place], (right * scale[:, None])[place]
    )
    cosine = abs((left.conj() * right).sum(axis=0))
    with np.errstate(divide="ignore"):
        round_off = np.minimum(error / cosine, np.sqrt(error * norm))
    return Eigenvalues(s, (right * scale[:, None])[place], round_off)


def _of_terms(linear: Linear, terms: Terms, s: Array, y: Array, x: Array) -> Array:
    """|y|ᵀ |δA| |x| for every pair of columns, δA by small errors in M, D and K."""
    n = linear.Z.shape[1]
    force = abs(linear.W @ np.linalg.solve(linear.M.T, y[n:]))
    shape, speed = abs(linear.Z @ x[:n]), abs(linear.W @ x[n:] + linear.P @ x[:n])
    change = terms.K @ shape + terms.D @ speed + terms.M @ (abs(s) * speed)
    return np.asarray(RELATIVE * (force * change).sum(axis=0))
