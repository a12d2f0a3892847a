"""The step from a design to the optimum, predicted from gradients nearby by a quasi-Newton iteration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra import Array
from .point import Infeasible
from .search import Search

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
        seen = [one for one in self.search.gradients.values() if relative(one.z - z, z) >= NEARBY]
        return curvature_from_gradients(
            [(one.z - z, one.slope + self._weights @ one.others - here) for one in seen]
        )

    def change(self, z: Array, step: Array) -> Array | None:
        """The change of the gradient with a step back, from a design nearby; None where none can be simulated."""
        here = self.slope(z)
        for length in self._lengths(z, step):
            try:
                return np.asarray((self.slope(z + length * step) - here) / length)
            except Infeasible:
                continue
        return None

    def _lengths(self, z: Array, step: Array) -> list[float]:
        """Multiples of a step to designs between the limits, backward ones first, then forward ones.

        Of each direction, the step itself if it is neither shorter than `NEARBY` nor longer than `FAR`, and the
        shortest one. A step that ends outside of the limits proves nothing of the curvature.
        """
        size = max(relative(step, z), np.finfo(float).tiny)
        low, high = self.search.variables.ends.T
        found = list[float]()
        for sign in (-1.0, 1.0):
            with np.errstate(divide="ignore", invalid="ignore"):
                to_limits = np.where(sign * step > 0, high - z, z - low) / abs(step)
            most = float(np.nanmin(np.where(step == 0, np.inf, to_limits)))
            lengths = {float(np.clip(1.0, NEARBY / size, FAR / size)), NEARBY / size}
            found += [sign * min(length, most) for length in sorted(lengths, reverse=True)]
        return [length for length in found if abs(length) * size >= 0.5 * NEARBY]


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
    found = np.eye(len(ordered[0][0])) * min(curvatures)
    for step, change in ordered:
        corrected = with_change(found, step, change)
        found = found if corrected is None else corrected
    return found
