"""The matrix of an implicit step, on one pattern: [c M + β' (...)_q - γ' (...)_v, Φ_qᵀ; Φ_q, 0].

The numbers of all operators lie one after another in one array; each number knows its place in the matrix, so that
assembling is one pass: data[place] += weight of its operator x number.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...system import System
from ..linear import SparseLU
from ..once import once

BLOCKS = ("M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "Phi_qT_lam_q")  # of the upper left block, then Φ_q twice


class NewtonMatrix:
    """Pattern, places and factors. Numbers are written into `views`, by operator.

    Attributes
    ----------
    values : numbers of all operators, one after another, Φ_q last; `views[name]` is an operator's part
    segments : for each operator in the order of BLOCKS, then the unit entries of equations left out, Φ_q and Φ_qᵀ: the
        first number and the one behind the last
    row_of : the equation that each number of Φ_q belongs to
    left_out : (m,) 1 for equations that are left out because others imply them, else 0: they become λ_k = 0
    places : for each number (those of Φ_q twice) its place in the factored arrangement
    """

    def __init__(self, system: System, kept: Array | None, blocks: tuple[str, ...] = BLOCKS) -> None:
        self.segments, self.row_of, self._place, self.indptr, self.indices = _layout(system, blocks)
        self.values = np.zeros(self.segments[-2, 1])
        names = (*blocks, "left_out", "Phi_q")
        self.views = {name: self.values[slice(*self.segments[k])] for k, name in enumerate(names)}
        self.weights = np.ones(len(self.segments))
        self.left_out = self.views["left_out"]
        self.keep(kept)
        self.lu: Any = None

    def keep(self, kept: Array | None) -> None:
        """Solve only the equations in these places of Φ (None: all)."""
        self.left_out[:] = 0 if kept is None else 1
        self.left_out[kept if kept is not None else []] = 0

    def weigh(self, beta: float, gamma: float) -> Array:
        """The weights of the operators for a scheme's β' and γ'."""
        self.weights[: len(BLOCKS)] = [1.0, beta, -beta, -gamma, -beta, -gamma, beta]
        return self.weights

    def assembled(self) -> Array:
        """The numbers of the matrix, by columns."""
        self.views["Phi_q"][self.left_out[self.row_of] > 0] = 0.0
        weights = np.repeat(self.weights, np.diff(self.segments, axis=1)[:, 0])
        values = np.concatenate([self.values, self.views["Phi_q"]])
        return np.bincount(self._place, weights=weights * values, minlength=len(self.indices))

    def choose_pivots(self) -> None:
        """Choose the pivot order for the numbers that are there now, and arrange the places for it."""
        data = self.assembled()
        if self.lu is None:
            self.lu = SparseLU(self.indptr, self.indices, data)
        else:
            self.lu.repivot(data)
        self._place_numbers()

    def _place_numbers(self) -> None:
        arranged = np.empty(len(self.indices), dtype=np.int64)
        arranged[self.lu.source] = np.arange(len(self.indices))
        self.places = arranged[self._place]
        self.data = np.zeros(len(self.indices))

    def state(self) -> dict[str, Array]:
        """Pivot order and factors; nothing before pivots are chosen."""
        names = ("row_place", "column_order", "factors")
        return {} if self.lu is None else {name: getattr(self.lu, name) for name in names}

    def resume(self, row_place: Array, column_order: Array, factors: Array) -> None:
        """Take over such a state."""
        self.lu = SparseLU.ordered(self.indptr, self.indices, row_place, column_order, factors)
        self._place_numbers()


class Layout(NamedTuple):
    """Where the numbers of the operators go; see `NewtonMatrix`."""

    segments: Array
    row_of: Array
    place: Array
    indptr: Array
    indices: Array


@once
def _layout(system: System, blocks: tuple[str, ...]) -> Layout:
    """Pattern and places, the same for all matrices of a system with these blocks."""
    n = system.nq + system.m
    row_of, columns = _entries(system, "Phi_q")
    below, above = (row_of + system.nq, columns), (columns, row_of + system.nq)
    unit = np.arange(system.nq, n)
    everywhere = [*(_entries(system, name) for name in blocks), (unit, unit), below, above]
    starts = np.concatenate([[0], np.cumsum([len(r) for r, _ in everywhere])])
    unique, place = np.unique(np.concatenate([c * n + r for r, c in everywhere]), return_inverse=True)
    indptr = np.searchsorted(unique // n, np.arange(n + 1)).astype(np.int64)
    segments = np.column_stack([starts[:-1], starts[1:]]).astype(np.int64)
    return Layout(segments, row_of, place, indptr, (unique % n).astype(np.int64))


def _entries(system: System, name: str) -> tuple[Array, Array]:
    """Rows and columns of an operator's numbers."""
    pattern = system.pattern(name)
    rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr)).astype(np.int64)
    return rows, pattern.indices.astype(np.int64)
