"""Starts of singular curves: where a determinant changes its sign on a random walk, a curve was crossed.

The determinant is that of the gradients of the constraints and of what is lost, so many as there are coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ....algebra import Array
from ....linalg.svd import singular
from ..problem.random_positions import Samples
from ..problem.rows import Problem
from ..problem.settle import allowed, constrained, settle
from .newton import Tally
from .seeds import Start, onto
from .stratum import Stratum

WALK = 20  # positions of a walk
HALVINGS = 24
MOST = 3000  # positions that are walked to


def can_change(problem: Problem) -> bool:
    """Whether there are as many gradients as coordinates."""
    stratum = Stratum(problem, frozenset())
    return len(stratum.pushing) + len(stratum.normal) == problem.n


def changes(problem: Problem, seed: int, tally: Tally) -> Iterator[Start]:
    """Points of singular curves without active limits, on random walks."""
    samples = Samples(problem, seed)
    for _ in range(MOST // WALK):
        q = next(samples, None)
        if q is None:
            return
        yield from changes_along(problem, [q, *samples.walks(q, WALK)], tally)


def changes_along(problem: Problem, walk: Sequence[Array], tally: Tally) -> Iterator[Start]:
    """Points of singular curves without active limits, from admissible positions of a walk on both sides of them."""
    stratum = Stratum(problem, frozenset())
    rows = np.concatenate([stratum.pushing, stratum.normal])
    signs = [_sign(problem, rows, q) for q in walk]
    for n in np.flatnonzero(np.diff(signs)).tolist():
        x = _between(stratum, rows, walk[n], walk[n + 1], tally)
        if x is not None and allowed(problem, x[: problem.n]) and problem.built(x[: problem.n]):
            yield Start(stratum.key, x)


def _sign(problem: Problem, rows: Array, q: Array) -> float:
    return float(np.linalg.slogdet(problem.jacobian(q)[rows])[0])


def _between(stratum: Stratum, rows: Array, a: Array, b: Array, tally: Tally) -> Array | None:
    """A point of a singular curve between positions with different signs; nothing, if no motion leads there."""
    problem = stratum.problem
    held, goal = constrained(problem)
    sign = _sign(problem, rows, a)
    for _ in range(HALVINGS):
        middle = settle(problem, 0.5 * (a + b), held, goal, steps=12)
        if middle is None:
            return None
        a, b = (middle, b) if _sign(problem, rows, middle) == sign else (a, middle)
    pushes = singular(problem.jacobian(a)[rows])[0][:, -1]
    return onto(stratum, np.concatenate([a, pushes]), tally, steps=8)
