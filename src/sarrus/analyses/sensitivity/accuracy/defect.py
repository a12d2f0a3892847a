"""Effect of local errors on responses: the defect of the motion between nodes, weighted by the adjoint.

Between its nodes a run is the motion u = (q, v) that `Trajectory` reports: on the constraints, with accelerations that
satisfy the equations of motion. It is exact for u' = (v, a) + d with the defect d, and d changes a response by
∫ ȳᵀ d dt. The adjoint ȳ being linear within a step, from ȳ₀ to ȳ₁, the integral by parts needs no derivative of u,

    ∫ ȳᵀ (u' - f) dt = ȳ₁ᵀ (u₁ - ū) + ȳ₀ᵀ (ū - u₀) - h Σ w ȳ(s)ᵀ f(s),    ū = Σ w u(s),    f = (v, a).

This needs nothing of the method but its nodes. Gauss's points are inside the step, and so forces may jump at its ends.
Where they do not, Lobatto's rule of the same degree has one point less inside, and the ends, whose states are there.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....system import System
from ....system.curves.time_derivatives import timed
from ...dynamics.inputs.force_arguments import forces, has_kinks
from ..sampling.settled import Settled, settled

POINTS = 3  # of Gauss's rule, of degree 5: with the step an error of order seven, of orders up to five
POINTS_OF_ORDER_TWO = 2  # of degree 3
FEW = 200  # steps of short runs, whose states at these points are stored
LOBATTO = (1 + np.array([-1.0, 1.0]) / np.sqrt(5)) / 2, np.full(2, 5 / 12)  # points inside, of degree 5
OF_ENDS = 1 / 12  # their weight in this rule


class Defect(NamedTuple):
    """Weights of the adjoints before and after each step in its part of the error (n, 2 nq).

    states : at all points of Gauss's rule, if the steps are few
    """

    before: Array
    after: Array
    states: Settled | None = None

    def weighted(self, adjoints: Array) -> Array:
        """The part of each step in the error of each response (n, k); adjoints (n, 2, 2 nq, k)."""
        return np.asarray(
            np.einsum("nj,njk->nk", self.before, adjoints[:, 0])
            + np.einsum("nj,njk->nk", self.after, adjoints[:, 1])
        )


def defect(system: System, steps: StepsTaken, which: Array | None = None, *, whole: bool = False) -> Defect:
    """The defect of all steps, or of those chosen by their numbers; whether they are the `whole` run."""
    which = np.arange(len(steps)) if which is None else which
    few = len(which) <= FEW
    if whole and not few and not _jumps(system, steps):
        (s, w), of_ends = LOBATTO, OF_ENDS
    else:
        (s, w), of_ends = rule(POINTS if steps.precise else POINTS_OF_ORDER_TWO), 0.0
    h = np.diff(steps.t)[which, None]
    found = settled(system, steps, (steps.t[which, None] + h * s).ravel(), shortest=False)
    q, v, a = (x.reshape(len(h), len(s), -1) for x in (found.q, found.v, found.a))
    first, last = _nodes(system, steps, which)
    mean, early, late = _sums(w, q, v), _sums(w * (1 - s), v, a), _sums(w * s, v, a)
    if of_ends:
        mean += of_ends * (first + last)
        early += of_ends * _rates(steps, which)
        late += of_ends * _rates(steps, which + 1)
    return Defect(mean - first - h * early, last - mean - h * late, found if few else None)


def _jumps(system: System, steps: StepsTaken) -> bool:
    """Whether forces may jump at the ends of steps, or these are no exact states."""
    moves = timed(system) or bool(forces(system, has_kinks)) or np.any(steps.memory != steps.memory[:1])
    return bool(moves) or not steps.precise


def _rates(steps: StepsTaken, nodes: Array) -> Array:
    return np.concatenate([steps.v[nodes], steps.a[nodes]], axis=1)


def _sums(weights: Array, *states: Array) -> Array:
    """Weighted sums over the points of each step (n, ...), of states (n, points, nq) side by side."""
    return np.concatenate([np.einsum("s,nsj->nj", weights, one) for one in states], axis=1)


@cache
def rule(points: int) -> tuple[Array, Array]:
    """Gauss's points and weights between 0 and 1."""
    x, w = np.polynomial.legendre.leggauss(points)
    return (x + 1) / 2, w / 2


@cache
def slopes(points: int) -> Array:
    """Slopes at Gauss's points by values at 0, at these points and at 1 (points, points + 2), of one polynomial."""
    x = np.concatenate([[0.0], rule(points)[0], [1.0]])
    powers = np.arange(len(x))
    of_powers = powers * x[1:-1, None] ** np.maximum(powers - 1, 0)
    return np.asarray(of_powers @ np.linalg.inv(x[:, None] ** powers))


def _nodes(system: System, steps: StepsTaken, which: Array) -> Array:
    """States before and after steps, on the constraints; velocities of methods of order two are only near them."""
    ends = np.stack([which, which + 1])
    if steps.precise:
        return np.concatenate([steps.q[ends], steps.v[ends]], axis=2)
    at, place = np.unique(ends, return_inverse=True)
    v = settled(system, steps, steps.t[at], shortest=False).v
    return np.concatenate([steps.q[ends], v[place.reshape(ends.shape)]], axis=2)
