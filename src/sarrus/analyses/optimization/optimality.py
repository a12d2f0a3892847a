"""Distance of a design from an optimum, predicted from gradients, independent of the solver.

An objective f and a·f + b have the same optima, so nothing here is divided by the value of the objective: the gradient
that no limit balances (Karush, Kuhn, Tucker) is turned into a step by the curvature of the Lagrangian, and the fall
along that step is compared with the changes of the objective seen.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ...algebra import Array
from .prediction import Lagrangian, predicted_step, relative
from .search import ROUND_OFF, Search

OPTIMAL = 1e-2  # [-] predicted relative distance from the optimum that may remain
SHARP = 1e-4  # [-] the same, at which a solver is not started again
# [-] distance from a limit, in sizes of the variable or of the limit, within which it may press
ACTIVE = 5e-3
DEPENDENT = 1e-6  # [-] singular value of unit normals below which limits press in the same direction
# [-] of the fall achieved: where less is left to gain, variables that hardly matter may be anywhere
FLAT = 1e-9


class Balance(NamedTuple):
    """Remainder of a gradient after it is balanced by multipliers of the correct sign.

    Attributes
    ----------
    rest : the gradient of the Lagrangian (p,)
    weights : multipliers of the constrained responses (c,)
    gain : the fall of the objective on the way to the limits that press
    gap : how far these are, in sizes of the variables
    free : an orthonormal basis of the directions along which no limit presses (p, f)
    """

    rest: Array
    weights: Array
    gain: float
    gap: float
    free: Array


class Limit(NamedTuple):
    """A limit that is reached, or nearly so.

    Attributes
    ----------
    normal : its outward normal (p,)
    weights : which multiples of the constrained responses it is (c,)
    slack : what is left to the limit, as far as it is not passed
    """

    normal: Array
    weights: Array
    slack: float


def balance(search: Search, z: Array, slope: Array) -> Balance:
    """Balance the gradient of the objective by the limits that are reached, of variables and of constraints."""
    from scipy.optimize import nnls

    count, size = len(search.constraints), float(np.linalg.norm(slope))
    limits = [*_of_bounds(search, z, count), *_of_constraints(search, z)] if size > 0 else []
    lengths = np.array([np.linalg.norm(one.normal) for one in limits])
    if not lengths.any():
        return Balance(slope, np.zeros(count), 0.0, 0.0, np.eye(len(slope)))
    limits = [one for one, length in zip(limits, lengths, strict=True) if length > 0]
    lengths = lengths[lengths > 0]
    normals = np.array([one.normal for one in limits]).T / lengths
    multipliers = nnls(normals, -slope / size)[0] * size
    slacks = np.array([one.slack for one in limits]) / lengths
    pressing = multipliers > 0
    left, values, _ = np.linalg.svd(normals[:, pressing])
    return Balance(
        rest=slope + normals @ multipliers,
        weights=(multipliers / lengths) @ np.array([one.weights for one in limits]),
        gain=float(multipliers @ slacks),
        gap=float(max(slacks[pressing], default=0.0)),
        free=left[:, int(np.sum(values > DEPENDENT)) :],
    )


class GaussNewton(Protocol):
    """The gradient of a sum of squares, and the step that its Jacobian predicts."""

    def slope(self, z: Array) -> Array:
        """Return the gradient (p,)."""

    def step(self, z: Array, free: Array) -> Array:
        """Return the step of Gauss and Newton along the directions `free` (p, f), to be subtracted (p,)."""


def optimality(search: Search, z: Array, gauss_newton: GaussNewton | None = None) -> float:
    """The predicted relative distance of a design from the optimum: 0 at an optimum.

    It is the larger of two: the predicted change of a variable, in its size; and the square root of the predicted fall
    of the objective over the changes of it seen in the search, which is a distance where the objective is quadratic,
    with the fall on the way to limits over them. Where a fall below `FLAT` of that achieved is predicted, the first
    counts as `OPTIMAL` at most. `gauss_newton` gives gradient and step of a sum of squares; others are predicted.
    """
    slope = (gauss_newton or search).slope(z)
    here = balance(search, z, slope)
    rest = here.free @ (here.free.T @ here.rest)
    size, largest = float(np.linalg.norm(rest)), float(np.linalg.norm(slope))
    if size <= ROUND_OFF * max(abs(search.value(z)), largest):
        return _distance(search, z, np.zeros_like(z), 0.0, here)
    step = (
        gauss_newton.step(z, here.free)
        if gauss_newton
        else predicted_step(Lagrangian(search, here.weights), z, here.free, rest)
    )
    if step is None:
        return _distance(search, z, rest / size, size, here)
    return _distance(search, z, step, 0.5 * max(float(rest @ step), 0.0), here)


def _distance(search: Search, z: Array, step: Array, fall: float, here: Balance) -> float:
    """The relative distance for a predicted step against the gradient and its fall, with that to the limits."""
    low, high = search.variables.ends.T
    change = max(relative(np.clip(z - step, low, high) - z, z), here.gap)
    values, whole = search.values, fall + here.gain
    achieved, largest = abs(values[0] - search.value(z)), np.ptp(values)
    in_value = float(np.sqrt(fall / largest) + here.gain / largest) if largest > 0 else float(whole > 0)
    return max(min(change, OPTIMAL) if whole <= FLAT * achieved else change, in_value)


def _of_bounds(search: Search, z: Array, count: int) -> list[Limit]:
    """The bounds that are reached."""
    low, high = search.variables.ends.T
    every, none = np.eye(len(z)), np.zeros(count)
    slacks = [*zip(every, high - z, strict=True), *zip(-every, z - low, strict=True)]
    return [Limit(normal, none, max(slack, 0.0)) for normal, slack in slacks if slack <= ACTIVE]


def _of_constraints(search: Search, z: Array) -> list[Limit]:
    """The constraints whose limits are reached or passed."""
    if not search.constraints:
        return []
    values, slopes, found = search.others(z), search.other_slopes(z), list[Limit]()
    for k, (one, value, slope) in enumerate(zip(search.constraints, values, slopes, strict=True)):
        (low, high), own, near = one.ends, np.eye(len(values))[k], ACTIVE * one.size
        found += [Limit(slope, own, max(high - value, 0.0))] if value >= high - near else []
        found += [Limit(-slope, -own, max(value - low, 0.0))] if value <= low + near else []
    return found
