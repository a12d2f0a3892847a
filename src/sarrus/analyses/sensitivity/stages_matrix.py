"""The matrix of an operation with several alike stages: the order of its pivots is that of one stage.

Each unknown of one stage, and each of its equations, occurs as often as there are stages. So the pivots of one stage's
matrix are those of blocks (stages, stages): entries of M and of unit matrices are full there, all others diagonal. With
Markowitz's rule for all stages of Radau IIA at once the vehicle's factors have three times as many numbers, made by ten
times as many products.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..._jit.link import link
from ...linalg.sparse_solver import SingularMatrix, SparseLU
from ..equations.block_matrix import Numbers, Part, Placed, PlacedMatrix, refactor
from .step_matrix import StepMatrix

LEAST = 1e-10  # pivot over column, below which pivots are chosen among all stages


class StagesMatrix(StepMatrix):
    """The matrix of all stages.

    Attributes
    ----------
    in_blocks : whether the order of one stage is tried
    """

    in_blocks = True

    def __init__(self, numbers: Numbers, n: int, parts: Sequence[Part], stages: int) -> None:
        super().__init__(numbers, n, parts)
        self._stages, size = stages, n // stages
        last = n - size
        self._own = [k for k, part in enumerate(parts) if min(part.row, part.column) >= last]
        own = [parts[k]._replace(row=parts[k].row - last, column=parts[k].column - last) for k in self._own]
        self._one = PlacedMatrix(numbers, size, own)

    def choose_pivots(self) -> Placed:
        """In the order of those of the last stage; where they are too small, in one of their own.

        Raises
        ------
        SingularMatrix
            If the matrix is singular.
        """
        return (self.in_blocks and self._in_order_of_one()) or super().choose_pivots()

    def _in_order_of_one(self) -> Placed | None:
        """In the order of the last stage's pivots, if these can be trusted."""
        self._one.weights[:] = self.weights[self._own]
        try:
            found = self._expanded()
        except SingularMatrix:
            return None
        return found if link(refactor)(self.numbers.values, found) > LEAST else None

    def _expanded(self) -> Placed:
        one, layout, count = self._one.choose_pivots(), self._layout, self._stages
        rows = [count * one.row_place.astype(np.int64) + i for i in range(count)]
        columns = one.column_order.astype(np.int64)[:, None] + self._one.n * np.arange(count)
        return self._show(
            SparseLU.ordered(layout.indptr, layout.indices, np.concatenate(rows), columns.ravel())
        )
