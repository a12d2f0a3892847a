"""The Jacobian of a fully driven system: as many independent equations as coordinates, factored."""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.factors import DENSE_BELOW, Factored, SingularSystem
from ...linalg.rank import DEPENDENT
from ..equations.length import scaled, units

ROUNDS = 6  # of inverse iteration; the smallest singular value is needed to one digit


def independent_rows(J: csr_array) -> Array:
    """Places of the largest set of independent rows, in rising order (rank,)."""
    if J.shape[0] == 0:
        return np.zeros(0, dtype=np.int64)
    dense = J.toarray()
    length = np.sqrt((dense * dense).sum(axis=1))
    triangle, order = qr((dense / np.where(length > 0, length, 1.0)[:, None]).T, mode="r", pivoting=True)
    sizes = abs(np.diag(triangle))
    return np.sort(order[: np.count_nonzero(sizes > DEPENDENT * sizes.max(initial=0.0))])


class Driven:
    """Chosen rows of Φ_q, scaled to unit length where displacements are measured in `length`: A, with its factors.

    Attributes
    ----------
    sign : of the determinant
    """

    def __init__(self, J: csr_array, rows: Array, length: float) -> None:
        J, self._unit = scaled(J, length), units(J.shape[1], length)
        matrix = J.toarray() if J.shape[1] < DENSE_BELOW else J
        chosen = matrix if len(rows) == J.shape[0] else matrix[rows]
        self.rows, self._length = rows, np.sqrt((chosen * chosen).sum(axis=1))
        self._n, self._m = J.shape[1], J.shape[0]
        weights = 1 / self._length[:, None]
        self._factors = Factored(
            chosen * weights if isinstance(chosen, np.ndarray) else csr_array(chosen.multiply(weights))
        )
        self.sign = self._factors.sign

    def solve(self, g: Array) -> Array:
        """x with Φ_q x = g, from the chosen rows."""
        found = self._checked(self._factors.solve(g[self.rows] / self._length))
        return np.asarray((self._unit * found.T).T)

    @property
    def is_whole(self) -> bool:
        """Whether no row was left out."""
        return bool(len(self.rows) == self._m)

    def transposed(self, f: Array) -> Array:
        """y with Φ_qᵀ y = f; zero in the rows that were not chosen."""
        y = np.zeros(self._m)
        y[self.rows] = self._checked(self._factors.transposed(self._unit * f)) / self._length
        return y

    def weakest(self) -> tuple[float, Array, Array]:
        """The smallest singular value of A, multipliers (m,) for which Φ_qᵀ lam nearly vanishes, a direction (nq,)."""
        x = np.cos(np.arange(self._n) + 1.0)
        x, y, size = x / np.linalg.norm(x), x, 1.0
        for _ in range(ROUNDS):
            y = self._factors.transposed(x)
            y = y / np.linalg.norm(y)
            x = self._factors.solve(y)
            size = 1 / float(np.linalg.norm(x))
            x = x * size
        left = np.zeros(self._m)
        left[self.rows] = y / self._length
        return size, left, self._unit * x

    def _checked(self, x: Array) -> Array:
        if not np.all(np.isfinite(x)):
            raise SingularSystem("the equations are dependent there")
        return x
