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
    segments : for each operator in the order of BLOCKS, then Φ_q and Φ_qᵀ, the first number and the one behind the last
    places : for each number (those of Φ_q twice) its place in the factored arrangement
    """

    def __init__(self, system: System) -> None:
        self.n = system.nq + system.m
        parts = [_entries(system, name) for name in BLOCKS]
        rows, columns = _entries(system, "Phi_q")
        below, above = (rows + system.nq, columns), (columns, rows + system.nq)
        everywhere = [*parts, below, above]
        sizes = [len(r) for r, _ in everywhere]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        self.values = np.zeros(starts[-2])
        self.views = {
            name: self.values[starts[k] : starts[k + 1]] for k, name in enumerate((*BLOCKS, "Phi_q"))
        }
        self.segments = np.column_stack([starts[:-1], starts[1:]]).astype(np.int64)
        keys = np.concatenate([c * self.n + r for r, c in everywhere])
        unique, self._place = np.unique(keys, return_inverse=True)
        self.indices = (unique % self.n).astype(np.int64)
        self.indptr = np.searchsorted(unique // self.n, np.arange(self.n + 1)).astype(np.int64)
        self.weights = np.zeros(len(sizes))
        self.lu: Any = None

    def weigh(self, beta: float, gamma: float) -> Array:
        """The weights of the operators for a scheme's β' and γ'."""
        self.weights[:] = [1.0, beta, -beta, -gamma, -beta, -gamma, beta, 1.0, 1.0]
        return self.weights

    def assembled(self) -> Array:
        """The numbers of the matrix, by columns."""
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
        arranged = np.empty(len(self.indices), dtype=np.int64)
        arranged[self.lu.source] = np.arange(len(self.indices))
        self.places = arranged[self._place]
        self.data = np.zeros(len(self.indices))


def _entries(system: System, name: str) -> tuple[Array, Array]:
    """Rows and columns of an operator's numbers."""
    pattern = system.pattern(name)
    rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr)).astype(np.int64)
    return rows, pattern.indices.astype(np.int64)
