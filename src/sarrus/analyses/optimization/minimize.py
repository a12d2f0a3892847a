"""The best design: solvers of nonlinear programs with exact gradients of simulations."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import Model, announce, collecting, reports_warnings
from ...results import Optimum
from ...system import System
from .combined import Part
from .constraint import Within, gap, refuse_others
from .problem import Infeasible, Problem
from .search import Bounds, Progress, Search, Stuck, Variables
from .solvers import Answer, solver_of

SATISFIED = 1e-6  # [-] of the limit, within which a constraint counts as satisfied


@reports_warnings
def optimize(
    system: System,
    objective: Part | Sequence[Part],
    wrt: Sequence[str] | None = None,
    *,
    until: float,
    bounds: Bounds | None = None,
    constraints: Within | Sequence[Within] = (),
    scale: Mapping[str, float] | None = None,
    design: Mapping[str, float] | None = None,
    formula: Any = None,
    solver: str | None = None,
    second_order: bool = False,
    iterations: int = 100,
    tolerance: float = 1e-8,
    starts: int = 1,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Progress | None = None,
    strict: bool = False,
    **settings: Any,
) -> Optimum:
    """Change numbers of a model so that a response of its motion becomes least.

    Every design is assembled, simulated, and differentiated by one sweep backwards. A design that cannot be simulated
    makes the solver step back; it is counted, and its sentence is kept.

    Parameters
    ----------
    system : with the design at the start
    objective : what is made least, see `sensitivity`, or `Combined`; of several responses their sum
    wrt : names of the design variables, see `sensitivity`
    until : end time of the simulation [s]
    bounds : limits by name, ``{"spring.k": (1, 100), "spring.c": (0, None)}``
    constraints : responses that must stay within limits
    scale : sizes of the variables by name, which the solver takes for 1; by default their values at the start
    design, formula : named design variables, and the function that gives numbers of the model from them
    solver : "L-BFGS-B" (the default), "SLSQP" (the default with constraints), "trust-constr", or "IPOPT" (the extra
        `ipopt`)
    second_order : exact second derivatives of objective and constraints: for "trust-constr" products with vectors, for
        "IPOPT" the Hessian of the Lagrangian, a product for each variable and response (few variables; by default it
        learns one from gradients)
    iterations, tolerance : when the solver ends
    starts : how many designs to start from: the system's own, and others at random between the bounds
    seed : of the random designs
    executor : of ``concurrent.futures``, which runs the starts beside one another
    progress : called with the number of the simulation and the objective; True for lines on standard error
    settings : ``method``, ``rtol``, ``atol``, ``max_step``, ``events``, ``memory`` and ``time_limit``, see `Problem`
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    Optimum
        With ``success`` false and a sentence where the solver did not converge; the best design is kept, also after
        Ctrl-C.

    Raises
    ------
    ValueError
        For bounds of unknown variables, and unknown solvers.
    SarrusError
        If the first design cannot be simulated.
    """
    within = refuse_others([constraints] if isinstance(constraints, Within) else constraints)
    solver_of(solver, bool(within))
    if not tolerance > 0 or iterations < 1:
        raise ValueError(
            f"tolerance and iterations must be greater than 0, but are {tolerance:g} and {iterations}"
        )
    several = (
        list(objective) if isinstance(objective, Sequence) and not isinstance(objective, str) else [objective]
    )
    wanted = [*several, *(one.response for one in within)]
    problem = Problem(system, wanted, wrt, until=until, design=design, formula=formula, **settings)
    task = Task(within, solver, iterations, tolerance, second_order)
    variables = Variables(problem.names, problem.x0, bounds, scale)
    if starts == 1:
        best = task.solved(problem, variables, progress)
        announce(best.warnings)
        return best
    if starts < 1:
        raise ValueError(f"starts must be 1 at least, but is {starts}")
    found = _from_many(task, problem, variables, _designs(variables, starts, seed), executor, progress)
    best = _best(found, len(within))
    announce(best.warnings)
    return best


@dataclass(frozen=True)
class Task:
    """What is the same for all starts."""

    constraints: tuple[Within, ...]
    solver: str | None
    iterations: int
    tolerance: float
    second_order: bool = False

    def solved(self, problem: Problem, variables: Variables, progress: Progress | None = None) -> Optimum:
        """The optimum from one start; of warnings, those of the best design."""
        with collecting():
            return self._searched(problem, variables, progress)

    def _searched(self, problem: Problem, variables: Variables, progress: Progress | None) -> Optimum:
        search = Search(problem, variables, self.constraints, progress)
        solver = solver_of(self.solver, bool(self.constraints), self.second_order)
        try:
            answer = solver(search, self.iterations, self.tolerance)
        except Stuck as stuck:
            answer = Answer(
                False, f"no design ahead can be simulated, the last one since {str(stuck).rstrip('.')}"
            )
        except KeyboardInterrupt:
            answer = Answer(False, "stopped by the user")
        return told(search, answer, max(SATISFIED, self.tolerance))


def told(search: Search, answer: Answer, near: float = SATISFIED) -> Optimum:
    """The best design of a search, with the solver's words; constraints count as satisfied if they are so near."""
    point, problem = search.best, search.problem
    assert point is not None
    values, limited = point.values, search.count
    short = gap(values[limited:], search.constraints)
    success = answer.success and short <= near
    message = answer.message
    if short > near:
        but = "but" if answer.success else "and"
        message += f", {but} a constraint is short of its limit by {short:.2g} of it"
    history = search.history
    tried = f"{len(history)} simulations"
    missed = f" and {len(search.failures)} that failed" if search.failures else ""
    return Optimum(
        problem.names, point.x.copy(), search.variables.x0.copy(), float(values[:limited].sum()),
        float(history[0, 0]), success, f"{message}, after {tried}{missed}",
        history, np.array(search.trace),
        dict(zip(problem.titles[limited:], map(float, values[limited:]), strict=True)),
        failures=tuple(search.failures), seconds=time.perf_counter() - search.began,
        model=point.system.model, run=point.run, warnings=(*point.start.warnings, *point.run.warnings),
    )  # fmt: skip


def _designs(variables: Variables, count: int, seed: int) -> list[Array]:
    generator = np.random.default_rng(seed)
    return [variables.x0, *(variables.random(generator) for _ in range(count - 1))]


def _from_many(
    task: Task,
    problem: Problem,
    variables: Variables,
    designs: Sequence[Array],
    executor: Executor | None,
    progress: Progress | None,
) -> list[Optimum]:
    if executor is None:
        return [one for x in designs if (one := _from(task, problem, variables, x, progress)) is not None]
    model, plan = (
        problem.system.model,
        (problem.given, list(problem.names), problem.design, problem.formula),
    )
    settings = problem.settings | {"memory": problem.memory}
    waiting = [executor.submit(_elsewhere, task, model, plan, settings, variables, x) for x in designs]
    return [one for future in waiting if (one := future.result()) is not None]


def _from(
    task: Task, problem: Problem, variables: Variables, x: Array, progress: Progress | None = None
) -> Optimum | None:
    """The optimum from a design; None if it cannot be simulated."""
    try:
        return task.solved(problem, variables.beginning(x), progress)
    except Infeasible:
        return None


def _elsewhere(
    task: Task, model: Model, plan: Any, settings: Mapping[str, Any], variables: Variables, x: Array
) -> Optimum | None:
    """The same in another process."""
    responses, names, design, formula = plan
    problem = Problem(System(model), responses, names, design=design, formula=formula, **settings)
    return _from(task, problem, variables, x)


def _best(found: list[Optimum], constrained: int) -> Optimum:
    """The least optimum, those that keep the constraints first; the others beside it."""
    if not found:
        raise Infeasible("none of the designs to start from can be simulated; choose other bounds")
    order = sorted(found, key=lambda one: (constrained > 0 and not one.success, one.value))
    again = sum(abs(one.value - order[0].value) <= 1e-3 * (abs(order[0].value) or 1.0) for one in order)
    message = f"{order[0].message}; {again} of {len(found)} starts came to it"
    return replace(order[0], message=message, starts=tuple(order))
