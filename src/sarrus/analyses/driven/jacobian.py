"""The Jacobian of a fully driven system: as many independent equations as coordinates, factored."""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.rank import DEPENDENT
from ...system import System
from ..equations.block_matrix import LEFT_OUT, Numbers, Part, PlacedMatrix


def independent_rows(J: csr_array) -> Array:
    """Places of the largest set of independent rows, in rising order (rank,)."""
    if J.shape[0] == 0:
        return np.zeros(0, dtype=np.int64)
    dense = J.toarray()
    length = np.sqrt((dense * dense).sum(axis=1))
    triangle, order = qr((dense / np.where(length > 0, length, 1.0)[:, None]).T, mode="r", pivoting=True)
    sizes = abs(np.diag(triangle))
    return np.sort(order[: np.count_nonzero(sizes > DEPENDENT * sizes.max(initial=0.0))])


def square_matrix(system: System, rows: Array) -> PlacedMatrix:
    """The matrix (nq, nq) of the gradients of as many equations, in places of Φ that rise."""
    places = np.arange(len(rows))
    runs = np.split(places, np.flatnonzero(np.diff(rows) != 1) + 1)
    parts = [
        Part("Phi_q", int(run[0] - rows[run[0]]), 0, rows=(int(rows[run[0]]), int(rows[run[-1]]) + 1))
        for run in runs
        if len(run)
    ]
    return PlacedMatrix(Numbers(system, (LEFT_OUT, "Phi_q")), len(rows), parts)


def parity(order: Array) -> int:
    """+1 for an even permutation, -1 for an odd one."""
    seen, swaps = np.zeros(len(order), dtype=bool), 0
    for first in range(len(order)):
        at = first
        while not seen[at]:
            seen[at], at = True, int(order[at])
            swaps += at != first
    return -1 if swaps % 2 else 1
