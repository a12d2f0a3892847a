"""An optimization from several starts, each of which is reported."""

from __future__ import annotations

from concurrent.futures import Executor, Future
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model import Model
from ...results import Optimum, StartReport
from ...system import System
from .point import DesignError
from .problem import Problem
from .search import Report, Variables
from .task import Task

DRAWS = 30  # random designs that are tried for one start, until one can be simulated
SAME = 1e-3  # [-] difference of objectives below which two starts came to the same optimum


class Trial(NamedTuple):
    """A start: its number, the design, and the seed of those that replace it; none for the system's own."""

    number: int
    x: Array
    seed: int | None


class TrialResult(NamedTuple):
    """Outcome of a start: its optimum, or the message of the last design; and the number of replaced designs."""

    begin: Trial
    optimum: Optimum | None
    message: str
    replaced: int


def optimum_from_many(
    task: Task,
    problem: Problem,
    variables: Variables,
    count: int,
    seed: int,
    executor: Executor | None,
    progress: Report | None,
) -> Optimum:
    """The least optimum of several starts, with the others and a report of every start.

    Raises
    ------
    Infeasible
        If none of them can be simulated.
    """
    generator = np.random.default_rng(seed)
    begins = [Trial(0, variables.x0, None)]
    begins += [Trial(n, variables.random(generator), seed) for n in range(1, count)]
    waiting = list[Future[TrialResult]]()
    if executor is not None:
        plan = problem.given, [*problem.names], problem.options
        work = task, problem.plain, plan, problem.ending, variables
        waiting = [executor.submit(_elsewhere, *work, begin) for begin in begins]
    local = (partial(_from, task, problem, variables, begin, progress) for begin in begins)
    results, stopped = list[TrialResult](), False
    for call in [future.result for future in waiting] or local:
        try:
            results.append(call())
        except KeyboardInterrupt:
            if not any(result.optimum for result in results):
                raise
            stopped = True
        last = results[-1].optimum
        late = executor is None and (problem.is_late or (last is not None and last.status == "stopped"))
        if stopped or late:
            break
    for future in waiting:
        future.cancel()
    best = _best(results, count)
    message = f"stopped by the user; {best.message}"
    return replace(best, success=False, status="stopped", message=message) if stopped else best


def _from(
    task: Task, problem: Problem, variables: Variables, begin: Trial, progress: Report | None = None
) -> TrialResult:
    """The optimum from a design, or from another one in its place where it cannot be simulated."""
    x, generator = begin.x, np.random.default_rng([begin.seed or 0, begin.number])
    for replaced in range(DRAWS if begin.seed is not None else 1):
        try:
            return TrialResult(begin, task.solved(problem, variables.beginning(x), progress), "", replaced)
        except DesignError as error:
            message = str(error)
            if problem.is_late:
                break
            x = variables.random(generator)
    return TrialResult(begin, None, message, replaced)


def _elsewhere(
    task: Task,
    model: Model,
    plan: Any,
    ending: tuple[float | None, float],
    variables: Variables,
    begin: Trial,
) -> TrialResult:
    """The same in another process, which ends when the time of the whole search is over."""
    responses, names, options = plan
    problem = Problem(System(model), responses, names, **options)
    problem.end_after(*ending)
    return _from(task, problem, variables, begin)


def _best(results: list[TrialResult], count: int) -> Optimum:
    """The least optimum, those that succeeded and keep the constraints first; the others beside it."""
    optima = [result.optimum for result in results if result.optimum is not None]
    if not optima:
        raise DesignError(
            f"None of the designs to start from can be simulated, the first one because {results[0].message} "
            "Choose another start or other bounds."
        )
    order = sorted(optima, key=lambda best: (bool(best.constraints) and not best.feasible, best.value))
    best = order[0]
    again = sum(abs(optimum.value - best.value) <= SAME * (abs(best.value) or 1.0) for optimum in order)
    message = f"{best.message}; {again} of {count} starts came to it"
    reports = tuple(_report(result) for result in results)
    return replace(best, message=message, starts=tuple(order), start_reports=reports)


def _report(result: TrialResult) -> StartReport:
    number, instead = result.begin.number + 1, result.replaced
    optimum = result.optimum
    note = f"{instead} random designs before it could not be simulated; " if instead else ""
    if optimum is None:
        return StartReport(number, result.begin.x, np.nan, False, f"cannot be simulated: {result.message}")
    return StartReport(number, optimum.x0, optimum.value, optimum.success, note + optimum.message)
