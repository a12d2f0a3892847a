"""Linear systems with the constraint Jacobian: [W Φ_qᵀ; Φ_q 0] [x; y] = [f; g]."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csc_array

from ...algebra import Array
from ...linalg.factors import DENSE_BELOW, Factored, SingularSystem
from ...linalg.sparse_solver import SingularMatrix, SparseLU
from ...system import System
from ...system.cached import once_alike


class Saddle:
    """The matrix [W Φ_qᵀ; Φ_q 0] for W = M ("M") or the identity ("I"), its pattern made once.

    Masses are divided by a power of two near the largest: pivots would else be chosen by their unit.

    Where constraints are redundant, `rows` are the places in Φ of independent ones; the multipliers of the others are
    0.
    """

    def __init__(self, system: System, weight: str, rows: Array | None = None) -> None:
        self._independent = np.arange(system.m) if rows is None else rows
        self.nq, self.m, self._all = system.nq, len(self._independent), system.m
        found = _all_independent(system, weight) if rows is None else _places_in(system, weight, rows)
        self._rows, self._columns, self._used = found
        size = self.nq + self.m
        if size < DENSE_BELOW:
            self._dense: Array | None = np.zeros((size, size))
        else:
            self._dense = None
            numbered = csc_array(
                (np.arange(len(self._rows)) + 1.0, (self._rows, self._columns)), shape=(size, size)
            )
            self._order = numbered.data.astype(np.int64) - 1
            self._indptr, self._indices = (x.astype(np.int64) for x in (numbered.indptr, numbered.indices))
        self._factors: Any = None
        self._unit = 1.0

    def factor(self, W: Array, Phi_q: Array) -> None:
        """Factor the matrix of the numbers of W and Φ_q.

        Raises
        ------
        SingularSystem
            If it cannot be factored.
        """
        self._unit = _power_of_two(W)
        numbers = np.concatenate([W / self._unit, Phi_q[self._used], Phi_q[self._used]])
        if self._dense is not None:
            self._dense[self._rows, self._columns] = numbers
            self._factors = Factored(self._dense)
            return
        self._factor_sparse(numbers[self._order])

    def _factor_sparse(self, data: Array) -> None:
        try:
            if self._factors is None:
                self._factors = SparseLU(self._indptr, self._indices, data)
            else:
                self._factors.factor(data)
        except SingularMatrix as error:
            self._factors = None
            raise SingularSystem(str(error)) from None

    def solve(self, f: Array, g: Array) -> tuple[Array, Array]:
        """x (nq,) and y (m,) for the right side f, g, or a column of both for each of theirs."""
        right = np.concatenate([f / self._unit, g[self._independent]])
        solution = self._solved(right)
        if not np.all(np.isfinite(solution)):
            raise SingularSystem("the matrix is singular to working precision")
        y = np.zeros((self._all, *f.shape[1:]))
        y[self._independent] = self._unit * solution[self.nq :]
        return solution[: self.nq], y

    def _solved(self, right: Array) -> Array:
        if self._dense is not None or right.ndim == 1:
            return np.asarray(self._factors.solve(right))
        return np.array([self._factors.solve(column) for column in right.T]).reshape(right.T.shape).T


def _power_of_two(W: Array) -> float:
    """The largest one that is not above |W|; 1 for zeros."""
    return float(2.0 ** (np.frexp(abs(W).max(initial=0.0))[1] - 1)) if np.any(W) else 1.0


def _places_in(system: System, weight: str, independent: Array) -> tuple[Array, Array, Array]:
    """Row and column of each number in the matrix, and which numbers of Φ_q there are."""
    rows, columns = _places(system.pattern("Phi_q"))
    used = np.isin(rows, independent)
    rows, columns = np.searchsorted(independent, rows[used]) + system.nq, columns[used]
    both = _places(system.pattern("M")) if weight == "M" else (np.arange(system.nq),) * 2
    return np.concatenate([both[0], columns, rows]), np.concatenate([both[1], rows, columns]), used


@once_alike
def _all_independent(system: System, weight: str) -> tuple[Array, Array, Array]:
    return _places_in(system, weight, np.arange(system.m))


def _places(pattern: Any) -> tuple[Array, Array]:
    rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr))
    return rows, pattern.indices.astype(np.int64)
