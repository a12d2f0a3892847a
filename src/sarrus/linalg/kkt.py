"""The matrix [A Jᵀ; J 0] for a Jacobian J of any rank: its answer of least multipliers, by proximal refinement."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, gmres

from .._jit.linking.link import link
from ..algebra import Array
from .factors import DENSE_BELOW, LUFactors
from .rank import DEPENDENT, row_lengths, rows_of_entries, with_data
from .sparse_lu import compressed

PROXIMAL = 1e-8  # the place of 0 is taken by -PROXIMAL, where J A⁻¹ Jᵀ has ones on its diagonal
FLOOR = 16 * np.finfo(float).eps  # of the damping of a step: keeps J Jᵀ positive for dependent equations
REFINEMENTS = 12
EXACT_UP_TO = 1500  # rows and columns, for which these are computed
KRYLOV = 100  # iterations of GMRES for larger ones
SMALL = 4 * np.finfo(float).eps  # correction, relative, at which refinement ends


class KKT:
    """Solves A x + Jᵀ y = f, J x = g, factored once for any number of right sides.

    With -δI in the place of 0 the matrix is regular whatever the rank of J, if A is positive on the null space of J.
    Refining the solution removes the effect of δ; y stays in the range of J, and is so the shortest of all multipliers,
    those of scaled equations. All is computed in a metric, so that no unit matters. Where A is this metric, J A⁻¹ Jᵀ is
    factored instead.

    Parameters
    ----------
    A : (n, n) by rows, of any symmetry; None for the metric
    J : (m, n)
    weight : (n,) diagonal of the metric; infinite for coordinates that are held, where x is 0, if A is the metric
    rows : (m,) sizes of the equations, by which they are divided; by default their lengths in the metric
    """

    def __init__(self, A: csr_array | None, J: csr_array, weight: Array, rows: Array | None = None) -> None:
        (m, self.n), column = J.shape, 1 / np.sqrt(weight)
        whole = with_data(J, J.data * column[J.indices])
        self._column, self._row = column, 1 / (row_lengths(whole) if rows is None else rows)
        self._dense = m + (self.n if A is not None else 0) < DENSE_BELOW
        self._J: Any = _laid_out(whole, self._row, np.ones(self.n), self._dense)
        self._A: Any = None if A is None else _laid_out(A, column, column, self._dense)

    @cached_property
    def _factors(self) -> LUFactors:
        return LUFactors(self._matrix(PROXIMAL))

    def _matrix(self, damping: float) -> Any:
        """The matrix with damping, or its Schur complement J Jᵀ + δI if A is the metric."""
        m, n = self._J.shape
        if self._A is None:
            normal = self._J @ self._J.T
            damping *= float(normal.diagonal().max(initial=0.0)) or 1.0
            if not self._dense:
                return normal + damping * eye_array(m)
            normal.flat[:: m + 1] += damping
            return normal
        if self._dense:
            matrix = np.zeros((n + m, n + m))
            matrix[:n, :n], matrix[n:, :n], matrix[:n, n:] = self._A, self._J, self._J.T
            matrix[range(n, n + m), range(n, n + m)] = -damping
            return matrix
        (i, j), (row, column), corner = _places(self._A), _places(self._J), np.arange(n, n + m)
        numbers = np.concatenate([self._A.data, self._J.data, self._J.data, np.full(m, -damping)])
        rows, columns = (
            np.concatenate([i, n + row, column, corner]),
            np.concatenate([j, column, n + row, corner]),
        )
        indptr, indices, place = link(compressed)(n + m, rows.astype(np.int32), columns.astype(np.int32))
        data = np.zeros(len(indices))
        data[place] = numbers
        return csc_array((data, indices, indptr), shape=(n + m, n + m))

    def step(self, f: Array, g: Array, damping: float = PROXIMAL) -> tuple[Array, Array]:
        """x and y without refinement, for the directions of iterations.

        If A is the metric and f zero, x is the damped step of Levenberg and Marquardt; the damping is relative to the
        largest diagonal entry of J A⁻¹ Jᵀ.
        """
        factors = self._factors if damping == PROXIMAL else LUFactors(self._matrix(damping))
        return self._with_units(*self._step(*self._without_units(f, g), factors))

    def solve(self, f: Array, g: Array) -> tuple[Array, Array]:
        """x and y (n,), (m,), or one column for each of f and g (n, k), (m, k).

        Where g is not in the range of J, J x is as near to g as can be reached.
        """
        return self._with_units(*self._refined(*self._without_units(f, g), False))

    def solve_transposed(self, f: Array, g: Array) -> tuple[Array, Array]:
        """The same with Aᵀ in the place of A."""
        return self._with_units(*self._refined(*self._without_units(f, g), self._A is not None))

    def _without_units(self, f: Array, g: Array) -> tuple[Array, Array]:
        return _times(self._column, f), _times(self._row, g)

    _with_units = _without_units

    def _step(self, f: Array, g: Array, factors: LUFactors, transposed: bool = False) -> tuple[Array, Array]:
        if self._A is None:
            y = factors.solve(self._J @ f - g)
            return f - self._J.T @ y, y
        right = np.concatenate([f, g])
        found = factors.transposed(right) if transposed else factors.solve(right)
        return found[: self.n], found[self.n :]

    def _product(self, x: Array, y: Array, transposed: bool) -> tuple[Array, Array]:
        A = self._A.T if transposed else self._A
        return (x if A is None else A @ x) + self._J.T @ y, self._J @ x

    def _refined(self, f: Array, g: Array, transposed: bool) -> tuple[Array, Array]:
        x, y = self._step(f, g, self._factors, transposed)
        size, before = float(abs(x).max(initial=0.0)), math.inf
        for left in reversed(range(REFINEMENTS)):
            forces, rates = self._product(x, y, transposed)
            dx, dy = self._step(f - forces, g - rates, self._factors, transposed)
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
        small = self._J.shape[0] + self.n <= EXACT_UP_TO
        return self._exact(f, g, transposed) if small else self._accelerated(f, g, x, y, transposed)

    def _accelerated(self, f: Array, g: Array, x: Array, y: Array, transposed: bool) -> tuple[Array, Array]:
        """Go on from x and y by GMRES (Saad and Schultz 1986), with these factors as preconditioner.

        It needs one iteration for each small singular value, where refinement needs 1 + δ/σ² rounds for each digit.
        """
        n, size = self.n, self.n + self._J.shape[0]

        def times(z: Array) -> Array:
            return np.concatenate(self._product(z[:n], z[n:], transposed))

        def step(z: Array) -> Array:
            return np.concatenate(self._step(z[:n], z[n:], self._factors, transposed))

        matrix, factors = (LinearOperator((size, size), function) for function in (times, step))
        right, found = np.concatenate([f, g]).reshape(size, -1), np.concatenate([x, y]).reshape(size, -1)
        for column, b in zip(found.T, right.T, strict=True):
            z, _ = gmres(matrix, b, column, rtol=SMALL, restart=KRYLOV, maxiter=1, M=factors)
            if np.linalg.norm(b - times(z)) < np.linalg.norm(b - times(column)):
                column[:] = z
        return found[:n].reshape(f.shape), found[n:].reshape(g.shape)

    def _exact(self, f: Array, g: Array, transposed: bool) -> tuple[Array, Array]:
        """Solve by singular values, if small nonzero ones make refinement slow."""
        left, sizes, right = self._singular_values
        rank = int(np.count_nonzero(sizes > DEPENDENT * sizes.max(initial=0.0)))
        left, along, Z = left[:, :rank], right[:rank].T, right[rank:].T
        x, A = along @ _times(1 / sizes[:rank], left.T @ g), self._A.T if transposed else self._A
        if A is None:
            x = x + Z @ (Z.T @ f)
        else:
            x = x + Z @ np.linalg.solve(Z.T @ (A @ Z), Z.T @ (f - A @ x))
        return x, left @ _times(1 / sizes[:rank], along.T @ (f - (x if A is None else A @ x)))

    @cached_property
    def _singular_values(self) -> tuple[Array, Array, Array]:
        left, sizes, right = np.linalg.svd(self._J if self._dense else self._J.toarray(), full_matrices=True)
        return left, sizes, right


def diagonal(weight: Array) -> csr_array:
    """The matrix (n, n) with this diagonal."""
    n = len(weight)
    return csr_array((weight, np.arange(n), np.arange(n + 1)), shape=(n, n))


def _times(factors: Array, columns: Array) -> Array:
    return np.asarray((factors * columns.T).T)


def _laid_out(matrix: csr_array, rows: Array, columns: Array, dense: bool) -> Any:
    """A matrix with its rows and columns multiplied by factors, dense or by rows."""
    if dense:
        return rows[:, None] * matrix.toarray() * columns
    i, j = _places(matrix)
    return with_data(matrix, rows[i] * matrix.data * columns[j])


def _places(matrix: csr_array) -> tuple[Array, Array]:
    """Rows and columns of the numbers."""
    return rows_of_entries(matrix), matrix.indices
