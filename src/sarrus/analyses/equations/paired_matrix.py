"""The real and the complex matrix of stages that are split: one pattern, one order of pivots, one pass for both."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..._jit.linking.link import compiled, link
from ...algebra import Array
from ...linalg.pair_loop import FOUR, ONE, TWO, PairFactors, assemble_pairs, refactor_pairs, solve_pairs
from ...linalg.panel_loop import panel_ends
from ...linalg.sparse_solver import SingularMatrix
from .block_matrix import Assembler, PlacedMatrix

WIDTH = int(FOUR)  # numbers of an entry
STAGES: Any = np.uint64(3)  # those of a step that is split


class Pairs(NamedTuple):
    """What compiled code needs to assemble, factor and solve both matrices; see `block_matrix.Assembler`.

    weights : four numbers for each part: that of the real matrix, the parts of that of the complex one, and zero
    """

    parts: Array
    places: Array
    weights: Array
    lu: PairFactors
    row_place: Array
    column_order: Array


class PairedMatrix:
    """A complex matrix beside a real one with the same numbers of operators, and the factors of both.

    Parameters
    ----------
    real : the real matrix, whose pivots are taken if they suit both
    parts : as of the real one

    Attributes
    ----------
    complex : the complex matrix, with its weights
    placed : both as compiled code takes them, or None before pivots are chosen
    """

    def __init__(self, real: PlacedMatrix, parts: Any) -> None:
        self.real, self.complex = real, PlacedMatrix(real.numbers, real.n, parts, complex, real)
        self.placed: Pairs | None = None

    def factor(self, least: float) -> None:
        """Factor both; with pivots chosen for the complex matrix, if those of the real one can be trusted less.

        Raises
        ------
        SingularMatrix
            If one is singular.
        """
        self.placed = first = self._in_order(self.real.factor(least))
        trust = self._refactor()
        if trust > least:
            return
        self.placed = self._in_order(self.complex.choose_pivots())
        if self._refactor() > trust:
            return
        self.placed = first
        if not self._refactor() > 0.0:
            raise SingularMatrix("the matrix is singular to working precision")

    def show(self) -> Pairs:
        """Both as compiled code takes them, with present weights."""
        assert self.placed is not None
        return self.placed

    def _refactor(self) -> float:
        placed = self.show()
        weights = placed.weights.reshape(-1, WIDTH)
        weights[:, 0], weights[:, 1], weights[:, 2] = (
            self.real.weights, self.complex.weights.real, self.complex.weights.imag
        )  # fmt: skip
        return float(link(renew_pairs)(self.real.numbers.values, placed))

    def _in_order(self, order: Assembler) -> Pairs:
        """With the pivots of another matrix of the same pattern."""
        unsigned = (np.asarray(x, np.uint64) for x in (order.pointers, order.rows, order.diagonal))
        ends = link(panel_ends)(*unsigned).astype(order.rows.dtype)
        pattern = order.pointers, order.rows, order.diagonal, ends, order.scale
        lu = PairFactors(*pattern, _aligned(len(order.rows)), _aligned(len(order.diagonal)))
        weights = _aligned(len(order.parts))
        return Pairs(order.parts, order.places, weights, lu, order.row_place, order.column_order)

    def state(self) -> dict[str, Array]:
        """Pivot order, factors and weights; nothing before pivots are chosen."""
        if self.placed is None:
            return {}
        lu, order = self.placed.lu, (self.placed.row_place, self.placed.column_order)
        kept = dict(zip(("row_place", "column_order"), order, strict=True))
        kept |= {"weights": self.placed.weights, "factors": lu.factors, "scale": lu.scale}
        return {name: array.copy() for name, array in kept.items()}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Take over such a state."""
        if not state:
            self.placed = None
            return
        order = {name: state[name] for name in ("row_place", "column_order", "scale")}
        self.complex.resume({**order, "weights": self.complex.weights, "factors": np.zeros(0)})
        assert self.complex.placed is not None
        self.placed = self._in_order(self.complex.placed)
        self.placed.lu.factors[:], self.placed.weights[:] = state["factors"], state["weights"]


def none_paired(placed: Assembler) -> Pairs:
    """No pair of matrices, beside one that is there."""
    nothing, places = np.zeros(0), placed.rows[:0]
    pattern = placed.pointers[:0], places, placed.diagonal[:0], places
    lu = PairFactors(*pattern, nothing, nothing, nothing)
    return Pairs(
        placed.parts[:0], placed.places[:0], nothing, lu, placed.row_place[:0], placed.column_order[:0]
    )


def _aligned(entries: int) -> Array:
    """Memory for entries that begin where registers are loaded in one go."""
    memory = np.zeros(WIDTH * (entries + 1))
    first = -(memory.ctypes.data // memory.itemsize) % WIDTH
    return memory[first : first + WIDTH * entries]


@compiled(entry=True)
def renew_pairs(values: Array, pairs: Pairs) -> float:
    """Assemble and factor both matrices; returns how far their pivots can be trusted."""
    assemble_pairs(pairs.parts, pairs.places, pairs.weights, values, pairs.lu.factors)
    return refactor_pairs(pairs.lu)


@compiled
def solve_stages(T: Array, back: Array, pairs: Pairs, right: Array, solution: Array) -> None:
    """Solution of all stages, split by Z = T W; `back` is the inverse of T."""
    n: Any = np.uint64(len(pairs.row_place))
    x = pairs.lu.work
    x[:] = 0.0
    for k in range(n):
        at = FOUR * np.uint64(pairs.row_place[k])
        for i in range(STAGES):
            x[at + i] = back[i, 0] * right[k] + back[i, 1] * right[n + k] + back[i, 2] * right[n + n + k]
    solve_pairs(pairs.lu, x)
    for k in range(n):
        at, to = FOUR * k, np.uint64(pairs.column_order[k])
        for i in range(STAGES):
            solution[to + i * n] = T[i, 0] * x[at] + T[i, 1] * x[at + ONE] + T[i, 2] * x[at + TWO]


@compiled
def solve_real(pairs: Pairs, right: Array, solution: Array) -> None:
    """Solution of the real matrix."""
    x = pairs.lu.work
    x[:] = 0.0
    for k in range(len(right)):
        x[FOUR * np.uint64(pairs.row_place[k])] = right[k]
    solve_pairs(pairs.lu, x)
    for k in range(np.uint64(len(right))):
        solution[pairs.column_order[k]] = x[FOUR * k]
