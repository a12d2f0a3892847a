"""Operators at one state joined to one sparse matrix, on a pattern made once, with what numbers of curves add to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...system.curves.curve_derivatives import Entries
from .block_matrix import Numbers, Part, PlacedMatrix


class CurveTerms(NamedTuple):
    """Derivatives of an operator by numbers of curves at one time, with a sign, from a row on for that many."""

    sign: float
    entries: Entries
    row: int
    height: int


class TwoSidedMatrix:
    """A matrix that is multiplied with from both sides.

    Parameters
    ----------
    numbers : evaluated
    signs : the operators' places in the matrix, with their signs
    height, before : number of rows; and of columns before those of the numbers of the elements
    width : number of columns, with those of curves behind those of elements
    curved : what curves add
    """

    def __init__(
        self,
        numbers: Numbers,
        signs: Mapping[Part, float],
        height: int,
        before: int,
        width: int,
        curved: Sequence[CurveTerms] = (),
    ) -> None:
        inside = before + numbers.system.nb
        placed = PlacedMatrix(numbers, max(height, inside), [*signs])
        placed.weights[:] = [*signs.values()]
        self._matrix, self._curved = placed.matrix(), curved
        self._height, self._before, self._inside, self._width = height, before, inside, width

    def __matmul__(self, x: Array) -> Array:
        """The product with x (width,) or (width, k)."""
        padded = np.zeros((self._matrix.shape[1], *x.shape[1:]))
        padded[: self._inside] = x[: self._inside]
        found: Array = (self._matrix @ padded)[: self._height]
        for sign, entries, row, height in self._curved if np.any(x[self._inside :]) else ():
            part = entries.along(x[self._before :].reshape(len(x) - self._before, -1), height)[0]
            found[row : row + height] += sign * part.reshape(height, *x.shape[1:])
        return found

    def sizes(self, x: Array) -> Array:
        """The product of absolute values, against which a result of the product may be round-off."""
        padded = np.zeros((self._matrix.shape[1], *x.shape[1:]))
        padded[: self._inside] = abs(x[: self._inside])
        found: Array = (abs(self._matrix) @ padded)[: self._height]
        return found

    def transposed(self, y: Array) -> Array:
        """The product of the transposed matrix with y (height,) or (height, k)."""
        padded = np.zeros((self._matrix.shape[0], *y.shape[1:]))
        padded[: self._height] = y
        found = np.zeros((self._width, *y.shape[1:]))
        found[: self._inside] = (self._matrix.T @ padded)[: self._inside]
        for sign, entries, row, height in self._curved:
            weights = y[row : row + height].reshape(1, height, -1)
            part = entries.gradient(weights, self._width - self._before)
            found[self._before :] += sign * part.reshape(-1, *y.shape[1:])
        return found
