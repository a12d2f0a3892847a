"""The matrix of an operation at one occurrence: where pivots are chosen.

Each unknown of one stage, and each of its equations, occurs as often as there are stages, if these are alike. So the
pivots of one stage's matrix are those of blocks (stages, stages): entries of M and of unit matrices are full there, all
others diagonal. With Markowitz's rule for all stages of Radau IIA at once the vehicle's factors have three times as
many numbers, made by ten times as many products.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.panel_loop import Pattern, panel_ends
from ....linalg.row_order import unsigned
from ....linalg.sparse_solver import SingularMatrix, SparseLU
from ....system import System
from ...dynamics.methods.equations import GROUPS
from ...dynamics.methods.splitting import Split, StageTables
from ...dynamics.methods.tables import Tables, at_stage, constrained
from ...equations.block_matrix import Assembler, Numbers, PlacedMatrix, refactor
from .split_loop import SplitStages, Transformation


class Placement(NamedTuple):
    """Where the numbers of operators are in a matrix, with the order of its pivots; see `block_matrix.assemble`.

    A matrix with `split` stages is not factored: its numbers are in the order of the unknowns.
    """

    parts: Array
    places: Array
    pattern: Pattern
    split: SplitStages | None = None

    @property
    def factors(self) -> int:
        """Numbers of the factors."""
        return len(self.pattern.rows) + (3 * len(self.split.pattern.rows) if self.split else 0)


class ArrangedMatrix(PlacedMatrix):
    """A matrix with the numbers in the order of its pivots."""

    def in_order(self, placed: Assembler) -> Placement:
        """The places of the numbers for an order of pivots."""
        layout = self._layout
        counts = np.diff(layout.indptr)[placed.column_order]
        indptr = np.concatenate([[0], np.cumsum(counts)])
        starts = layout.indptr[:-1][placed.column_order] - indptr[:-1]
        source = np.repeat(starts, counts) + np.arange(indptr[-1])
        places = np.empty(len(source), np.int64)
        places[source] = np.arange(len(source))
        factors = unsigned((placed.pointers, placed.rows, placed.diagonal))
        pattern = unsigned((indptr, placed.row_place[layout.indices[source]]))
        ends, order = link(panel_ends)(*factors), unsigned((placed.row_place, placed.column_order))
        found = Pattern._make([*pattern, *factors, ends, *order])
        return Placement(self.parts, unsigned([places[layout.place]])[0], found)


class OperationMatrix(ArrangedMatrix):
    """Numbers of the operators of an operation at one occurrence, and its matrix; `split` of its stages, or None."""

    def __init__(self, system: System, tables: Tables, split: Split | None = None) -> None:
        self._tables, parts, count = tables, tables.parts, tables.alike_stages
        super().__init__(Numbers(system, tables.names, tables.like), tables.n, parts)
        size = tables.n // count
        last = tables.n - size
        self._own = [k for k, part in enumerate(parts) if min(part.row, part.column) >= last]
        own = [parts[k]._replace(row=parts[k].row - last, column=parts[k].column - last) for k in self._own]
        self._one = PlacedMatrix(self.numbers, size, own) if count > 1 else None
        self._split = split

    @cached_property
    def constrained(self) -> Array:
        """Places of numbers in rows of constraints, and the constraint (entries, 2)."""
        return constrained(self.numbers.system, self._tables.structure)

    def evaluate(
        self, b: Array, left_out: Array, at: Sequence[Mapping[str, Array | float]], weights: Array
    ) -> None:
        """The numbers at given stages, and the weights of the parts."""
        numbers, system = self.numbers, self.numbers.system
        none = np.zeros(max(system.nq, system.m))
        for s, call in self._tables.calls:
            group = system.group(*GROUPS[call.group])
            operands = (at[s].get(name, none) for name in call.operands)
            group.run(b, *operands, *numbers.of([at_stage(name, s) for name in call.outputs]))
        numbers.left_out[:], self.weights[:] = left_out, weights
        places, rows = self.constrained.T
        numbers.values[places] *= 1.0 - left_out[rows]

    def arranged(self, in_blocks: bool = True) -> Placement:
        """Choose the pivot order for the numbers and weights that are there now.

        In the order of those of the last stage; where one is zero there, or not `in_blocks`, in one of their own, which
        costs up to ten times as much. Small ones do no harm by themselves: with short steps they are small, as some
        columns contain a square of the step. Each solution is checked.

        Raises
        ------
        SingularMatrix
            If the matrix is singular.
        """
        return self.in_order((in_blocks and self._in_order_of_one()) or self.choose_pivots())

    def split(self, weights: Array) -> Placement:
        """Choose the pivot order of the matrices of split stages, by the weights of the real one.

        Raises
        ------
        SingularMatrix
            If the real matrix is singular.
        """
        split, tables, layout = self._split, self._tables, self._layout
        assert split is not None
        stage = StageTables(split.structure, tables.nq, tables.m, tables.holonomic)
        parts = [part._replace(name=part.name.replace("@0", f"@{split.stage}")) for part in stage.parts]
        one = ArrangedMatrix(self.numbers, stage.n, parts)
        one.weights[:] = weights[: len(parts)]
        found = one.in_order(one.choose_pivots())
        order, none = np.arange(self.n), np.zeros(0, np.int64)
        exact = Pattern._make(unsigned((layout.indptr, layout.indices, none, none, none, none, order, order)))
        ways = between(split, found.pattern)
        split_stages = SplitStages(found.parts, found.places, found.pattern, *ways)
        return Placement(self.parts, unsigned([layout.place])[0], exact, split_stages)

    def _in_order_of_one(self) -> Assembler | None:
        """In the order of the last stage's pivots, if none of them is zero."""
        if self._one is None:
            return None
        self._one.weights[:] = self.weights[self._own]
        try:
            found = self._expanded(self._one.choose_pivots(), self.n // self._one.n)
        except SingularMatrix:
            return None
        return found if link(refactor)(self.numbers.values, found) > 0.0 else None

    def _expanded(self, one: Assembler, count: int) -> Assembler:
        rows = np.concatenate([count * one.row_place.astype(np.int64) + i for i in range(count)])
        columns = one.column_order.astype(np.int64)[:, None] + len(one.column_order) * np.arange(count)
        order = SparseLU.ordered(self._layout.indptr, self._layout.indices, rows, columns.ravel())
        return self._show(order, self._exponents()[0])


def between(split: Split, pattern: Pattern) -> tuple[Transformation, Transformation]:
    """From equations to unknowns with P = (T ⊗ I) diag(real, complex) (T⁻¹ ⊗ I), and back with its transpose.

    The transpose of the real form of the complex matrix is that of its conjugate.
    """
    conjugate = np.diag([1.0, 1.0, -1.0])
    equations, unknowns = unsigned([np.argsort(pattern.row_place)])[0], pattern.column_order
    return (
        Transformation(split.inverse, equations, split.T, unknowns),
        Transformation(conjugate @ split.T.T, unknowns, split.inverse.T @ conjugate, equations),
    )
