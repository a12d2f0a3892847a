"""Errors of derivatives of runs with corners and events: derivatives of the estimated error of the response.

In a short contact a small change of a parameter moves all steps to another place on the force law. The error of the
response, E = ∫ ȳᵀ d dt, then changes by many times its own size. As

    J(run) = J(exact) + E,    dJ(run)/db - dJ(exact)/db = dE/db,

the change of E with b is the error of the derivative, to leading order in d: that of the defects and of the adjoints.
As only the size of the errors is wanted, dE/db is a difference of two backward sweeps: of the run, and of its states
moved by a small multiple of their changes with b. Moved states fulfil the equations of the steps but for the square of
this multiple, which is less than errors of methods of order two; others need central differences.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ....algebra import Array
from ....model.announcement import collecting
from ....results import Assembly, Pieces, StepsTaken
from ....results.motion.steps import stretches
from ....system import System
from ..parameters.parameters import Parameters
from .change_errors import comparable, without_curves
from .defect import defect

DRAWN = 2  # random changes of the parameters: their root mean square is below a tenth of the truth in 1 % of cases
SHORT = (
    0.1  # of the median step between corners: the last step before a corner ends where the corner is found
)


def errors_of_steps(system: System, steps: StepsTaken | Pieces, adjoints: Sequence[Array]) -> Array:
    """Errors of responses (k,) by all steps, with an adjoint that is linear within each.

    Short last steps before corners and events have no error, but would have one where the end of a moved step is beyond
    the corner. They are left out.
    """
    errors = np.zeros(adjoints[0].shape[-1])
    for own, bars in zip(stretches(steps), adjoints, strict=True):
        h = np.diff(own.t)
        count = len(h) - int(len(h) > 1 and h[-1] < SHORT * np.median(h))
        errors += defect(system, own).weighted(bars)[:count].sum(axis=0)
    return errors


def by_changes_of_errors(
    parameters: Parameters, found: Array, span: tuple[Assembly, float],
    errors: Callable[[], Array] | None, moved: Callable[[Array], tuple[Array, float]],
) -> Array | None:  # fmt: skip
    """Relative errors of derivatives (k,), or None if only tables and formulas act, or none of the parameters.

    Parameters
    ----------
    found : derivatives by the parameters (k, p)
    span : start of the run, and its end [s]
    errors : estimates the errors of the responses of the run (k,); None for central differences
    moved : estimates those of a run moved by a small multiple of a change of the parameters, and gives this multiple
    """
    weights = without_curves(parameters, comparable(parameters, found, *span))
    if not (np.isfinite(weights).all() and weights.any()):
        return None
    with collecting():  # warnings of moved runs are those of the run
        here, squares = errors() if errors else None, np.zeros(len(found))
        for direction in directions(weights):
            there, small = moved(direction)
            before, step = (here, small) if here is not None else (moved(-direction)[0], 2 * small)
            squares += ((there - before) / step) ** 2
    sizes = np.linalg.norm(found * weights, axis=1)
    relative = np.divide(np.sqrt(squares), sizes, out=np.zeros_like(sizes), where=sizes > 0)
    return relative if np.isfinite(relative).all() else None


def directions(weights: Array) -> Array:
    """Changes of the parameters (n, p), whose effects on a response have squares with about the sum of those of all."""
    felt = np.flatnonzero(weights)
    if len(felt) <= DRAWN:
        return np.asarray(weights * np.eye(len(weights))[felt])
    drawn = np.random.default_rng(1).standard_normal((DRAWN, len(weights)))
    return np.asarray(weights * drawn / np.sqrt(DRAWN))
