"""The curvature that gradients at several designs imply: the formula of Broyden, Fletcher, Goldfarb and Shanno."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra import Array

CURVED = 1e-10  # [-] cosine between steps and changes of the gradient, below which there is no curvature along a step


def with_change(B: Array, step: Array, change: Array) -> Array | None:
    """A positive definite matrix corrected so that it maps a step to a change of the gradient (p, p).

    None where the gradient does not rise along the step.
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
