"""Reachability of a given point, by inverse kinematics from many known positions within the limits."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ..problem.rows import Problem
from ..problem.settle import allowed, constrained, drawn_in, settle
from ..problem.watch import check

DRAWS = 4  # of random distances from limits, for each start


def reach(
    problem: Problem, target: Array, starts: Array, tries: int, random: np.random.Generator
) -> Array | None:
    """An admissible position with the outputs at a scaled target; nothing, if none of the nearest starts leads to one.

    Parameters
    ----------
    starts : (count, n) admissible positions
    tries : how many of them, the nearest by their outputs first
    """
    rows, goal = constrained(problem)
    outputs = problem.m + problem.outputs
    both, wanted = np.concatenate([rows, outputs]), np.concatenate([goal, target])
    away = [float(np.linalg.norm(problem.values(q)[outputs] - target)) for q in starts]
    for k in np.argsort(away)[:tries]:
        check()
        there = settle(problem, starts[k], both, wanted)
        for _ in range(DRAWS):
            q = None if there is None else drawn_in(problem, there, both, wanted, random)
            if q is not None and allowed(problem, q) and problem.built(q):
                return q
    return None
