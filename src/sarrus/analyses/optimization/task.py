"""An optimization from one start: a solver, started again until it is done, and an independent verdict."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...algebra import Array
from ...model.announcement import collecting
from ...results import Optimum
from ..position.assembly_derivatives import NoDerivative
from ..progress import TimeLimit
from .constraint import Within, excess, gap
from .optimality import OPTIMAL, SHARP, GaussNewton, balance, optimality
from .point import DesignError
from .problem import Problem
from .search import Report, Search, SearchFailure, Variables
from .solvers import Answer, solver_of

SATISFIED = 1e-6  # [-] of the limit, within which a constraint counts as satisfied
RESTARTS = 20  # of a solver that makes progress
DISTANCE = "the predicted relative distance from the optimum is"
PROGRESS = 1e-6  # [-] fall of the objective as the solver sees it that counts as progress


@dataclass(frozen=True)
class Task:
    """Options that are common to all starts."""

    constraints: tuple[Within, ...]
    solver: str | None
    iterations: int
    tolerance: float
    second_order: bool = False

    def solved(self, problem: Problem, variables: Variables, progress: Report | None = None) -> Optimum:
        """The optimum from one start; of warnings, those of the system's own state and of the best design."""
        with collecting():
            try:
                search = Search(problem, variables, self.constraints, progress)
            except TimeLimit as over:  # there is no design yet to return
                raise DesignError(str(over)) from None
            answer = guarded(search, lambda: self._repeated(search))
            return optimum_of(search, answer, max(SATISFIED, self.tolerance))

    def _repeated(self, search: Search) -> Answer:
        """Run the solver, again from where it stopped while that helps: its scales are those of the start."""
        solver = solver_of(self.solver, bool(self.constraints), self.second_order)
        if (unmet := reach_constraints(search, self.iterations)) is not None:
            return unmet
        normalize(search)
        answer = solver(search, self.iterations, self.tolerance)
        left, best = self.iterations - answer.iterations, _merit(search)
        for _ in range(RESTARTS):
            if left < 1 or (best[0] <= SATISFIED and best_optimality(search) <= SHARP):
                break
            search.restart()
            normalize(search)
            again = solver(search, left, self.tolerance)
            left, before, best = left - max(again.iterations, 1), best, _merit(search)
            if not (best[0] < before[0] - SATISFIED or before[1] - best[1] > PROGRESS * search.size):
                break
            answer = again
        return answer


def reach_constraints(search: Search, iterations: int) -> Answer | None:
    """Look for a design that meets the constraints by least squares; an answer if there is none near the start."""
    from scipy.optimize import least_squares

    size, count = np.array([constraint.size for constraint in search.constraints]), search.count

    def beyond(z: Array) -> Array:
        search.value(z)
        try:
            return excess(search.point(z).values[count:], search.constraints)
        except DesignError:
            return np.full(len(size), np.inf)

    def slopes(z: Array) -> Array:
        outside = (beyond(z) != 0.0) / size
        return np.asarray(search.other_slopes(z) * outside[:, None])

    if not _merit(search)[0] > SATISFIED:
        return None
    options: dict[str, Any] = {
        "bounds": search.variables.ends.T,
        "max_nfev": iterations,
        "gtol": SATISFIED**2,
    }
    with suppress(SearchFailure):  # designs nearer to the limits cannot be simulated
        least_squares(beyond, search.variables.z0, jac=slopes, **options)
    search.anchor = search.variables.z0
    assert search.best is not None
    values = search.best.values[count:]
    short = abs(excess(values, search.constraints))
    if short.max() <= SATISFIED:
        return None
    n = int(short.argmax())
    low, high = search.constraints[n].ends
    limit = f"its lower limit {low:g}" if values[n] < low else f"its upper limit {high:g}"
    message = "the search from this start found no design that meets the constraint "
    message += f"{search.problem.titles[count + n]}: the nearest has {values[n]:.6g}, {limit}"
    return Answer(False, f"{message}; try another start (starts=8) or a wider limit")


def normalize(search: Search, slope_of: Callable[[Array], Array] | None = None) -> None:
    """Make the objective that a solver sees independent of its unit and of constants in it; see `Search.normalize`."""
    z = search.variables.z0
    slope = (slope_of or search.slope)(z)
    search.normalize(slope, float(np.linalg.norm(balance(search, z, slope).rest)))


def _merit(search: Search) -> tuple[float, float]:
    """Return the violation of constraints and the objective of the best design."""
    assert search.best is not None
    values, count = search.best.values, search.count
    return gap(values[count:], search.constraints), float(values[:count].sum())


def best_optimality(search: Search, gauss_newton: GaussNewton | None = None) -> float:
    """`optimality` at the best design; infinite where it has no derivatives."""
    assert search.best is not None
    try:
        return optimality(search, search.best.x / search.variables.scale, gauss_newton)
    except (DesignError, TimeLimit, ArithmeticError, KeyboardInterrupt):
        return np.inf


def guarded(search: Search, solve: Callable[[], Answer]) -> Answer:
    """The answer of a solver, or of what ended it.

    Raises
    ------
    NoDerivative
        If the first design has no derivatives.
    """
    try:
        return solve()
    except SearchFailure as stuck:
        reason = str(stuck).rstrip(".")
        return Answer(
            False, f"no design along the search direction can be simulated, the last one because: {reason}"
        )
    except NoDerivative as error:
        if len(search.trace) == 1:
            raise
        return Answer(False, str(error).rstrip("."))
    except KeyboardInterrupt:
        return Answer(False, "stopped by the user", status="stopped")
    except TimeLimit as over:
        return Answer(False, str(over), status="time limit")


def optimum_of(
    search: Search,
    answer: Answer,
    near: float = SATISFIED,
    gauss_newton: GaussNewton | None = None,
) -> Optimum:
    """The best design of a search, with a verdict of its own; constraints count as satisfied if they are so near.

    `gauss_newton` as for `optimality`.
    """
    point, problem = search.best, search.problem
    assert point is not None
    values, limited = point.values, search.count
    short, open_by = gap(values[limited:], search.constraints), best_optimality(search, gauss_newton)
    optimal = open_by <= OPTIMAL
    success = optimal and short <= near and not answer.status
    message = answer.message
    if success and not answer.success:
        message = f"converged: {DISTANCE} {open_by:.1e} ({message})"
    elif answer.success and not optimal:
        message = f"not converged: {DISTANCE} {open_by:.2g}, but the solver makes no progress"
    if short > near:
        message += (
            f", {'but' if answer.success else 'and'} a constraint is short of its limit by {short:.2g} of it"
        )
    errors = [estimate.error for estimate in point.errors()[:limited]]
    units = {*problem.outer.units(problem.system)[:limited]}
    history = search.history
    tried = f"{len(history)} simulations"
    missed = f" and {len(search.failures)} that failed" if search.failures else ""
    return Optimum(
        problem.names, point.x.copy(), search.initial.copy(), float(values[:limited].sum()),
        float(history[0, 0]), success, f"{message}, after {tried}{missed}",
        history, np.array(search.trace),
        dict(zip(problem.titles[limited:], map(float, values[limited:]), strict=True)),
        status=answer.status or ("converged" if success else "not converged"), optimality=open_by,
        feasible=short <= near,
        failures=tuple(search.failures), seconds=time.perf_counter() - search.began,
        error=sum(errors) if errors else np.nan, unit=units.pop() if len(units) == 1 else "", units=problem.units,
        table_units=problem.table_units,
        model=problem.model_of(point.system), run=point.motion(),
        warnings=(*problem.start_warnings, *point.run.warnings),
    )  # fmt: skip
