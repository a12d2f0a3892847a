"""Factors of a square matrix, dense or sparse: solutions with it and its transpose."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from ..algebra import Array

DENSE_BELOW = 150  # unknowns, where LAPACK is faster than sparse factors


class SingularSystem(ArithmeticError):
    """A matrix has no inverse: constraints are dependent, or a body has no inertia along a free direction."""


class LUFactors:
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
            return self._dense_solve(right, 0)
        return np.asarray(self._factors.solve(right))

    def transposed(self, right: Array) -> Array:
        """x of Aᵀ x = right (n,)."""
        if self._dense:
            return self._dense_solve(right, 1)
        return np.asarray(self._factors.solve(right, "T"))

    def _dense_solve(self, right: Array, transposed: int) -> Array:
        """Solve by LAPACK directly, which is five times as fast as SciPy's functions for ten unknowns."""
        if not right.size:
            return np.zeros(right.shape)
        return np.asarray(dgetrs(*self._factors, right, trans=transposed)[0])


def _lapack(matrix: Array) -> Any:
    if not matrix.size:
        return matrix, np.zeros(0, dtype=np.int64)
    factors = dgetrf(matrix)[:2]
    pivots = factors[0].diagonal()
    if not np.all(np.isfinite(pivots) & (pivots != 0)):
        raise SingularSystem("the equations are dependent there")
    return factors


def _superlu(matrix: Any) -> Any:
    try:
        return splu(csc_array(matrix))
    except RuntimeError as error:
        raise SingularSystem(str(error)) from None
