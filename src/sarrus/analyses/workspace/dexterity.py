"""Manipulability and conditioning of a mechanism at a position."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...linalg.svd import singular
from ...linalg.threads import one_thread_if_small
from ...model import SarrusError
from ...model.announcement import reports_warnings
from ...results import ResultList
from ...system import System
from ..arguments import refuse_for_positions
from .problem.formulation import formulate
from .problem.rows import Problem
from .problem.settle import constrained


class Dexterity(NamedTuple):
    """Manipulability and dexterity of a mechanism at positions.

    `jacobian` is (outputs, inputs) du/dv; `manipulability` sqrt(det J Jᵀ), the area of the outputs' ellipse over π for
    unit rates of the inputs; `condition` the ratio of its axes, 1 if all directions are equal, infinite if one is
    lost; `conditioning` its inverse.
    """

    jacobian: Array
    manipulability: float
    condition: float

    @property
    def conditioning(self) -> float:
        """The conditioning: 1 if all directions are equal, 0 if one is lost."""
        return 1 / self.condition


@reports_warnings
@one_thread_if_small
def dexterity(
    system: System,
    q: ArrayLike,
    output: Iterable[Any],
    inputs: Iterable[Any],
    *,
    fixed: Mapping[Any, float] | None = None,
    strict: bool = False,
) -> list[Dexterity]:
    """Compute manipulability and dexterity at given positions.

    Parameters
    ----------
    system : System
    q : (nq,) or (k, nq) positions that satisfy the constraints
    output, inputs : functions of the position
    fixed : functions that keep their values
    strict : raise the first warning as a `StrictError`
    """
    refuse_for_positions(system, "dexterity")
    problem = formulate(system, output, fixed=fixed, inputs=inputs, singular="inputs")
    positions = np.atleast_2d(np.asarray(q, dtype=float))
    if positions.shape[-1] != problem.n or not np.isfinite(positions).all():
        message = (
            f"q must be finite coordinates, shape ({problem.n},) or (k, {problem.n}), got {positions.shape}"
        )
        raise SarrusError(f"{message}. Pass system.q0 or a result's q.")
    if len(problem.normal) not in (problem.freedoms, problem.freedoms + len(problem.held)):
        message = f"{system.name}: {problem.freedoms} degrees of freedom, but {len(problem.normal)} inputs"
        raise SarrusError(f"{message}. Give as many inputs.")
    positions = positions / problem.scale
    return ResultList(dexterity_at(problem, one, problem.normal) for one in positions)


def dexterity_at(problem: Problem, q: Array, inputs: Array) -> Dexterity:
    """The same at a scaled position; inputs by their places in the table."""
    J = problem.jacobian(q)
    rows, _ = constrained(problem)
    free = problem.n - len(rows)
    Z = singular(J[rows])[2][problem.n - free :].T
    U, V = (J[problem.m + k] @ Z * problem.units[k][:, None] for k in (problem.outputs, inputs))
    found = U @ _inverse(V)
    sizes = singular(found)[1]
    condition = float(sizes[0] / sizes[-1]) if sizes[-1] > 0 else np.inf
    return Dexterity(found, float(np.prod(sizes)), condition)


def _inverse(matrix: Array) -> Array:
    """The pseudoinverse, as of `np.linalg.pinv`."""
    left, sizes, right = singular(matrix)
    k = np.flatnonzero(sizes > np.finfo(float).eps * max(matrix.shape) * sizes.max(initial=0.0))
    return np.asarray(right[k].T / sizes[k] @ left[:, k].T)
