"""Growth of the adjoint: how many digits of derivatives are left in chaotic and unstable motions.

Errors of the states of a run are carried to the response, and change what the run is linearized about, as the adjoint
grows from the end of the run backwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ....algebra import Array
from ....results import Pieces, StepsTaken
from ..chain.chain import Nodes
from ..responses.responses import Response

FEW = 2.0  # digits, below which there is a warning
GROWN = 1e5  # by so much, at most, adjoints of regular motions grow: in proportion to their duration
EPS = float(np.finfo(float).eps)


def growths(steps: StepsTaken | Pieces, given: Nodes, adjoints: Sequence[Array]) -> Array:
    """The largest adjoint of each response (k,) over all that it takes from states by itself.

    Both are in units of the response: gradients times how much coordinates, velocities, accelerations and multipliers
    vary within the run, and those by times of events times its duration. Of regular motions this is about one.
    """
    pieces = steps.pieces if isinstance(steps, Pieces) else (steps,)
    varied = {
        name: np.ptp(np.concatenate([getattr(one, name) for one in pieces]), axis=0)
        for name in ("q", "v", "a", "lam")
    }
    states = np.concatenate([varied["q"], varied["v"]])
    largest = np.einsum("j,njk->nk", states, abs(np.concatenate([x[:, 0] for x in adjoints]))).max(axis=0)
    own = (pieces[-1].t[-1] - pieces[0].t[0]) * abs(given.shift).sum(axis=0)
    for name, size in varied.items():
        own = own + np.einsum("j,njk->k", size, abs(getattr(given, name)))
    grown: Array = np.maximum(np.divide(largest, own, out=np.ones_like(own), where=own > 0), 1.0)
    return grown


def warnings_of_growth(
    steps: StepsTaken | Pieces, responses: Sequence[Response], given: Nodes, adjoints: Sequence[Array]
) -> Iterator[str]:
    """One message for each response whose derivatives have few digits."""
    first = steps.pieces[0] if isinstance(steps, Pieces) else steps
    of_states = first.rtol ** (5 / 6 if first.precise else 2 / 3)  # of the order of the error of one period
    for response, growth in zip(responses, growths(steps, given, adjoints), strict=True):
        digits, most = (-np.log10(growth * x) for x in (of_states, EPS))
        if growth >= GROWN and digits < FEW:
            few = f"about {digits:.0f} digits" if digits >= 1 else "no digit that is right"
            remedy = "Choose smaller tolerances" if most >= FEW else "Choose a shorter run"
            yield (
                f"{response.title}: its derivatives have {few}, as the adjoint grows by {growth:.0e}. {remedy}."
            )
