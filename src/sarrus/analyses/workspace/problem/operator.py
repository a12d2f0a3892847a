"""An operator of constraints as a dense, scaled matrix with a cached pattern."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....algebra import Array
from ....system.operators.constraints import ConstraintOperators


class Vector:
    """A vector operator with rows chosen and scaled."""

    def __init__(self, of: ConstraintOperators, name: str, rows: Array, factor: Array) -> None:
        self._of, self._group = of, of.group(name)
        self._out, self._rows, self._factor = self._group.allocate()[0], rows, factor

    def __call__(self, *operands: Any) -> Array:
        """The chosen rows; operands in the order of the group, the time left out."""
        self._group.run(self._of.b, 0.0, *operands, self._out)
        return np.asarray(self._out[self._rows] * self._factor)


class Matrix:
    """A matrix operator whose numbers are added into a dense matrix, rows and columns chosen and scaled."""

    def __init__(self, of: ConstraintOperators, name: str, place: Array, row: Array, column: Array) -> None:
        """`place` is the row of the dense matrix for every row of the operator, or -1."""
        self._of, self._group = of, of.group(name)
        self._out, pattern = self._group.allocate()[0], of.pattern(name)
        rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr))
        self._used = np.flatnonzero(place[rows] >= 0)
        rows, columns = rows[self._used], pattern.indices[self._used]
        self._flat = place[rows] * pattern.shape[1] + columns
        self._factor = row[rows] * column[columns]

    def add(self, into: Array, *operands: Any) -> None:
        """Add the numbers into a matrix that is contiguous."""
        self._group.run(self._of.b, 0.0, *operands, self._out)
        into.reshape(-1)[self._flat] += self._out[self._used] * self._factor
