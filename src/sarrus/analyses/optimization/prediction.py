"""The step from a design to the optimum, predicted from gradients nearby by a quasi-Newton iteration."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...algebra import Array
from .curvature import curvature_from_gradients, with_change
from .problem import Infeasible
from .search import Search

TRIALS = 8  # designs nearby whose gradients are computed at most
NEARBY = 1e-4  # [-] relative change of a variable there at least, above the noise of simulations
PREDICTED = (
    1e-3  # [-] of a gradient, that the predicted step may leave: in a narrow valley most of it points across
)
FAR = 0.1  # [-] relative change of a variable from which the prediction need not be more exact


def relative(change: Array, z: Array) -> float:
    """The largest change of a variable, over its value or its size."""
    return float(np.max(abs(change) / np.maximum(abs(z), 1.0)))


class Lagrangian:
    """The gradient of an objective with weighed constraints, where designs can be simulated.

    Parameters
    ----------
    search : Search
    weights : multipliers of the constrained responses (c,)
    slope_of : the gradient of the objective, where it is known otherwise than from `Search.slope`
    """

    def __init__(
        self, search: Search, weights: Array, slope_of: Callable[[Array], Array] | None = None
    ) -> None:
        self.search, self._weights, self._slope_of = search, weights, slope_of

    def slope(self, z: Array) -> Array:
        """The gradient (p,).

        Raises
        ------
        Infeasible
            If the design cannot be simulated.
        """
        search = self.search
        search.point(z).values  # noqa: B018
        slope = (self._slope_of or search.slope)(z)
        return slope + self._weights @ search.other_slopes(z) if self._weights.any() else slope

    def curvature(self, z: Array) -> Array | None:
        """What the gradients of the search imply of the second derivatives at a design (p, p)."""
        here = self.slope(z)
        seen = self.search.gradients.values()
        return curvature_from_gradients(
            [(one.z - z, one.slope + self._weights @ one.others - here) for one in seen]
        )

    def change(self, z: Array, step: Array) -> Array | None:
        """The change of the gradient with a step back, from designs nearby; None where none can be simulated."""
        low, high = self.search.variables.ends.T
        longer = max(1.0, NEARBY / relative(step, z))
        here = self.slope(z)
        for sign in (-1.0, 1.0):
            there = z + sign * longer * step
            if np.any((there < low) | (there > high)):
                continue
            try:
                return np.asarray((self.slope(there) - here) / (sign * longer))
            except Infeasible:
                continue
        return None


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
