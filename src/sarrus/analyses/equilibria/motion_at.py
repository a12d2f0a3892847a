"""The equations of motion at one state, for compiled loops: their matrix with pivots, and parameters by inputs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra import Array
from ...linalg.sparse_solver import SingularMatrix
from ...model import SarrusError
from ...system import System
from ..dynamics.stepping.motion_matrix import motion_matrix
from ..dynamics.time_loop.initial_warnings import rank_changes
from ..equations.block_matrix import PlacedMatrix
from ..redundancy.redundant_constraints import Independence

TRUSTED = 1e-12  # pivot over column, below which constraints count as dependent


def independent_at(system: System, q: Array, t: float) -> Array | None:
    """Return places of independent equations, None if all are, for a state and those that it can move to.

    Raises
    ------
    SarrusError
        In a singular configuration: with the equations that are dependent there alone, motions nearby would be wrong.
    """
    found = Independence(system, q, t)
    if found.known and found.known + system.nq > system.m and rank_changes(system, q, t, found):
        raise singular(system, t)
    return found.rows


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


def unsolved(system: System, t: float, trust: float) -> SarrusError:
    """Return the error of a state at which pivots just chosen are not to be trusted: -1, the solution is not finite."""
    if trust >= 0.0:
        return singular(system, t)
    return SarrusError(
        f"{system.name}: accelerations or multipliers are not finite at t = {t:.6g} s. Give other velocities, inputs "
        "or parameters, or look for a force that is not finite there."
    )


def refuse_not_finite(**values: object) -> None:
    """Refuse a state that contains nan or infinity.

    Raises
    ------
    ValueError
    """
    for name, value in values.items():
        if not np.isfinite(value).all():  # type: ignore[call-overload]
            raise ValueError(f"{name} must be finite, got {value!r:.60}. Give finite numbers.")


def input_changes(system: System, names: Sequence[str]) -> Array:
    """Return the derivatives of the parameters b by the values of inputs (len(b), nu)."""
    found = np.zeros((len(system.b), len(names)))
    for k, name in enumerate(names):
        found[system.inputs[name].places, k] = 1.0
    return found
