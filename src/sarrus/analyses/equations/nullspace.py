"""A constraint Jacobian of any rank: the motions it leaves free, the least change, multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array
from ...linalg.rank import DEPENDENT
from .length import units

# A singular value, of rows scaled to unit length, relative to the largest, that counts as zero


class NullSpace:
    """Singular values of J (m, n), its rows scaled to unit length. Dense: for up to about a thousand coordinates.

    Parameters
    ----------
    J : (m, n) sparse
    length : by which displacements are measured, see `sarrus.analyses.equations.length`
    tolerance : a singular value relative to the largest that counts as zero

    Attributes
    ----------
    rank : number of independent rows
    lengths : of the rows (m,), where displacements are measured in `length`
    Z : (n, n - rank) basis of the directions ξ with J ξ = 0, orthonormal where displacements are measured in `length`
    null : (m, m - rank) orthonormal basis of the y with Jᵀ y = 0
    share : (n - rank, n) with share Z = I, zero for what `change` returns
    """

    def __init__(self, J: Any, length: float, tolerance: float = DEPENDENT) -> None:
        self._unit = units(J.shape[1], length)
        dense = J.toarray() * self._unit
        self.lengths = _lengths(dense)
        left, sizes, right = np.linalg.svd(dense / self.lengths[:, None], full_matrices=True)
        self.rank = int(np.count_nonzero(sizes > tolerance * sizes.max(initial=0.0)))
        self._left, self._sizes = left[:, : self.rank], sizes[: self.rank]
        self._right = right[: self.rank].T
        self.Z, self.share = self._unit[:, None] * right[self.rank :].T, right[self.rank :] / self._unit
        self.null = np.linalg.qr(left[:, self.rank :] / self.lengths[:, None])[0]

    def change(self, g: Array) -> Array:
        """The shortest x with J x = g, for a vector or columns; the nearest to it where there is none."""
        scaled = (g.T / self.lengths).T
        return np.asarray((self._unit * (self._right @ ((self._left.T @ scaled).T / self._sizes).T).T).T)

    def multipliers(self, f: Array) -> Array:
        """Return a y with Jᵀ y = f, up to the part of f along Z; the other ones differ by combinations of `null`."""
        return np.asarray(self._left @ ((self._right.T @ (self._unit * f)) / self._sizes) / self.lengths)


def _lengths(J: Array) -> Array:
    length = np.sqrt((J * J).sum(axis=1))
    return np.where(length > 0, length, 1.0)
