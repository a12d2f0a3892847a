"""Where the inputs of a mechanism lose control of it, and how well they move its outputs elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...model import SarrusError
from ...results.input_singularities import InputSingularities, SingularCurve
from ...system import System
from .arc import Arc
from .explore import Branch
from .formulate import Limits, formulate
from .mapping import REPEATS, WorkspaceMap
from .problem import Problem


def input_singularities(
    system: System,
    output: Iterable[Any],
    inputs: Iterable[Any],
    *,
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    seed: int = 0,
    repeats: int = REPEATS,
) -> InputSingularities:
    """Trace positions at which a motion is possible while all inputs stand still: Φ_qᵀ lam + V_qᵀ ν = 0.

    There the inputs cannot bear a load, and ways of assembly meet (type 2, or parallel, singularities).

    Parameters
    ----------
    system, limits, seed, repeats : see `sarrus.workspace`; the curves end at limits
    output : two functions that are drawn
    inputs : as many functions as there are degrees of freedom
    fixed : values of functions, one for each degree of freedom beyond two, which choose a section

    Raises
    ------
    SarrusError
        If the numbers of inputs or fixed functions do not fit the degrees of freedom.
    """
    problem = formulate(system, output, limits=limits, fixed=fixed, inputs=inputs, singular="inputs")
    _refuse_counts(problem)
    map_ = WorkspaceMap.of(problem, seed, repeats).run()
    trouble = [branch.trouble for branch in map_.branches if branch.trouble]
    told = (
        f"{len(trouble)} curves were lost, the first because {trouble[0]}" if trouble else "no curve was lost"
    )
    return InputSingularities(
        system.name,
        tuple(problem.table[k].name for k in problem.outputs),
        tuple(problem.table[k].name for k in problem.normal),
        tuple(_curve(branch) for branch in map_.branches),
        "incomplete" if trouble else "mapped",
        f"{system.name}: {told}",
    )


def _refuse_counts(problem: Problem) -> None:
    freedoms, name = problem.freedoms + len(problem.fixed) - len(problem.locked), problem.system.name
    if len(problem.normal) != freedoms:
        told = f"{name} has {freedoms} degrees of freedom, but {len(problem.normal)} inputs are given"
        raise SarrusError(f"{told}; give as many inputs")
    if problem.freedoms != 2:
        told = f"{name} has {problem.freedoms} degrees of freedom beside what is fixed"
        raise SarrusError(f"{told}; fix functions until two are left, so that singularities are curves")


def _curve(branch: Branch) -> SingularCurve:
    p = branch.stratum.problem
    q = np.array([point.x[: p.n] for point in branch.points])
    values = np.array([p.values(one) for one in q])
    closed = branch.start is branch.end and branch.start.kind == "seed"
    return SingularCurve(
        np.array([point.u for point in branch.points]) * p.units[p.outputs],
        Arc(np.array([step.quintic() for step in branch.steps()])).polyline * p.units[p.outputs],
        np.array([p.shown(k, values[:, p.m + k]) for k in p.normal]).T,
        q * p.scale,
        closed,
    )


class Dexterity(NamedTuple):
    """How inputs move outputs at a position.

    `jacobian` is (outputs, inputs) du/dv; `manipulability` sqrt(det J Jᵀ), the area of the outputs' ellipse over π for
    unit rates of the inputs; `condition` the ratio of its axes, 1 where all directions are alike, infinite where one
    is lost; `conditioning` its inverse.
    """

    jacobian: Array
    manipulability: float
    condition: float

    @property
    def conditioning(self) -> float:
        """1 where all directions are alike, 0 where one is lost."""
        return 1 / self.condition


def dexterity(
    system: System,
    q: ArrayLike,
    output: Iterable[Any],
    inputs: Iterable[Any],
    *,
    fixed: Mapping[Any, float] | None = None,
) -> list[Dexterity]:
    """Manipulability and dexterity at positions, such as those of a workspace's curves or of random samples.

    Parameters
    ----------
    system : System
    q : (nq,) or (k, nq) positions that satisfy the constraints
    output, inputs : functions of the position
    fixed : functions that keep their values
    """
    problem = formulate(system, output, fixed=fixed, inputs=inputs, singular="inputs")
    return [_dexterity(problem, one / problem.scale) for one in np.atleast_2d(np.asarray(q, dtype=float))]


def _dexterity(problem: Problem, q: Array) -> Dexterity:
    J = problem.jacobian(q)
    rows = np.concatenate([np.arange(problem.m), problem.m + problem.held])
    free = problem.n - len(rows)
    Z = np.linalg.svd(J[rows], full_matrices=True)[2][problem.n - free :].T
    U, V = (J[problem.m + k] @ Z * problem.units[k][:, None] for k in (problem.outputs, problem.normal))
    found = U @ np.linalg.pinv(V)
    sizes = np.linalg.svd(found, compute_uv=False)
    condition = float(sizes[0] / sizes[-1]) if sizes[-1] > 0 else np.inf
    return Dexterity(found, float(np.prod(sizes)), condition)
