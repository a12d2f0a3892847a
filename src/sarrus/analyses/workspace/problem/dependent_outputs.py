"""Outputs that do not change, or that depend on each other, are refused: they have no map."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....linalg.svd import singular
from ....model import SarrusError
from .random_positions import Samples
from .rows import Problem
from .settle import constrained

POSITIONS = 3  # random ones: at each of them outputs can be dependent by chance only if it is singular
# Of gradients of length 1: what round-off leaves of the motions that an output does not follow
DEPENDENT = 1e-9


def refuse_dependent(problem: Problem) -> None:
    """Refuse outputs whose gradients along the free motions are dependent at all of some random positions.

    Raises
    ------
    SarrusError
    """
    slopes = [_slopes(problem, q) for _, q in zip(range(POSITIONS), Samples(problem, seed=11), strict=False)]
    if not slopes:
        return
    names = [problem.table[k].name for k in problem.outputs]
    for k, name in enumerate(names):
        if all(np.linalg.norm(U[k]) < DEPENDENT for U in slopes):
            message = f"output: {name} does not change in any motion of {problem.system.name}"
            raise SarrusError(f"{message}. Choose another output.")
    if all(_rank(U) < len(names) for U in slopes):
        message = (
            f"output: {', '.join(names[:-1])} and {names[-1]} depend on each other, so that they cover no"
        )
        raise SarrusError(
            f"{message} {'area' if len(names) == 2 else 'volume'}. Choose fewer or other outputs."
        )


def _slopes(problem: Problem, q: Array) -> Array:
    """Return the derivatives of the outputs along the free directions, for gradients of length 1."""
    J = problem.jacobian(q)
    rows, _ = constrained(problem)
    Z = singular(J[rows])[2][len(rows) :].T
    U = J[problem.m + problem.outputs]
    lengths = np.linalg.norm(U, axis=1, keepdims=True)
    return np.asarray(U @ Z / np.where(lengths > 0, lengths, 1.0))


def _rank(slopes: Array) -> int:
    return int(np.count_nonzero(singular(slopes)[1] > DEPENDENT))
