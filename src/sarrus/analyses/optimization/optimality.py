"""The first-order optimality conditions (Karush, Kuhn, Tucker) at a design, computed without the solver."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...algebra import Array
from .search import Search

OPTIMAL = 1e-2  # [-] relative change of the objective with relative changes of the variables that may remain
SHARP = 1e-4  # [-] the same, at which a solver is not started again
ACTIVE = (
    1e-4  # [-] distance from a limit, in sizes of the variable or of the limit, within which it may press
)
SLIGHT = 1e-4  # [-] of the objective at the start: the least size by which its slope is divided


def objective_size(value: float, first: float) -> float:
    """The size of an objective: its magnitude, but not far below that at the start."""
    return max(abs(value), SLIGHT * abs(first)) or 1.0


def optimality(search: Search, z: Array, slope_of: Callable[[Array], Array] | None = None) -> float:
    """How far the conditions are from holding at a design: 0 at an optimum.

    The gradient of the objective, divided by `objective_size`, is balanced by multipliers of the right sign of all
    limits that are reached, of variables and of constraints; the norm of what is left is returned. Variables are
    divided by their sizes, constraints by those of their limits. `slope_of` gives the gradient where it is known
    otherwise than from `Search.slope`.
    """
    from scipy.optimize import nnls

    slope = (slope_of or search.slope)(z) / objective_size(search.value(z), search.first)
    normals = np.array([*_of_bounds(search, z), *_of_constraints(search, z)]).reshape(-1, len(slope)).T
    if not normals.size:
        return float(np.linalg.norm(slope))
    lengths = np.linalg.norm(normals, axis=0)
    normals = normals[:, lengths > 0] / lengths[lengths > 0]
    return float(nnls(normals, -slope)[1]) if normals.size else float(np.linalg.norm(slope))


def _of_bounds(search: Search, z: Array) -> list[Array]:
    """Outward normals of the bounds that are reached."""
    low, high = search.variables.ends.T
    every = np.eye(len(z))
    return [*every[z >= high - ACTIVE], *-every[z <= low + ACTIVE]]


def _of_constraints(search: Search, z: Array) -> list[Array]:
    """Outward normals of the constraints whose limits are reached or passed."""
    if not search.constraints:
        return []
    values, slopes, found = search.others(z), search.other_slopes(z), list[Array]()
    for one, value, slope in zip(search.constraints, values, slopes, strict=True):
        low, high = one.ends
        found += [slope / one.size] if value >= high - ACTIVE * one.size else []
        found += [-slope / one.size] if value <= low + ACTIVE * one.size else []
    return found
