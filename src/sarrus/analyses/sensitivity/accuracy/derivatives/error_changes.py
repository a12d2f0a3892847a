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

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from .....algebra import Array
from .....model.announcement import collecting
from .....results import Pieces, StepsTaken
from .....results.motion.steps import stretches
from .....system import System
from ..defect import defect
from .random_changes import Enough, RandomChanges

# Of the median step between corners: the last step before a corner ends where the corner is found
SHORT = 0.1


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
    random: RandomChanges, found: Array, errors: Callable[[], Array] | None,
    moved: Callable[[Array], tuple[Array, float]], enough: Enough,
) -> Array | None:  # fmt: skip
    """Relative errors of derivatives (k,), or None if only tables and formulas act, or none of the parameters.

    Parameters
    ----------
    found : derivatives by the parameters (k, p)
    errors : estimates the errors of the responses of the run (k,); None for central differences
    moved : estimates those of a run moved by a small multiple of a change of the parameters, and gives this multiple
    enough : whether relative errors by a number of first changes suffice, and the others are left out
    """
    if not (np.isfinite(random.weights).all() and random.weights.any()):
        return None
    with collecting():  # warnings of moved runs are those of the run
        here = errors() if errors else None

        def changes() -> Iterator[Array]:
            for direction in random.each:
                there, small = moved(direction)
                before, step = (here, small) if here is not None else (moved(-direction)[0], 2 * small)
                yield (there - before) / step

        relative = random.first_relative(changes(), found, enough)
    return relative if np.isfinite(relative).all() else None
