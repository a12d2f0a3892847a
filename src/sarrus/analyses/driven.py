"""The Jacobian of a fully driven system: as many independent equations as coordinates, factored."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve, qr
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from ..algebra import Array
from .nullspace import DEPENDENT
from .saddle import DENSE_BELOW, SingularSystem

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
    """Chosen rows of Φ_q, scaled to unit length: a square matrix A with its factors.

    Attributes
    ----------
    sign : of the determinant
    """

    def __init__(self, J: csr_array, rows: Array) -> None:
        chosen = J if len(rows) == J.shape[0] else J[rows]
        self.rows, self._length = rows, np.sqrt((chosen * chosen).sum(axis=1))
        self._n, self._m = J.shape[1], J.shape[0]
        scaled = csr_array(chosen.multiply(1 / self._length[:, None]))
        self._solve, self.sign = _dense(scaled) if self._n < DENSE_BELOW else _sparse(scaled)

    def solve(self, g: Array) -> Array:
        """x with Φ_q x = g, from the chosen rows."""
        return self._checked(self._solve(g[self.rows] / self._length, False))

    def transposed(self, f: Array) -> Array:
        """y with Φ_qᵀ y = f; zero in the rows that were not chosen."""
        y = np.zeros(self._m)
        y[self.rows] = self._checked(self._solve(f, True)) / self._length
        return y

    def weakest(self) -> tuple[float, Array, Array]:
        """The smallest singular value of A, multipliers (m,) for which Φ_qᵀ lam nearly vanishes, a direction (nq,)."""
        x = np.cos(np.arange(self._n) + 1.0)
        x, y, size = x / np.linalg.norm(x), x, 1.0
        for _ in range(ROUNDS):
            y = self._solve(x, True)
            y = y / np.linalg.norm(y)
            x = self._solve(y, False)
            size = 1 / float(np.linalg.norm(x))
            x = x * size
        left = np.zeros(self._m)
        left[self.rows] = y / self._length
        return size, left, x

    def _checked(self, x: Array) -> Array:
        if not np.all(np.isfinite(x)):
            raise SingularSystem("the equations are dependent there")
        return x


def _dense(A: csr_array) -> tuple[Any, float]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LinAlgWarning)
        factors = lu_factor(A.toarray(), check_finite=False)
    diagonal = np.diag(factors[0])
    if not np.all(diagonal):
        raise SingularSystem("the equations are dependent there")
    swaps = np.count_nonzero(factors[1] != np.arange(A.shape[0]))
    sign = float(np.prod(np.sign(diagonal)) * (-1) ** swaps)
    return (lambda g, trans: lu_solve(factors, g, trans=int(trans), check_finite=False)), sign


def _sparse(A: csr_array) -> tuple[Any, float]:
    try:
        factors = splu(A.tocsc())
    except RuntimeError as trouble:
        raise SingularSystem(str(trouble)) from None
    diagonal = factors.U.diagonal()
    sign = float(np.prod(np.sign(diagonal)) * _parity(factors.perm_r) * _parity(factors.perm_c))
    return (lambda g, trans: factors.solve(g, "T" if trans else "N")), sign


def _parity(order: Array) -> int:
    """+1 for an even permutation, -1 for an odd one."""
    seen, swaps = np.zeros(len(order), dtype=bool), 0
    for first in range(len(order)):
        at = first
        while not seen[at]:
            seen[at], at = True, int(order[at])
            swaps += at != first
    return -1 if swaps % 2 else 1
