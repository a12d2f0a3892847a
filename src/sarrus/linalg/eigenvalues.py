"""Eigenvalues of first-order equations ẋ = A x, each with its round-off error from its condition number.

A perturbation δA changes a simple eigenvalue by yᴴ δA x / yᴴx, with its left and right vectors y and x. Errors in the
equations of motion are small parts of their terms before they cancel: that of a free motion, whose stiffness cancels,
is compared with what has cancelled, and not with the largest eigenvalue of the system.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, matrix_balance, qr

from ..algebra import Array

# Backward error of the eigenvalue solver, relative to the norm of its matrix
SOLVER = 20 * np.finfo(float).eps
PARALLEL = 1e-4  # between unit vectors: those of a double zero differ by the root of the errors


class Eigenvalues(NamedTuple):
    """Eigenvalues s (n,), 0 within their round-off (n,), with left and right vectors: yᴴ A = s yᴴ, A x = s x (n, n).

    `order` contains the places of the upper half of the plane: zeros, then others by rising |Im|, then falling Re.
    A double zero counts once, as one free motion: as many zeros are contained as have independent vectors.
    """

    s: Array
    left: Array
    right: Array
    round_off: Array
    order: Array


def eigenvalues(A: Array, of_terms: Callable[[Array, Array, Array], Array], rates: Array) -> Eigenvalues:
    """Return the eigenvalues of A in balanced coordinates.

    A multiple zero is found to a root of its errors only. The bound does not exceed that of a double one, so that an
    exactly double eigenvalue, as in critical damping, whose yᴴx is zero, is not taken for zero.

    Parameters
    ----------
    A : (n, n)
    of_terms : |y|ᵀ |δA| |x| for every pair of columns of s, y and x, with the errors δA of the terms of A
    rates : places in x of the rates of others, which are s times these
    """
    if not A.size:
        return Eigenvalues(np.zeros(0, dtype=complex), A, A, np.zeros(0), np.zeros(0, dtype=int))
    with np.errstate(invalid="ignore"):  # SciPy rounds all scales, of which 1e40 is no place
        balanced, (scale, order) = matrix_balance(A, separate=True)
    place = np.argsort(order)
    s, left, right = eig(balanced, left=True, right=True)
    y, x = (left / scale[:, None])[place], (right * scale[:, None])[place]
    norm = float(np.linalg.norm(balanced, 2))
    error = SOLVER * norm + of_terms(s, y, x)
    cosine = abs((left.conj() * right).sum(axis=0))
    with np.errstate(divide="ignore"):
        round_off = np.minimum(error / cosine, np.sqrt(error * norm))
    s = np.where(abs(s) <= round_off, 0.0, s)
    return Eigenvalues(s, y, x, round_off, _order(s, np.delete(right[place], rates, axis=0)))


def _order(s: Array, shapes: Array) -> Array:
    """The places of the upper half of the plane, for right vectors without rates, in balanced coordinates."""
    zeros, others = np.flatnonzero(s == 0), np.flatnonzero((s != 0) & (s.imag >= 0))
    if len(zeros):
        free = shapes[:, zeros] / np.linalg.norm(shapes[:, zeros], axis=0)
        triangle, pivots = qr(free, mode="r", pivoting=True)
        zeros = np.sort(zeros[pivots[: np.count_nonzero(abs(triangle.diagonal()) > PARALLEL)]])
    return np.concatenate([zeros, others[np.lexsort((-s[others].real, s[others].imag))]])
