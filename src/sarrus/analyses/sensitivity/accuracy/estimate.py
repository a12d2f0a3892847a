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
from .defect import Defect, defect
from .stiff_steps import weighted_defects

EPS = float(np.finfo(float).eps)
BODY = 7  # coordinates


class Effects(NamedTuple):
    """What the defect of each step (n, k), and the round-off of all states (k,), do to each response.

    `by_bodies` (2, bodies, k) are the parts of the states of each body in the sum over all steps, and in the square of
    the effect of round-off.
    """

    shares: Array
    noise: Array
    by_bodies: Array

    @property
    def sums(self) -> Array:
        """Sums over all steps of the effects, of their sizes, and of squares of those of round-off (3, k)."""
        return np.array([self.shares.sum(axis=0), abs(self.shares).sum(axis=0), self.noise**2])


def estimated(
    responses: Sequence[Response],
    evaluation: Evaluation,
    effects: Effects,
    vibrations: Array,
) -> tuple[ErrorEstimate, ...]:
    """The errors of responses, the first of those evaluated; `vibrations` as by `lost_vibrations`."""
    k = len(responses)
    rules = np.array([evaluation.rule_error(n) for n in range(k)])
    titles, values = [one.title for one in responses], evaluation.values[:k]
    return estimates(titles, values, effects.sums[:, :k], rules, vibrations)


def estimates(
    titles: Sequence[str], values: Array, sums: Array, rules: Array, vibrations: Array
) -> tuple[ErrorEstimate, ...]:
    """The errors of responses with these values (k,), from `Effects.sums` and the errors of their samples (k,)."""
    by_steps, spread, squares = sums
    columns = values, by_steps + rules, spread + abs(rules), np.sqrt(squares), vibrations
    return tuple(ErrorEstimate(title, *map(float, own)) for title, *own in zip(titles, *columns, strict=True))


def effects_of(system: System, steps: StepsTaken | Pieces, adjoints: Sequence[Array]) -> Effects:
    """What errors of states do by the adjoints of each stretch, as `Stretches` stores them."""
    pieces = stretches(steps)
    defects = [defect(system, own, whole=isinstance(steps, StepsTaken)) for own in pieces]
    pairs = [*zip(pieces, adjoints, strict=True)]
    round_off = np.concatenate([_round_off(own, bars) for own, bars in pairs])
    noise = np.linalg.norm(round_off.sum(axis=1), axis=0)
    linear = np.concatenate([_linear(own, bars) for own, bars in zip(defects, adjoints, strict=True)])
    shares = weighted_defects(system, pieces, adjoints, defects, noise)
    by_steps = linear.sum(axis=0) + _spread(shares - linear.sum(axis=1), linear)
    return Effects(shares, noise, np.array([by_steps, (round_off**2).sum(axis=0)]))


def _linear(own: Defect, adjoints: Array) -> Array:
    """Effects of the defects of each body in each step (n, bodies, k), with an adjoint that is linear within it."""
    ends = zip((own.before, own.after), (adjoints[:, 0], adjoints[:, 1]), strict=True)
    return np.asarray(sum(np.einsum("nsbc,nsbck->nbk", _bodies(d), _bodies(bars)) for d, bars in ends))


def _spread(changes: Array, effects: Array) -> Array:
    """Sums (bodies, k) of changes of the effects of steps (n, k), to which bodies contribute as to these effects."""
    sizes = abs(effects)
    whole = sizes.sum(axis=1)
    changes = np.divide(changes, whole, out=np.zeros_like(whole), where=whole > 0)
    return np.asarray(np.einsum("nbk,nk->bk", sizes, changes))


def _round_off(steps: StepsTaken, adjoints: Array) -> Array:
    """Effects of independent round-off of the states of each body after each step (n, bodies, k)."""
    sizes = EPS * abs(np.concatenate([steps.q, steps.v], axis=1)[1:])
    return np.asarray(np.einsum("nsbc,nsbck->nbk", _bodies(sizes), _bodies(abs(adjoints[:, 1]))))


def _bodies(x: Array) -> Array:
    """Coordinates and velocities of bodies (n, 2, bodies, 7, ...)."""
    return x.reshape(len(x), 2, x.shape[1] // (2 * BODY), BODY, *x.shape[2:])
