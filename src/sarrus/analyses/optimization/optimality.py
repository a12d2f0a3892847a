"""Distance of a design from an optimum, predicted from gradients, independent of the solver.

An objective f and a·f + b have the same optima, so nothing here is divided by the value of the objective: the gradient
that no limit balances (Karush, Kuhn, Tucker) is turned into a step by the curvature of the Lagrangian, and the fall
along that step is compared with the changes of the objective seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ...algebra import Array
from .point import DesignError
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
    lengths = np.array([np.linalg.norm(limit.normal) for limit in limits])
    if not lengths.any():
        return Balance(slope, np.zeros(count), 0.0, 0.0, np.eye(len(slope)))
    limits = [limit for limit, length in zip(limits, lengths, strict=True) if length > 0]
    lengths = lengths[lengths > 0]
    normals = np.array([limit.normal for limit in limits]).T / lengths
    multipliers = nnls(normals, -slope / size)[0] * size
    slacks = np.array([limit.slack for limit in limits]) / lengths
    pressing = multipliers > 0
    left, values, _ = np.linalg.svd(normals[:, pressing])
    return Balance(
        rest=slope + normals @ multipliers,
        weights=(multipliers / lengths) @ np.array([limit.weights for limit in limits]),
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
    values, slopes, limits = search.others(z), search.other_slopes(z), list[Limit]()
    for k, (constraint, value, slope) in enumerate(zip(search.constraints, values, slopes, strict=True)):
        (low, high), multiple, near = constraint.ends, np.eye(len(values))[k], ACTIVE * constraint.size
        limits += [Limit(slope, multiple, max(high - value, 0.0))] if value >= high - near else []
        limits += [Limit(-slope, -multiple, max(value - low, 0.0))] if value <= low + near else []
    return limits


TRIALS = 16  # designs nearby whose gradients are computed at most
NEARBY = 1e-4  # [-] relative change of a variable there at least, above the noise of simulations
# [-] of a gradient, that the predicted step may leave: in a narrow valley most of it points across
PREDICTED = 1e-3
FAR = 0.1  # [-] relative change of a variable from which the prediction need not be more exact
CURVED = 1e-10  # [-] cosine between steps and changes of the gradient, below which there is no curvature along a step


def relative(change: Array, z: Array) -> float:
    """The largest change of a variable, over its value or its size."""
    return float(np.max(abs(change) / np.maximum(abs(z), 1.0)))


class Lagrangian:
    """The gradient of an objective with weighed constraints, where designs can be simulated.

    Parameters
    ----------
    search : Search
    weights : multipliers of the constrained responses (c,)
    """

    def __init__(self, search: Search, weights: Array) -> None:
        self.search, self._weights = search, weights

    def slope(self, z: Array) -> Array:
        """The gradient (p,).

        Raises
        ------
        Infeasible
            If the design cannot be simulated.
        """
        search = self.search
        search.point(z).values  # noqa: B018
        slope = search.slope(z)
        return slope + self._weights @ search.other_slopes(z) if self._weights.any() else slope

    def curvature(self, z: Array) -> Array | None:
        """Return the second derivatives at a design that the gradients of the search imply (p, p).

        Gradients of nearer designs than `NEARBY` are left out: they differ by the noise of simulations.
        """
        here = self.slope(z)
        others = (
            (x.z - z, x.slope + self._weights @ x.others - here) for x in self.search.gradients.values()
        )
        return curvature_from_gradients([pair for pair in others if relative(pair[0], z) >= NEARBY])

    def change(self, z: Array, step: Array) -> Array | None:
        """The change of the gradient with a step back, from a design nearby; None where none can be simulated."""
        here = self.slope(z)
        for length in self._lengths(z, step):
            try:
                return np.asarray((self.slope(z + length * step) - here) / length)
            except DesignError:
                continue
        return None

    def _lengths(self, z: Array, step: Array) -> list[float]:
        """Multiples of a step to designs between the limits, backward ones first, then forward ones.

        Of each direction, the step itself if it is neither shorter than `NEARBY` nor longer than `FAR`, and the
        shortest one. A step that ends outside of the limits proves nothing of the curvature.
        """
        size = max(relative(step, z), np.finfo(float).tiny)
        low, high = self.search.variables.ends.T
        multiples = list[float]()
        for sign in (-1.0, 1.0):
            with np.errstate(divide="ignore", invalid="ignore"):
                to_limits = np.where(sign * step > 0, high - z, z - low) / abs(step)
            most = float(np.nanmin(np.where(step == 0, np.inf, to_limits)))
            lengths = {float(np.clip(1.0, NEARBY / size, FAR / size)), NEARBY / size}
            multiples += [sign * min(length, most) for length in sorted(lengths, reverse=True)]
        return [length for length in multiples if abs(length) * size >= 0.5 * NEARBY]


def predicted_step(lagrangian: Lagrangian, z: Array, free: Array, rest: Array) -> Array | None:
    """The step s with H s = the gradient that is left (p,), H the second derivatives; None where H is not positive.

    The curvature that the search has seen proposes a step; the gradient at a design along it corrects the
    curvature and the length of the step, until the steps together explain the gradient. On a quadratic objective these
    are the steps of conjugate gradients.
    """
    known = lagrangian.curvature(z)
    size = float(np.linalg.norm(rest))
    B = np.eye(free.shape[1]) * size / NEARBY if known is None else free.T @ known @ free
    left, total = free.T @ rest, np.zeros(free.shape[1])
    for _ in range(TRIALS):
        step = np.linalg.lstsq(B, left)[0]  # of a direction that nothing depends on: none
        change = lagrangian.change(z, free @ step)
        if change is None:
            return np.asarray(free @ (total + step))
        along = free.T @ change
        corrected = with_change(B, step, along)
        if corrected is None:
            return None
        longer = float(step @ left) / float(step @ along)  # to the least value along the step
        B, total, left = corrected, total + longer * step, left - longer * along
        if np.linalg.norm(left) <= PREDICTED * size or relative(free @ total, z) > FAR:
            break
    return np.asarray(free @ total)


def with_change(B: Array, step: Array, change: Array) -> Array | None:
    """A positive definite matrix corrected so that it maps a step to a change of the gradient (p, p).

    The formula is that of Broyden, Fletcher, Goldfarb and Shanno. None where the gradient does not rise along the step.
    """
    along, image = float(step @ change), B @ step
    if along <= CURVED * np.linalg.norm(step) * np.linalg.norm(change):
        return None
    return np.asarray(B + np.outer(change, change) / along - np.outer(image, image) / float(step @ image))


def curvature_from_gradients(changes: Sequence[tuple[Array, Array]]) -> Array | None:
    """A positive definite matrix that maps the steps to other designs to the changes of the gradient there (p, p).

    The farthest design is used first, so that the nearest one has the last word. Directions in which no design lies are
    taken to be as flat as the flattest one known. None where the gradient rises along no step.

    Parameters
    ----------
    changes : steps from a design to others, and the changes of the gradient along them
    """
    ordered = sorted(changes, key=lambda pair: -float(pair[0] @ pair[0]))
    curvatures = [float(s @ y) / float(s @ s) for s, y in ordered if s @ y > 0]
    if not curvatures:
        return None
    B = np.eye(len(ordered[0][0])) * min(curvatures)
    for step, change in ordered:
        corrected = with_change(B, step, change)
        B = B if corrected is None else corrected
    return B
