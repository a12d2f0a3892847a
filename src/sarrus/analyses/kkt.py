"""The matrix [A Jᵀ; J 0] for a Jacobian J of any rank: its answer of least multipliers, by proximal refinement."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array

from ..algebra import Array
from .factored import DENSE_BELOW, Factored
from .linear import compiled

PROXIMAL = 1e-8  # the place of 0 is taken by -PROXIMAL times the scale of J A⁻¹ Jᵀ
REFINEMENTS = 12
SMALL = 1e-15  # correction, relative, at which refinement ends


class KKT:
    """Solves A x + Jᵀ y = f, J x = g, factored once for any number of right sides; A is symmetric.

    With -δI in the place of 0 the matrix is regular whatever the rank of J, if A is positive on the null space of J.
    Refining the solution removes the effect of δ; y stays in the range of J, and is so the shortest of all multipliers.

    Parameters
    ----------
    A : (n, n) by rows, or its diagonal (n,)
    J : (m, n)
    """

    def __init__(self, A: Any, J: csr_array) -> None:
        self._A: csr_array = diagonal(A) if isinstance(A, np.ndarray) else A
        self._J, self._JT = J, J.T
        self.n = J.shape[1]
        self._delta = PROXIMAL * _scale(self._A, J)
        self._factors = Factored(self._matrix())

    def _matrix(self) -> Any:
        m, n = self._J.shape
        if m + n >= DENSE_BELOW:
            (i, j), (row, column), corner = _places(self._A), _places(self._J), np.arange(n, n + m)
            numbers = np.concatenate([self._A.data, self._J.data, self._J.data, np.full(m, -self._delta)])
            rows, columns = (
                np.concatenate([i, n + row, column, corner]),
                np.concatenate([j, column, n + row, corner]),
            )
            indptr, indices, place = compiled()["compressed"](
                n + m, rows.astype(np.int32), columns.astype(np.int32)
            )
            data = np.zeros(len(indices))
            data[place] = numbers
            return csc_array((data, indices, indptr), shape=(n + m, n + m))
        matrix = np.zeros((n + m, n + m))
        matrix[:n, :n], matrix[n:, :n] = self._A.toarray(), self._J.toarray()
        matrix[:n, n:] = matrix[n:, :n].T
        matrix[range(n, n + m), range(n, n + m)] = -self._delta
        return matrix

    def step(self, f: Array, g: Array) -> tuple[Array, Array]:
        """x and y without refinement, for the directions of iterations."""
        found = self._factors.solve(np.concatenate([f, g]))
        return found[: self.n], found[self.n :]

    def solve(self, f: Array, g: Array) -> tuple[Array, Array]:
        """x and y (n,), (m,), or one column for each of f and g (n, k), (m, k).

        Where g is not in the range of J, J x is as near to g as can be reached; see `gap`.
        """
        x, y = self.step(f, g)
        size, before = abs(x).max(initial=0.0), np.inf
        for _ in range(REFINEMENTS):
            dx, dy = self.step(f - self._A @ x - self._JT @ y, g - self._J @ x)
            change = abs(dx).max(initial=0.0)
            if change >= before:
                break
            x, y, before = x + dx, y + dy, change
            if change <= SMALL * size:
                break
        return x, y

    def gap(self, x: Array, g: Array) -> float:
        """Largest entry of |J x - g|: not round-off where no x exists."""
        return float(abs(self._J @ x - g).max(initial=0.0))


def _scale(A: csr_array, J: csr_array) -> float:
    weight = np.maximum(abs(A.diagonal()), 1e-300)
    weight = np.maximum(weight, 1e-6 * weight.max(initial=0.0))
    squares = csr_array((J.data**2, J.indices, J.indptr), shape=J.shape)
    return float((squares @ (1 / weight)).max(initial=0.0)) or 1.0


def diagonal(weight: Array) -> csr_array:
    """The matrix (n, n) with this diagonal."""
    n = len(weight)
    return csr_array((weight, np.arange(n), np.arange(n + 1)), shape=(n, n))


def _places(matrix: csr_array) -> tuple[Array, Array]:
    """Rows and columns of the numbers."""
    return np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr)), matrix.indices
