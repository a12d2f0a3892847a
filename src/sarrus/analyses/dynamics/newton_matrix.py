"""The matrix of an implicit step, on one pattern: [c M + β' (...)_q - γ' (...)_v, Φ_qᵀ; Φ_q, 0].

The numbers of all operators lie one after another in one array; each number knows its place in the matrix, so that
assembling is one pass: data[place] += weight of its operator x number.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array
from ...system import System
from ..linear import SparseLU

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
        self.n = system.nq + system.m
        parts = [_entries(system, name) for name in blocks]
        self.row_of, columns = _entries(system, "Phi_q")
        below, above = (self.row_of + system.nq, columns), (columns, self.row_of + system.nq)
        unit = np.arange(system.nq, self.n)
        everywhere = [*parts, (unit, unit), below, above]
        sizes = [len(r) for r, _ in everywhere]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        self.values = np.zeros(starts[-2])
        self.views = {
            name: self.values[starts[k] : starts[k + 1]]
            for k, name in enumerate((*blocks, "left_out", "Phi_q"))
        }
        self.segments = np.column_stack([starts[:-1], starts[1:]]).astype(np.int64)
        keys = np.concatenate([c * self.n + r for r, c in everywhere])
        unique, self._place = np.unique(keys, return_inverse=True)
        self.indices = (unique % self.n).astype(np.int64)
        self.indptr = np.searchsorted(unique // self.n, np.arange(self.n + 1)).astype(np.int64)
        self.weights = np.ones(len(sizes))
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


def _entries(system: System, name: str) -> tuple[Array, Array]:
    """Rows and columns of an operator's numbers."""
    pattern = system.pattern(name)
    rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr)).astype(np.int64)
    return rows, pattern.indices.astype(np.int64)
