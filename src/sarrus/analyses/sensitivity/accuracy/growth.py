"""Growth of the adjoint: how many digits of derivatives are left in chaotic and unstable motions.

Errors of the states of a run are carried to the response, and change what the run is linearized about, as the adjoint
grows from the end of the run backwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ....algebra import Array
from ....results import Pieces, StepsTaken
from ..responses.responses import Response

LATE = 0.1  # [-] of the steps that have an adjoint: the last ones, with which the others are compared
FEW = 2.0  # digits, below which there is a warning
GROWN = 1e5  # by so much, at most, adjoints of regular motions grow: in proportion to their duration
ROUND_OFF = 1e-6  # [-] an adjoint that is so much smaller one step later, and stays so, is round-off there
EPS = float(np.finfo(float).eps)


def growths(steps: StepsTaken | Pieces, adjoints: Sequence[Array]) -> Array:
    """By what the adjoint of each response grows (k,), coordinates and velocities in units of their motion."""
    pieces = steps.pieces if isinstance(steps, Pieces) else (steps,)
    states = np.concatenate([np.concatenate([one.q, one.v], axis=1) for one in pieces])
    sizes = np.einsum("j,njk->nk", np.ptp(states, axis=0), abs(np.concatenate([x[:, 0] for x in adjoints])))
    found = np.ones(sizes.shape[1])
    for k, size in enumerate(sizes.T):
        there = _before_response(size)
        late = there[-max(1, int(LATE * len(there))) :].max()
        found[k] = there.max() / late
    return found


def _before_response(size: Array) -> Array:
    """The sizes up to the time of a response: behind it they are zero, or fall to round-off within one step."""
    later = np.append(np.maximum.accumulate(size[::-1])[::-1][1:], 0.0)
    ends = np.flatnonzero(later < ROUND_OFF * size)
    return size[: ends[0] + 1] if len(ends) else np.ones(1)


def warnings_of_growth(
    steps: StepsTaken | Pieces, responses: Sequence[Response], adjoints: Sequence[Array]
) -> Iterator[str]:
    """One message for each response whose derivatives have few digits."""
    first = steps.pieces[0] if isinstance(steps, Pieces) else steps
    of_states = first.rtol ** (5 / 6 if first.precise else 2 / 3)  # of the order of the error of one period
    for response, growth in zip(responses, growths(steps, adjoints), strict=True):
        digits, most = (-np.log10(growth * x) for x in (of_states, EPS))
        if growth >= GROWN and digits < FEW:
            few = f"about {digits:.0f} digits" if digits >= 1 else "no digit that is right"
            remedy = "Choose smaller tolerances" if most >= FEW else "Choose a shorter run"
            yield (
                f"{response.title}: its derivatives have {few}, as the adjoint grows by {growth:.0e}. {remedy}."
            )
