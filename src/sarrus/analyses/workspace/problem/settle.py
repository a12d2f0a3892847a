"""Positions that satisfy chosen rows: damped Gauss-Newton steps of least size, from anywhere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg.lapack import dposv

from ....algebra import Array
from .rows import Problem
from .watch import check

CLOSE = 1e-12  # of the largest entry that vanishes, free of units
LONGEST = 0.7  # of one step, free of units
STEPS = 40
DECADES = 5  # over which the distance from a limit is drawn, so that narrow places are found


def newton(
    x: Array, gap_of: Callable[[Array], Array], matrix_of: Callable[[Array], Array], steps: int = STEPS
) -> Array | None:
    """A zero of functions near x by damped steps of least size, from anywhere; nothing, if none is found."""
    damping, gap = 1e-3, gap_of(x)
    size = float(np.linalg.norm(gap))
    for _ in range(steps):
        if abs(gap).max(initial=0.0) <= CLOSE:
            return x
        J = matrix_of(x)
        floor = np.finfo(float).eps * max(float(np.sum(J * J)), 1.0)
        step = damped_step(J, -gap, damping * min(size, 1.0) + floor)
        there = x + step * min(1.0, LONGEST / max(float(np.linalg.norm(step)), 1e-300))
        after = gap_of(there)
        reached = float(np.linalg.norm(after))
        if reached < size:
            x, gap, size, damping = there, after, reached, damping * 0.1
        elif damping > 1e3:
            break
        else:
            damping *= 10
    return x if abs(gap).max(initial=0.0) <= 100 * CLOSE else None


def settle(problem: Problem, q: Array, rows: Array, goal: Array, steps: int = STEPS) -> Array | None:
    """The position near q where rows have given values; nothing, if none is found."""
    return newton(
        q,
        lambda there: problem.values(there)[rows] - goal,
        lambda there: problem.jacobian(there)[rows],
        steps,
    )


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
        reached = np.concatenate([rows, problem.m + problem.limited[i]])
        found = settle(problem, q, reached, np.concatenate([goal, inside]), steps=15)
        if found is None:
            return None
        q = found
    return None


TRIES = 20  # of inverse kinematics
DRAWS = 4  # of random distances from limits, for each start


def reach(problem: Problem, target: Array, starts: Array, random: np.random.Generator) -> Array | None:
    """An admissible position with the outputs at a scaled target; nothing, if none of the nearest starts leads to one.

    Parameters
    ----------
    starts : (count, n) admissible positions, of which `TRIES` are taken, the nearest by their outputs first
    """
    rows, goal = constrained(problem)
    outputs = problem.m + problem.outputs
    both, wanted = np.concatenate([rows, outputs]), np.concatenate([goal, target])
    away = [float(np.linalg.norm(problem.values(q)[outputs] - target)) for q in starts]
    for k in np.argsort(away)[:TRIES]:
        check()
        there = settle(problem, starts[k], both, wanted)
        for _ in range(DRAWS):
            q = None if there is None else drawn_in(problem, there, both, wanted, random)
            if q is not None and allowed(problem, q) and problem.built(q):
                return q
    return None
