"""Sparse linear systems that are solved many times with one pattern: analysed once, then factored by compiled code."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching
from scipy.sparse.linalg import splu

from .._jit.linking.link import link
from ..algebra import Array
from . import pivot_order, sparse_lu
from .factors import SingularSystem
from .pivot_order import LARGE
from .rank import DEPENDENT

LEAST = (0.2, 0.05, 0.01, 1e-4, 1e-8, 0.0)  # diagonal entries that are tried for, relative to row and column
SMALL = 3000  # unknowns, up to which pivots are chosen by Markowitz's rule: its search is quadratic
SPARSE = 2.0  # factors as a multiple of the matrix: where they are smaller, no other ordering is tried


class SingularMatrix(SingularSystem):
    """The matrix has no inverse."""


class SparseLU:
    """LU factors of matrices with one pattern (CSC): `factor`, `solve`, `solve_transposed`.

    Parameters
    ----------
    indptr, indices : the pattern by columns, rows rising
    data : the numbers of a typical matrix, real or complex, from which the pivot order is chosen

    Attributes
    ----------
    row_place, column_order, pointers, rows, diagonal, factors : see `sparse_lu`
    slots : where in `factors` each number of the matrix is written before it is factored

    Raises
    ------
    SingularMatrix
        If that matrix is singular.
    """

    def __init__(self, indptr: Array, indices: Array, data: Array) -> None:
        self.n = len(indptr) - 1
        self._indptr, self._indices = (x.astype(np.int32, copy=False) for x in (indptr, indices))
        self.repivot(data)

    def repivot(self, data: Array) -> None:
        """Choose the pivot order anew for these numbers, and factor them."""
        self._arrange(*self._order(data))
        self.factors = np.zeros(len(self.rows), data.dtype)
        if not self._refactor(data) > 0.0:
            raise SingularMatrix("the matrix is singular to working precision")

    @classmethod
    def ordered(
        cls,
        indptr: Array,
        indices: Array,
        row_place: Array,
        column_order: Array,
        factors: Array | None = None,
    ) -> SparseLU:
        """With a pivot order and factors that were found before; or with memory for real ones."""
        made = cls.__new__(cls)
        made.n, made._indptr, made._indices = len(indptr) - 1, indptr, indices
        made._arrange(row_place, column_order)
        made.factors = np.zeros(len(made.rows)) if factors is None else factors.copy()
        return made

    def _arrange(self, row_place: Array, column_order: Array) -> None:
        """The pattern of the factors in a pivot order."""
        self.row_place, self.column_order = (x.astype(np.uint32) for x in (row_place, column_order))
        given = (self.n, self._indptr, self._indices, self.row_place, self.column_order)
        self.pointers, self.rows, self.diagonal = link(sparse_lu.symbolic)(*given)
        self.slots = link(sparse_lu.slots)(*given, self.pointers, self.rows)

    def _order(self, data: Array) -> tuple[Array, Array]:
        """Row places and column order: of small matrices by Markowitz's rule, else of the sparsest of some."""
        known = self._by_markowitz(data) if self.n <= SMALL else None
        if known:
            return known
        found = list(self._candidates(data))
        places, columns, _ = min(found, key=lambda candidate: candidate[2])
        to = link(sparse_lu.postorder)(self.n, self._indptr, self._indices, places, columns)
        return to[places], columns[np.argsort(to)]

    def _by_markowitz(self, data: Array) -> tuple[Array, Array] | None:
        """None where the factors would be dense."""
        places, columns = np.empty(self.n, np.int32), np.empty(self.n, np.int32)
        for longest in pivot_order.LONGEST:
            given = self._indptr, self._indices, data, places, columns, min(self.n, longest)
            outcome = link(pivot_order.order)(*given)
            if outcome == pivot_order.SINGULAR:
                raise SingularMatrix("the matrix is singular to working precision")
            if outcome == pivot_order.FOUND:
                return places, columns
        return None

    def _candidates(self, data: Array) -> Iterator[tuple[Array, Array, int]]:
        """Row places, column order and size of the factors: with rows permuted for a large diagonal, and as it is.

        Where pivots can stay on the diagonal, a symmetric ordering keeps its promise; of the matrix as it is, with
        zeros on the diagonal, it would fill a long chain.
        """
        whole = csc_array((data, self._indices, self._indptr), shape=(self.n, self.n))
        to = _large_diagonal(whole)
        if to is None:
            raise SingularMatrix("the matrix is singular, whatever its numbers")
        permuted = csc_array((data.copy(), to[self._indices], self._indptr), shape=whole.shape)
        permuted.sort_indices()
        lu = _superlu(permuted, "MMD_AT_PLUS_A", symmetric=True)
        yield lu.perm_r[to], np.argsort(lu.perm_c).astype(np.int32), lu.nnz
        if lu.nnz > SPARSE * len(data):
            lu = _superlu(whole, "COLAMD", symmetric=False)
            yield lu.perm_r, np.argsort(lu.perm_c).astype(np.int32), lu.nnz

    def _refactor(self, data: Array) -> float:
        self.factors[:] = 0.0
        self.factors[self.slots] = data
        self.work = np.empty(self.n, self.factors.dtype)
        return float(
            link(sparse_lu.refactor)(
                self.pointers, self.rows, self.diagonal, self.factors, self.work, np.ones(self.n)
            )
        )

    def factor(self, data: Array) -> None:
        """Factor a matrix with these numbers, with new pivots if the old ones no longer fit.

        Raises
        ------
        SingularMatrix
            If it is singular.
        """
        if not self._refactor(data) > DEPENDENT:
            self.repivot(data)

    def solve(self, right: Array) -> Array:
        """x of A x = right."""
        x = np.empty(self.n, self.factors.dtype)
        x[self.row_place] = right
        link(sparse_lu.solve)(self.pointers, self.rows, self.diagonal, self.factors, x)
        result = np.empty(self.n, self.factors.dtype)
        result[self.column_order] = x
        return result

    def solve_transposed(self, right: Array) -> Array:
        """x of Aᵀ x = right."""
        x = right[self.column_order].astype(self.factors.dtype)
        link(sparse_lu.solve_transposed)(self.pointers, self.rows, self.diagonal, self.factors, x)
        return x[self.row_place]


def _superlu(matrix: csc_array, ordering: str, symmetric: bool) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            options = {"SymmetricMode": symmetric}
            return splu(matrix, permc_spec=ordering, diag_pivot_thresh=LARGE, options=options)
        except RuntimeError as error:
            raise SingularMatrix(str(error)) from None


def _large_diagonal(matrix: csc_array) -> Array | None:
    """Return a row permutation that nearly maximizes the smallest diagonal entry, with both scaled to 1.

    None where the matrix is singular, whatever its numbers.
    """
    rows = csr_array(abs(matrix))
    rows.eliminate_zeros()
    in_row, in_column = rows.max(axis=1).toarray(), rows.max(axis=0).toarray()
    size = rows.data / np.sqrt(np.repeat(in_row, np.diff(rows.indptr)) * in_column[rows.indices])
    for least in LEAST:
        numbers = np.where(size >= least, size, 0.0)
        large = csr_array((numbers, rows.indices, rows.indptr), shape=rows.shape, copy=True)
        large.eliminate_zeros()
        to: Array = maximum_bipartite_matching(large, perm_type="column")
        if np.all(to >= 0):
            return to
    return None
