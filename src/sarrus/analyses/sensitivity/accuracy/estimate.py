"""Goal-oriented estimate of the global error of responses of a run.

The motion of a run solves the equations of motion but for a defect d. The adjoint ȳ of the run carries it to the
response, so that to leading order

    J(run) - J(exact) = ∫ ȳᵀ d dt + (rule - integral) of the response itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results import ErrorEstimate, Pieces, StepsTaken
from ....results.motion.steps import stretches
from ....system import System
from ..responses.evaluation import Evaluation
from ..responses.responses import Response
from .stiff_steps import weighted_defects

EPS = float(np.finfo(float).eps)


class Effects(NamedTuple):
    """What the defect of each step (n, k), and the round-off of all states (k,), do to each response."""

    shares: Array
    noise: Array


def estimated(
    responses: Sequence[Response],
    evaluation: Evaluation,
    effects: Effects,
) -> tuple[ErrorEstimate, ...]:
    """The errors of responses, the first of those evaluated."""
    shares, noise = effects.shares[:, : len(responses)], effects.noise[: len(responses)]
    rules = np.array([evaluation.rule_error(n) for n in range(len(responses))])
    columns = (
        evaluation.values[: len(responses)],
        shares.sum(0) + rules,
        abs(shares).sum(0) + abs(rules),
        noise,
    )
    titles = (response.title for response in responses)
    return tuple(ErrorEstimate(title, *map(float, own)) for title, *own in zip(titles, *columns, strict=True))


def effects_of(system: System, steps: StepsTaken | Pieces, adjoints: Sequence[Array]) -> Effects:
    """What errors of states do by the adjoints of each stretch, as `Stretches` stores them."""
    pieces = stretches(steps)
    noise = np.sqrt(sum(_round_off(own, bars) for own, bars in zip(pieces, adjoints, strict=True)))
    return Effects(weighted_defects(system, pieces, adjoints, noise), noise)


def _round_off(steps: StepsTaken, adjoints: Array) -> Array:
    """The square of what independent round-off of all states does to each response (k,)."""
    sizes = EPS * abs(np.concatenate([steps.q, steps.v], axis=1)[1:])
    return np.asarray((np.einsum("nj,njk->nk", sizes, abs(adjoints[:, 1])) ** 2).sum(0))
