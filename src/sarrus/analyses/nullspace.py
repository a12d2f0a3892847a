"""A constraint Jacobian of any rank: the motions it leaves free, the least change, the shortest multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..algebra import Array

# A singular value, of rows scaled to unit length, relative to the largest, that counts as zero
DEPENDENT = 1e-9


class NullSpace:
    """Singular values of J (m, n), its rows scaled to unit length. Dense: for up to about a thousand coordinates.

    Parameters
    ----------
    J : (m, n) sparse
    tolerance : a singular value relative to the largest that counts as zero

    Attributes
    ----------
    rank : number of independent rows
    Z : (n, n - rank) orthonormal basis of the directions ξ with J ξ = 0
    """

    def __init__(self, J: Any, tolerance: float = DEPENDENT) -> None:
        self._J = J.toarray()
        self._length = _lengths(self._J)
        left, sizes, right = np.linalg.svd(self._J / self._length[:, None], full_matrices=True)
        self.rank = int(np.count_nonzero(sizes > tolerance * sizes.max(initial=0.0)))
        self._left, self._sizes = left[:, : self.rank], sizes[: self.rank]
        self._right, self.Z = right[: self.rank].T, right[self.rank :].T
        self._dependent = left[:, self.rank :] / self._length[:, None]

    def change(self, g: Array) -> Array:
        """The shortest x with J x = g, for a vector or columns; the nearest to it where there is none."""
        scaled = (g.T / self._length).T
        return np.asarray(self._right @ ((self._left.T @ scaled).T / self._sizes).T)

    def multipliers(self, f: Array) -> Array:
        """The shortest y with Jᵀ y = f, up to the part of f along Z."""
        y = self._left @ ((self._right.T @ f) / self._sizes) / self._length
        if self._dependent.size:
            y = y - self._dependent @ np.linalg.lstsq(self._dependent, y, rcond=None)[0]
        return np.asarray(y)


def _lengths(J: Array) -> Array:
    length = np.sqrt((J * J).sum(axis=1))
    return np.where(length > 0, length, 1.0)
