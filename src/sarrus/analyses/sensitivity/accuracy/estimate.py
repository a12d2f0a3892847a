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
from ....results import ErrorEstimate, Segments, StepsTaken
from ....results.motion.steps import segments_of
from ....system import System
from ..responses.evaluation import Evaluation
from ..responses.responses import Response
from .defect import defect

EPS = float(np.finfo(float).eps)


class Effects(NamedTuple):
    """What the defect of each step (n, k), and the round-off of all states (k,), do to each response."""

    shares: Array
    noise: Array

    @property
    def sums(self) -> Array:
        """Sums over all steps of the effects, of their sizes, and of squares of those of round-off (3, k)."""
        return np.array([self.shares.sum(axis=0), abs(self.shares).sum(axis=0), self.noise**2])


def estimated(
    responses: Sequence[Response], evaluation: Evaluation, effects: Effects
) -> tuple[ErrorEstimate, ...]:
    """The errors of the responses that were evaluated."""
    rules = np.array([evaluation.rule_error(n) for n in range(len(responses))])
    return estimates([one.title for one in responses], evaluation.values, effects.sums, rules)


def estimates(titles: Sequence[str], values: Array, sums: Array, rules: Array) -> tuple[ErrorEstimate, ...]:
    """The errors of responses with these values (k,), from `Effects.sums` and the errors of their samples (k,)."""
    by_steps, spread, squares = sums
    columns = values, by_steps + rules, spread + abs(rules), np.sqrt(squares)
    return tuple(ErrorEstimate(title, *map(float, own)) for title, *own in zip(titles, *columns, strict=True))


def effects_of(system: System, steps: StepsTaken | Segments, adjoints: Sequence[Array]) -> Effects:
    """What errors of states do by the adjoints of each segment, as `BackSweep` stores them."""
    segments = segments_of(steps)
    whole, pairs = isinstance(steps, StepsTaken), list(zip(segments, adjoints, strict=True))
    shares = np.concatenate([defect(system, own, whole=whole).weighted(bars) for own, bars in pairs])
    noise = np.linalg.norm(np.concatenate([_round_off(own, bars) for own, bars in pairs]), axis=0)
    return Effects(shares, noise)


def _round_off(steps: StepsTaken, adjoints: Array) -> Array:
    """Effects of independent round-off of the states after each step (n, k)."""
    sizes = EPS * abs(np.concatenate([steps.q, steps.v], axis=1)[1:])
    return np.asarray(np.einsum("nc,nck->nk", sizes, abs(adjoints[:, 1])))
