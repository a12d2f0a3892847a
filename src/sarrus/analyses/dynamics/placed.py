"""One sparse matrix in which the numbers of operators stand at several places, each with a weight: made on one pattern.

The numbers of all operators lie one after another in one array. A part is an operator at a place in the matrix; every
number of a part knows its place among the numbers of the matrix, so that assembling is one pass:
data[place] += weight of the part x number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_array

from ...algebra import Array
from ...system import System
from ..linear import SparseLU

ASSEMBLE: Any = None  # `assemble` and solvers, put in place when this is compiled
REFACTOR: Any = None
SOLVE: Any = None
UNIT, LEFT_OUT = (
    "unit",
    "left_out",
)  # diagonal blocks (nq, nq) of ones, and (m, m) with 1 for equations left out


class Part(NamedTuple):
    """An operator whose first number stands at a row and a column of the matrix, perhaps transposed."""

    name: str
    row: int
    column: int
    transposed: bool = False


class Placed(NamedTuple):
    """What compiled code needs to assemble and factor: see `assemble` and `linear.SparseLU`."""

    parts: Any
    places: Any
    weights: Any
    data: Any
    indptr: Any
    indices: Any
    pointers: Any
    rows: Any
    diagonal: Any
    factors: Any
    work: Any
    row_place: Any
    column_order: Any


class Numbers:
    """The numbers of operators, one array: `views[name]` is an operator's part of `values`.

    `like` names, for numbers of an operator at another state, the operator.
    """

    def __init__(self, system: System, names: Sequence[str], like: Mapping[str, str] | None = None) -> None:
        self.system, self._like = system, like or {}
        sizes = [len(self.entries(name)[0]) for name in names]
        ends = np.cumsum(sizes)
        self.values, self.start = np.zeros(ends[-1]), dict(zip(names, ends - sizes, strict=True))
        self.views = {
            n: self.values[end - size : end] for n, end, size in zip(names, ends, sizes, strict=True)
        }
        self.views[UNIT][:] = 1.0

    def entries(self, name: str) -> tuple[Array, Array]:
        """Rows and columns of an operator's numbers."""
        if name in (UNIT, LEFT_OUT):
            along = np.arange(self.system.nq if name == UNIT else self.system.m)
            return along, along
        pattern = self.system.pattern(self._like.get(name, name))
        rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr)).astype(np.int64)
        return rows, pattern.indices.astype(np.int64)


class PlacedMatrix:
    """The pattern of a matrix (n, n), and its factors; `kind` is the type of its weights, real or complex."""

    def __init__(self, numbers: Numbers, n: int, parts: Sequence[Part], kind: type = float) -> None:
        self._numbers, self.n = numbers, n
        entries = [self._entries(part) for part in parts]
        counts = [len(rows) for rows, _ in entries]
        keys = np.concatenate([columns * n + rows for rows, columns in entries])
        unique, self._place = np.unique(keys, return_inverse=True)
        self._indices = (unique % n).astype(np.int64)
        self._indptr = np.searchsorted(unique // n, np.arange(n + 1)).astype(np.int64)
        starts = [numbers.start[part.name] for part in parts]
        self.parts = np.column_stack([starts, counts, np.cumsum(counts) - counts]).astype(np.int64)
        self.weights: Array = np.ones(len(parts), dtype=kind)

    def _entries(self, part: Part) -> tuple[Array, Array]:
        rows, columns = self._numbers.entries(part.name)
        return (
            (columns + part.row, rows + part.column)
            if part.transposed
            else (rows + part.row, columns + part.column)
        )

    def assembled(self) -> Array:
        """The numbers of the matrix, by columns."""
        data = np.zeros(len(self._indices), dtype=self.weights.dtype)
        assemble(self.parts, self._place, self.weights, self._numbers.values, data)
        return data

    def pattern(self) -> csc_array:
        """1 wherever a number may stand (n, n)."""
        places = self._indices.astype(np.int32), self._indptr.astype(np.int32)
        return csc_array((np.ones(len(self._indices)), *places), shape=(self.n, self.n))

    def placed(self) -> Placed:
        """Choose the pivot order for the numbers and weights that are there now.

        Raises
        ------
        SingularMatrix
            If the matrix is singular.
        """
        return self._shown(SparseLU(self._indptr, self._indices, self.assembled()))

    def resumed(self, row_place: Array, column_order: Array, factors: Array, weights: Array) -> Placed:
        """With a pivot order and factors that were found before."""
        self.weights[:] = weights
        return self._shown(SparseLU.ordered(self._indptr, self._indices, row_place, column_order, factors))

    def _shown(self, lu: SparseLU) -> Placed:
        arranged = np.empty(len(self._indices), dtype=np.int64)
        arranged[lu.source] = np.arange(len(self._indices))
        return Placed(
            self.parts, arranged[self._place], self.weights, np.zeros_like(lu.factors, shape=len(self._indices)),
            lu.indptr, lu.indices, lu.pointers, lu.rows, lu.diagonal, lu.factors, lu.work, lu.row_place,
            lu.column_order,
        )  # fmt: skip


def assemble(parts: Any, places: Any, weights: Any, values: Any, data: Any) -> None:
    """Sum the weighted numbers of all parts into the numbers of the matrix."""
    data[:] = 0.0
    for s in range(len(parts)):
        for k in range(parts[s, 1]):
            data[places[parts[s, 2] + k]] += weights[s] * values[parts[s, 0] + k]


def refactor(values: Any, placed: Any) -> Any:
    """Assemble and factor a matrix; returns how far its pivots can be trusted."""
    ASSEMBLE(placed.parts, placed.places, placed.weights, values, placed.data)
    return REFACTOR(
        placed.pointers, placed.rows, placed.diagonal, placed.indptr, placed.indices, placed.data, placed.factors,
        placed.work,
    )  # fmt: skip


def backsolve(placed: Any, right: Any, solution: Any) -> None:
    """solution = matrix⁻¹ right."""
    work = placed.work
    for k in range(len(right)):
        work[placed.row_place[k]] = right[k]
    SOLVE(placed.pointers, placed.rows, placed.diagonal, placed.factors, work)
    for k in range(len(right)):
        solution[placed.column_order[k]] = work[k]
