"""Factors of a square matrix, dense or sparse as its size asks: solves with it and its transpose, its sign."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve
from scipy.sparse.linalg import splu

from ..algebra import Array

DENSE_BELOW = 150  # unknowns, where LAPACK is faster than sparse factors


class SingularSystem(ArithmeticError):
    """The constraints are dependent here, or a body has no inertia along a free direction."""


class Factored:
    """LU factors of a sparse matrix A (n, n).

    Parameters
    ----------
    A : sparse array, or a dense one (n, n)

    Raises
    ------
    SingularSystem
        If a pivot is exactly zero, or not a number.
    """

    def __init__(self, A: Any) -> None:
        self._dense = A.shape[0] < DENSE_BELOW
        matrix = A if isinstance(A, np.ndarray) or not self._dense else A.toarray()
        self._factors: Any = _lapack(matrix) if self._dense else _superlu(matrix)

    def solve(self, right: Array) -> Array:
        """x of A x = right (n,), or one column for each of right (n, k)."""
        if self._dense:
            return np.asarray(lu_solve(self._factors, right, check_finite=False))
        return np.asarray(self._factors.solve(right))

    def transposed(self, right: Array) -> Array:
        """x of Aᵀ x = right (n,)."""
        if self._dense:
            return np.asarray(lu_solve(self._factors, right, trans=1, check_finite=False))
        return np.asarray(self._factors.solve(right, "T"))

    @property
    def sign(self) -> float:
        """Of the determinant."""
        if self._dense:
            matrix, swaps = self._factors
            odd = np.count_nonzero(swaps != np.arange(len(swaps))) % 2
            return float(np.prod(np.sign(np.diag(matrix))) * (-1 if odd else 1))
        f = self._factors
        return float(np.prod(np.sign(f.U.diagonal())) * _parity(f.perm_r) * _parity(f.perm_c))


def _lapack(matrix: Array) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LinAlgWarning)
        factors = lu_factor(matrix, check_finite=False)
    pivots = np.diag(factors[0])
    if not np.all(np.isfinite(pivots) & (pivots != 0)):
        raise SingularSystem("the equations are dependent there")
    return factors


def _superlu(matrix: Any) -> Any:
    try:
        return splu(matrix.tocsc())
    except RuntimeError as trouble:
        raise SingularSystem(str(trouble)) from None


def _parity(order: Array) -> int:
    """+1 for an even permutation, -1 for an odd one."""
    seen, swaps = np.zeros(len(order), dtype=bool), 0
    for first in range(len(order)):
        at = first
        while not seen[at]:
            seen[at], at = True, int(order[at])
            swaps += at != first
    return -1 if swaps % 2 else 1
