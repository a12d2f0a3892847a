"""The equations of motion at one state, for compiled loops: their matrix with pivots, and loads by inputs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra import Array
from ...linalg.sparse_solver import SingularMatrix
from ...model import SarrusError
from ...system import System
from ...system.cached import once
from ..dynamics.stepping.motion_matrix import motion_matrix
from ..equations.block_matrix import PlacedMatrix

TRUSTED = 1e-12  # pivot over column, below which constraints count as dependent


def matrix_at(system: System, q: Array, t: float, b: Array, rows: Array | None) -> PlacedMatrix:
    """Return the matrix with pivots for a state and independent equations (rows, None for all).

    Raises
    ------
    SarrusError
        In a singular configuration.
    """
    matrix = motion_matrix(system)
    matrix.numbers.keep(rows)
    for name in ("M", "Phi_q"):
        matrix.numbers.evaluate((name,), b, {"t": t, "q": q})
    try:
        matrix.choose_pivots()
    except (SingularMatrix, ValueError):
        raise singular(system, t) from None
    return matrix


def singular(system: System, t: float) -> SarrusError:
    """Return the error of a state without a unique solution."""
    return SarrusError(
        f"{system.name}: the equations of motion have no unique solution at t = {t:.6g} s, a singular configuration or "
        "a body without inertia. Give another state."
    )


def loads_by_inputs(system: System, q: Array, v: Array, t: float, b: Array, names: Sequence[str]) -> Array:
    """Return the derivatives of Q by the values of inputs (nq, nu)."""
    if not names:
        return np.zeros((system.nq, 0))
    entries, to = _of_inputs(system, tuple(names))
    found = np.bincount(to, system.Q_b(q, v, t, b=b).data[entries], system.nq * len(names))
    return found.reshape(system.nq, len(names))


@once
def _of_inputs(system: System, names: tuple[str, ...]) -> tuple[Array, Array]:
    """Return which numbers of Q_b belong to inputs, and their places among the derivatives by these, row by row."""
    pattern, column = system.pattern("Q_b"), np.full(len(system.b), -1)
    for k, name in enumerate(names):
        column[system.inputs[name].places] = k
    entries = np.flatnonzero(column[pattern.indices] >= 0)
    rows = np.searchsorted(pattern.indptr, entries, side="right") - 1
    return entries, rows * len(names) + column[pattern.indices[entries]]
