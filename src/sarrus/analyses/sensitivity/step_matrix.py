"""The matrix of a step as sweeps factor it: at every step anew, its numbers being kept beside for a refinement."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..._jit.link import link
from ...algebra import Array
from ..equations.block_matrix import PlacedMatrix
from .panel_loop import Factors, panel_ends


class StepMatrix(PlacedMatrix):
    """A matrix that is factored by panels."""

    def in_panels(self) -> Factors:
        """Choose the pivot order for the numbers and weights that are there now; room for factors.

        Raises
        ------
        SingularMatrix
            If the matrix is singular.
        """
        found, layout = self.choose_pivots(), self._layout
        counts = np.diff(layout.indptr)[found.column_order]
        indptr = np.concatenate([[0], np.cumsum(counts)])
        source = np.repeat(layout.indptr[:-1][found.column_order] - indptr[:-1], counts) + np.arange(
            indptr[-1]
        )
        places = np.empty(len(source), np.int64)
        places[source] = np.arange(len(source))
        pattern = (places[layout.place], indptr, found.row_place[layout.indices[source]])
        lower_upper = unsigned((found.pointers, found.rows, found.diagonal))
        ends, order = link(panel_ends)(*lower_upper), unsigned((found.row_place, found.column_order))
        first = [self.parts, self.weights, *unsigned(pattern), np.zeros(len(source)), *lower_upper]
        return Factors._make([*first, found.factors, ends, found.work, *order])


def unsigned(arrays: Iterable[Array]) -> list[Array]:
    """Places as compiled code looks them up fastest."""
    return [np.ascontiguousarray(array).astype(np.uint64) for array in arrays]
