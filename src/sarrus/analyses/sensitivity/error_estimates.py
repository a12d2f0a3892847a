"""Goal-oriented estimate of the global error of responses of a run: the defect of the motion, weighted by the adjoint.

The motion of a run solves the equations of motion but for a defect d. The adjoint ȳ of the run carries it to the
response, so that to leading order

    J(run) - J(exact) = ∫ ȳᵀ d dt + (rule - integral) of the response itself.

Between its nodes a run is the motion u = (q, v) that `Trajectory` reports: on the constraints, with accelerations that
satisfy the equations of motion. It is exact for u' = (v, a) + d with the defect d, and d changes a response by
∫ ȳᵀ d dt. The adjoint ȳ being linear within a step, from ȳ₀ to ȳ₁, the integral by parts needs no derivative of u,

    ∫ ȳᵀ (u' - f) dt = ȳ₁ᵀ (u₁ - ū) + ȳ₀ᵀ (ū - u₀) - h Σ w ȳ(s)ᵀ f(s),    ū = Σ w u(s),    f = (v, a).

This needs nothing of the method but its nodes. Gauss's points are inside the step, and so forces may jump at its ends.
Where they do not, Lobatto's rule of the same degree has one point less inside, and the ends, whose states are there.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...results import ErrorEstimate, Segments, StepsTaken
from ...results.motion.steps import segments_of
from ...system import System
from ...system.curves.time_derivatives import timed
from ..dynamics.inputs.force_arguments import forces, has_kinks
from .responses.evaluation import Evaluation
from .responses.responses import Response
from .sampling.settled import settled

EPS = float(np.finfo(float).eps)
# Points of Gauss's rules by whether steps are precise, of degrees 5 and 3: with the step errors of order 7 and 5
POINTS = {True: 3, False: 2}
# Points inside, their weights and that of the ends in Lobatto's rules of the same degrees
LOBATTO = {
    True: ((1 + np.array([-1.0, 1.0]) / np.sqrt(5)) / 2, np.full(2, 5 / 12), 1 / 12),
    False: (np.full(1, 0.5), np.full(1, 2 / 3), 1 / 6),
}


class Effects(NamedTuple):
    """What the defect of each step (n, k), and the round-off of all states (k,), do to each response."""

    shares: Array
    noise: Array


def estimated(
    responses: Sequence[Response], evaluation: Evaluation, effects: Effects
) -> tuple[ErrorEstimate, ...]:
    """The errors of the responses that were evaluated."""
    rules = np.array([evaluation.rule_error(n) for n in range(len(responses))])
    by_steps, spread = effects.shares.sum(axis=0), abs(effects.shares).sum(axis=0)
    columns = evaluation.values, by_steps + rules, spread + abs(rules), effects.noise
    rows = zip(responses, *columns, strict=True)
    return tuple(ErrorEstimate(one.title, *map(float, own)) for one, *own in rows)


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


class Defect(NamedTuple):
    """Weights of the adjoints before and after each step in its part of the error (n, 2 nq)."""

    before: Array
    after: Array

    def weighted(self, adjoints: Array) -> Array:
        """The part of each step in the error of each response (n, k); adjoints (n, 2, 2 nq, k)."""
        return np.asarray(
            np.einsum("nj,njk->nk", self.before, adjoints[:, 0])
            + np.einsum("nj,njk->nk", self.after, adjoints[:, 1])
        )


def defect(system: System, steps: StepsTaken, *, whole: bool) -> Defect:
    """The defect of all steps; whether they are the `whole` run."""
    gauss = not whole or _jumps(system, steps)
    s, w, of_ends = (*rule(POINTS[steps.precise]), 0.0) if gauss else LOBATTO[steps.precise]
    h = np.diff(steps.t)[:, None]
    found = settled(system, steps, (steps.t[:-1, None] + h * s).ravel(), shortest=False)
    q, v, a = (x.reshape(len(h), len(s), -1) for x in (found.q, found.v, found.a))
    # velocities of methods of order two are only near the constraints
    nodes = steps if steps.precise else settled(system, steps, steps.t, shortest=False)
    states, rates = (np.concatenate(x, axis=1) for x in ((steps.q, nodes.v), (nodes.v, nodes.a)))
    first, last = states[:-1], states[1:]
    mean, early, late = _sums(w, q, v), _sums(w * (1 - s), v, a), _sums(w * s, v, a)
    if not gauss:
        mean += of_ends * (first + last)
        early += of_ends * rates[:-1]
        late += of_ends * rates[1:]
    return Defect(mean - first - h * early, last - mean - h * late)


def _jumps(system: System, steps: StepsTaken) -> bool:
    """Whether forces may jump at the ends of steps."""
    moves = timed(system) or bool(forces(system, has_kinks)) or np.any(steps.memory != steps.memory[:1])
    return bool(moves)


def _sums(weights: Array, *states: Array) -> Array:
    """Weighted sums over the points of each step (n, ...), of states (n, points, nq) side by side."""
    return np.concatenate([np.einsum("s,nsj->nj", weights, one) for one in states], axis=1)


@cache
def rule(points: int) -> tuple[Array, Array]:
    """Gauss's points and weights between 0 and 1."""
    x, w = np.polynomial.legendre.leggauss(points)
    return (x + 1) / 2, w / 2
