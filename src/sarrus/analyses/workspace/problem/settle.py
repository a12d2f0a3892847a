"""Positions that satisfy chosen rows: damped Gauss-Newton steps of least size, from anywhere."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dposv

from ....algebra import Array
from .rows import Problem

CLOSE = 1e-12
LONGEST = 0.7  # of one step, free of units
FLOOR = 1e-14
DECADES = 5  # over which the distance from a limit is drawn, so that narrow places are found


def settle(problem: Problem, q: Array, rows: Array, goal: Array, steps: int = 40) -> Array | None:
    """The position near q where rows have given values; nothing, if none is found."""
    damping, gap = 1e-3, problem.values(q)[rows] - goal
    size = float(np.linalg.norm(gap))
    for _ in range(steps):
        if abs(gap).max(initial=0.0) <= CLOSE:
            return q
        J = problem.jacobian(q)[rows]
        there = _moved(
            q, damped_step(J, -gap, damping * min(size, 1.0) + FLOOR * max(float(np.sum(J * J)), 1.0))
        )
        after = problem.values(there)[rows] - goal
        reached = float(np.linalg.norm(after))
        if reached < size:
            q, gap, size, damping = there, after, reached, max(damping * 0.1, 1e-10)
        elif damping > 1e6:
            return None
        else:
            damping *= 10
    return q if abs(gap).max(initial=0.0) <= 1e-10 else None


def _moved(q: Array, step: Array) -> Array:
    longest = float(np.linalg.norm(step))
    return np.asarray(q + step * min(1.0, LONGEST / max(longest, 1e-300)))


def damped_step(J: Array, right: Array, damping: float) -> Array:
    """The step of least size, Jᵀ (J Jᵀ + d)⁻¹ r; LAPACK itself, since SciPy's checks take longer than the factors."""
    square = J @ J.T
    square[np.diag_indices(len(square))] += damping
    _, found, failed = dposv(square, right)
    return np.asarray(np.linalg.lstsq(J, right, rcond=1e-12)[0] if failed else J.T @ found)


def constrained(problem: Problem) -> tuple[Array, Array]:
    """The rows that every position satisfies, and their values."""
    rows = np.concatenate([np.arange(problem.m), problem.m + problem.held])
    return rows, np.concatenate([np.zeros(problem.m), problem.targets])


def allowed(problem: Problem, q: Array, slack: float = 1e-9) -> bool:
    """Whether a position keeps all limits."""
    return bool(np.all(problem.margins(problem.values(q)) >= -slack))


def drawn_in(
    problem: Problem, q: Array, rows: Array, goal: Array, random: np.random.Generator, rounds: int = 6
) -> Array | None:
    """A position that keeps all limits: those violated are brought to random values inside, some times over."""
    for _ in range(rounds):
        outside = np.argwhere(problem.margins(problem.values(q)) < 0)
        if not len(outside):
            return q
        i, end = outside.T
        width = problem.bounds[i, 1] - problem.bounds[i, 0]
        width = np.where(np.isfinite(width), width, 1.0)
        inside = problem.bounds[i, end] + (1 - 2 * end) * width * 10 ** (-DECADES * random.random(len(i)))
        found = settle(
            problem,
            q,
            np.concatenate([rows, problem.m + problem.limited[i]]),
            np.concatenate([goal, inside]),
            steps=15,
        )
        if found is None:
            return None
        q = found
    return None
