"""The matrix [A Jᵀ; J 0] for a Jacobian J of any rank: its answer of least multipliers, by proximal refinement."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import LinearOperator, gmres

from .._jit.linking.link import link
from ..algebra import Array
from .factors import DENSE_BELOW, LUFactors
from .rank import DEPENDENT, row_lengths, with_data
from .sparse_lu import compressed

PROXIMAL = 1e-8  # the place of 0 is taken by -PROXIMAL, where J A⁻¹ Jᵀ has ones on its diagonal
REFINEMENTS = 12
EXACT_UP_TO = 1500  # rows and columns, for which these are computed
KRYLOV = 100  # iterations of GMRES for larger ones
SMALL = 4 * np.finfo(float).eps  # correction, relative, at which refinement ends


class KKT:
    """Solves A x + Jᵀ y = f, J x = g, factored once for any number of right sides; A is symmetric.

    With -δI in the place of 0 the matrix is regular whatever the rank of J, if A is positive on the null space of J.
    Refining the solution removes the effect of δ; y stays in the range of J, and is so the shortest of all multipliers,
    those of equations scaled to unit length in the metric. In that metric all is computed, so that no unit matters.

    Parameters
    ----------
    A : (n, n) by rows, or its diagonal (n,)
    J : (m, n)
    weight : (n,) diagonal of the metric; by default A
    """

    def __init__(self, A: Any, J: csr_array, weight: Array | None = None) -> None:
        matrix: csr_array = diagonal(A) if isinstance(A, np.ndarray) else A
        self._column = 1 / np.sqrt(matrix.diagonal() if weight is None else weight)
        self._row = 1 / row_lengths(_scaled(J, np.ones(J.shape[0]), self._column))
        self._A = _scaled(matrix, self._column, self._column)
        self._J = _scaled(J, self._row, self._column)
        self._JT = self._J.T
        self.n = J.shape[1]
        self._factors = LUFactors(self._matrix())

    def _matrix(self) -> Any:
        m, n = self._J.shape
        if m + n >= DENSE_BELOW:
            (i, j), (row, column), corner = _places(self._A), _places(self._J), np.arange(n, n + m)
            numbers = np.concatenate([self._A.data, self._J.data, self._J.data, np.full(m, -PROXIMAL)])
            rows, columns = (
                np.concatenate([i, n + row, column, corner]),
                np.concatenate([j, column, n + row, corner]),
            )
            indptr, indices, place = link(compressed)(n + m, rows.astype(np.int32), columns.astype(np.int32))
            data = np.zeros(len(indices))
            data[place] = numbers
            return csc_array((data, indices, indptr), shape=(n + m, n + m))
        matrix = np.zeros((n + m, n + m))
        matrix[:n, :n], matrix[n:, :n] = self._A.toarray(), self._J.toarray()
        matrix[:n, n:] = matrix[n:, :n].T
        matrix[range(n, n + m), range(n, n + m)] = -PROXIMAL
        return matrix

    def step(self, f: Array, g: Array) -> tuple[Array, Array]:
        """x and y without refinement, for the directions of iterations."""
        x, y = self._step(_times(self._column, f), _times(self._row, g))
        return _times(self._column, x), _times(self._row, y)

    def solve(self, f: Array, g: Array) -> tuple[Array, Array]:
        """x and y (n,), (m,), or one column for each of f and g (n, k), (m, k).

        Where g is not in the range of J, J x is as near to g as can be reached.
        """
        x, y = self._refined(_times(self._column, f), _times(self._row, g))
        return _times(self._column, x), _times(self._row, y)

    def _step(self, f: Array, g: Array) -> tuple[Array, Array]:
        found = self._factors.solve(np.concatenate([f, g]))
        return found[: self.n], found[self.n :]

    def _refined(self, f: Array, g: Array) -> tuple[Array, Array]:
        x, y = self._step(f, g)
        size, before = float(abs(x).max(initial=0.0)), math.inf
        for left in reversed(range(REFINEMENTS)):
            dx, dy = self._step(f - self._A @ x - self._JT @ y, g - self._J @ x)
            change = float(abs(dx).max(initial=0.0))
            if change >= before:
                break
            rate = change / before
            x, y, before = x + dx, y + dy, change
            # corrections are sums of geometric series, so that they do not begin to fall faster
            if change <= SMALL * size or change * rate**left > DEPENDENT * size:
                break
        if before <= DEPENDENT * size:
            return x, y
        return (
            self._exact(f, g) if self._J.shape[0] + self.n <= EXACT_UP_TO else self._accelerated(f, g, x, y)
        )

    def _accelerated(self, f: Array, g: Array, x: Array, y: Array) -> tuple[Array, Array]:
        """Go on from x and y by GMRES (Saad and Schultz 1986), with these factors as preconditioner.

        It needs one iteration for each small singular value, where refinement needs 1 + δ/σ² rounds for each digit.
        """
        size = self.n + self._J.shape[0]

        def times(z: Array) -> Array:
            return np.concatenate([self._A @ z[: self.n] + self._JT @ z[self.n :], self._J @ z[: self.n]])

        matrix = LinearOperator((size, size), times)
        factors = LinearOperator((size, size), self._factors.solve)
        right, found = np.concatenate([f, g]).reshape(size, -1), np.concatenate([x, y]).reshape(size, -1)
        for column, b in zip(found.T, right.T, strict=True):
            z, _ = gmres(matrix, b, column, rtol=SMALL, restart=KRYLOV, maxiter=1, M=factors)
            if np.linalg.norm(b - times(z)) < np.linalg.norm(b - times(column)):
                column[:] = z
        return found[: self.n].reshape(f.shape), found[self.n :].reshape(g.shape)

    def _exact(self, f: Array, g: Array) -> tuple[Array, Array]:
        """Solve by singular values, if small nonzero ones make refinement slow."""
        left, sizes, right = self._singular_values
        rank = int(np.count_nonzero(sizes > DEPENDENT * sizes.max(initial=0.0)))
        left, along, Z = left[:, :rank], right[:rank].T, right[rank:].T
        x = along @ _times(1 / sizes[:rank], left.T @ g)
        x = x + Z @ np.linalg.solve(Z.T @ (self._A @ Z), Z.T @ (f - self._A @ x))
        return x, left @ _times(1 / sizes[:rank], along.T @ (f - self._A @ x))

    @cached_property
    def _singular_values(self) -> tuple[Array, Array, Array]:
        left, sizes, right = np.linalg.svd(self._J.toarray(), full_matrices=True)
        return left, sizes, right


def _times(factors: Array, columns: Array) -> Array:
    return np.asarray((factors * columns.T).T)


def _scaled(matrix: csr_array, rows: Array, columns: Array) -> csr_array:
    i, j = _places(matrix)
    return with_data(matrix, rows[i] * matrix.data * columns[j])


def diagonal(weight: Array) -> csr_array:
    """The matrix (n, n) with this diagonal."""
    n = len(weight)
    return csr_array((weight, np.arange(n), np.arange(n + 1)), shape=(n, n))


def _places(matrix: csr_array) -> tuple[Array, Array]:
    """Rows and columns of the numbers."""
    return np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr)), matrix.indices
