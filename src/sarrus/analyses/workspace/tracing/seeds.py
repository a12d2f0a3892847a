"""Starts of candidate curves: from random positions, with random limits active, by damped Newton steps on G = 0."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ..problem.rows import Problem
from ..problem.settle import allowed, damped_step
from .newton import TOLERANCE, Tally
from .stratum import Active, Stratum

STEPS = 25
LONGEST = 0.5
FLOOR = 1e-14


class Start(NamedTuple):
    """A point of a candidate curve and its active limits."""

    key: Active
    x: Array


def random_start(problem: Problem, q: Array, random: np.random.Generator, tally: Tally) -> Start | None:
    """A point of a candidate curve with random limits active, from an admissible position; nothing, if it fails."""
    most = problem.freedoms - len(problem.normal) + 1 if problem.of_outputs else 0
    active = _some_limits(problem, random, most)
    stratum = Stratum(problem, active)
    x = onto(stratum, _guess(stratum, q, random), tally)
    if x is None or not allowed(problem, x[: problem.n]) or not problem.built(x[: problem.n]):
        return None
    return Start(active, x)


def _some_limits(problem: Problem, random: np.random.Generator, most: int) -> Active:
    """A random choice of at most so many limits, each at one of its ends."""
    count = int(random.integers(0, min(most, len(problem.limited)) + 1))
    chosen = random.permutation(len(problem.limited))[:count]
    ends = [[end for end in (0, 1) if np.isfinite(problem.bounds[i, end])] for i in chosen]
    return frozenset((int(i), int(random.choice(end))) for i, end in zip(chosen, ends, strict=True))


def _guess(stratum: Stratum, q: Array, random: np.random.Generator) -> Array:
    """A random normal with the multipliers that balance it best."""
    c = random.normal(size=stratum.k)
    J = stratum.problem.jacobian(q)
    lam = -np.linalg.lstsq(J[stratum.pushing].T, J[stratum.normal].T @ c, rcond=None)[0]
    both = np.concatenate([lam, c])
    return np.concatenate([q, both / np.linalg.norm(both)])


def onto(stratum: Stratum, x: Array, tally: Tally, steps: int = STEPS) -> Array | None:
    """A solution of G(x) = 0 from x by damped steps of least size; nothing, if none is found."""
    linear = stratum.linear(x)
    size, damping = float(np.linalg.norm(linear.G)), 1e-3
    for _ in range(steps):
        if abs(linear.G).max() <= TOLERANCE:
            return x
        step = damped_step(linear.G_x, -linear.G, damping * min(size, 1.0) + FLOOR)
        tally.newton += 1
        tally.factorizations += 1
        there = x + step * min(1.0, LONGEST / max(float(np.linalg.norm(step)), 1e-300))
        after = stratum.linear(there)
        reached = float(np.linalg.norm(after.G))
        if reached < size:
            x, linear, size, damping = there, after, reached, max(0.1 * damping, 1e-12)
        elif damping > 1e3:
            return None
        else:
            damping *= 10
    return x if abs(linear.G).max() <= 1e-10 else None
