"""Execution of a study: cases, processes and results."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..analyses.progress import TimeLimit, duration, monitor, refuse_time_limit
from ..model import Model, SarrusError
from ..model.announcement import announce, reports_warnings
from ..outputs.units import units_of_parameters
from ..results.saving.checked_file import NOT_SAVED, NotSavedError
from ..results.saving.versions import versions
from ..system import System
from . import pool
from .case import Outcome, Task
from .ledger import Ledger
from .parameters import Array, Parameter, parameter_of, refuse_other_units
from .responses import described, differentiable, responses_of
from .runs import Run, Simulation, run_of
from .samples import Sample, sample_of
from .source import GUESS, Source, facts
from .table import StudyTable, table_of

Progress = Callable[[float], None]
# Cases run in this process first: the first one also loads kernels, the second shows what a case takes
TRIED = 2
IMPORT = 4.0  # s: a new process imports Python's numerical libraries and Sarrus
GAIN = 0.8  # predicted time with processes over that without: above it they are not worth their memory
log = logging.getLogger("sarrus.study")


@dataclass(frozen=True)
class Request:
    """A study that was checked, and can be run."""

    name: str
    task: Task
    parameters: Mapping[str, Parameter]
    sample: Sample
    cases: Array

    def facts(self) -> dict[str, Any]:
        """All that makes the study what it is, in plain values."""
        return {
            "name": self.name,
            "model": facts(self.task.source),
            "parameters": {name: _plain(parameter) for name, parameter in self.parameters.items()},
            "sample": _listed(self.sample.described()),
            "analysis": self.task.run.described(),
            "responses": dict(described(self.task.responses)),
            "versions": versions(),
            "cases": self.cases.tolist(),
            "units": self.units(),
        }

    def units(self) -> dict[str, str]:
        """The units of parameters and responses, where they are known."""
        system, units = System(self.task.source.model), dict[str, str]()
        for name in self.parameters:
            units[name] = units_of_parameters(system.model, [name])[0]
        for response in self.task.responses:
            with suppress(SarrusError):  # a function, or what only some analyses have
                units[response.name] = differentiable(response).unit(system)
        return {name: unit for name, unit in units.items() if unit}

    def values(self, case: int) -> dict[str, float]:
        """The parameters of one case."""
        return {name: float(x) for name, x in zip(self.parameters, self.cases[case], strict=True)}

    def start_warnings(self) -> tuple[str, ...]:
        """What assembly changes of the model's own state; of cases, whose poses are guesses, it is no warning."""
        if any(name.startswith(tuple(GUESS)) for name in self.parameters):
            return ()
        return self.task.run.start_warnings(System(self.task.source.model))


@reports_warnings
def study(
    model: Model | System,
    parameters: Mapping[str, Any],
    responses: Any,
    *,
    analysis: Any,
    sample: Any = None,
    name: str = "",
    folder: str | Path | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    time_limit: float = np.inf,
    total_time_limit: float | None = None,
    retry_failed: bool = False,
    progress: bool | Progress | None = None,
) -> StudyTable:
    """Run one analysis for many values of the parameters of a model.

    Parameters
    ----------
    model : a model, loaded or created in Python
    parameters : parameters of the model by name (``spring.k``, ``pin.point.x``), parameters of its file, or coordinates
        of the initial estimate (``start.q.crank.r.x``, for many starts); for each a list, `Range` or `Distribution`
    responses : formulas by name, ``{"reach": "max(slider.x)"}``, see `sarrus.studies.responses`; or functions of the
        result
    analysis : `Simulation`, `Kinematics`, `Statics`, `Vibration`, `Linearization`, `InverseDynamics`, or a
        function of the system that returns a result or a mapping of numbers
    sample : `Grid` (the default), `LatinHypercube`, `Sobol`, `MonteCarlo` or `Listed`
    name : title of tables and plots; by default that of the model
    folder : folder for the results, written case by case; a study that was stopped continues
    workers : number of processes; 1 is this process. By default the first two cases run in this process, and their time
        decides whether more processes are faster: starting a process takes seconds
    executor : an executor of ``concurrent.futures``, such as that of Dask, instead of own processes
    time_limit : seconds after which a simulation or kinematic analysis of one case counts as failed
    total_time_limit : seconds after which the study ends with the completed cases: `StudyTable.status` is then
        "time limit"; after Ctrl-C it is "stopped"
    retry_failed : repeat failed cases of the folder
    progress : True for a bar on standard error, or a function of the number of cases that are done

    Returns
    -------
    StudyTable
        A failed case has its message in its row, and does not stop other cases.

    Raises
    ------
    SarrusError
        If an argument is wrong; this is checked before the first case.
    """
    pool.refuse_inside_start()
    request = ask(
        model, parameters, responses, analysis=analysis, sample=sample, name=name, time_limit=time_limit
    )
    return carry_out(request, folder, workers, executor, retry_failed, progress, total_time_limit)


def ask(
    model: Model | System,
    parameters: Mapping[str, Any],
    responses: Any,
    *,
    analysis: Any,
    sample: Any = None,
    name: str = "",
    time_limit: float = np.inf,
) -> Request:
    """Check a study: its names, values and formulas. For parameters see `study`."""
    source = Source.of(model.model if isinstance(model, System) else model)
    source.check(parameters)
    run = run_of(analysis).started(System(source.model))
    _refuse_guesses(run, parameters)
    formulas = responses_of(responses)
    if isinstance(run, Simulation) and any(response.of_errors for response in formulas):
        run = replace(run, store="steps")
    task = Task(source, run, formulas, time_limit)
    if not task.responses:
        raise SarrusError("a study needs a response. Give one such as max(slider.x).")
    variables = {key: _parameter(key, given) for key, given in parameters.items()}
    for key, given in parameters.items():
        refuse_other_units(source.model, key, given)
    run.check(System(source.model), task.responses, parameters)
    chosen = sample_of(sample)
    return Request(name or source.model.name, task, variables, chosen, chosen.cases(variables))


def _refuse_guesses(run: Run, parameters: Mapping[str, Any]) -> None:
    """Refuse parameters of the model's own initial state where the analysis has another start."""
    varied = [name for name in parameters if name.startswith(tuple(GUESS))]
    if varied and getattr(run, "start", None) is not None:
        message = f"{varied[0]} varies the model's own initial state, in whose place the analysis has a start"
        raise SarrusError(f"{message}. Leave one of them out.")


def carry_out(
    request: Request,
    folder: str | Path | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    retry_failed: bool = False,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
) -> StudyTable:
    """Run the cases that are not done yet, in at most `time_limit` seconds. For parameters see `study`."""
    refuse_time_limit(time_limit, "total_time_limit")
    facts, ended = request.facts(), list(request.start_warnings())
    try:
        ledger = Ledger(Path(folder), facts, request.task.source.files) if folder is not None else None
    except NotSavedError as wrong:
        return replace(table_of(facts, {}), status=NOT_SAVED, warnings=announce([*ended, str(wrong)]))
    outcomes = ledger.found if ledger else {}
    done = {case for case, outcome in outcomes.items() if outcome.success or not retry_failed}
    jobs = {case: request.values(case) for case in range(len(request.cases)) if case not in done}

    def write(case: int, outcome: Outcome) -> None:
        ledger.write(case, outcome) if ledger else outcomes.__setitem__(case, outcome)
        done.add(case)
        report(len(done))

    deadline = np.inf if time_limit is None else time.monotonic() + time_limit

    def tick() -> float:
        left = deadline - time.monotonic()
        if left <= 0:
            raise TimeLimit(f"the time limit of {duration(time_limit or 0.0)} has passed")
        return float(left)

    status, execution = "finished", ""
    try:
        with monitor(progress, len(request.cases), done="ran", unit=" cases") as report:
            execution = _run(request.task, jobs, write, workers, executor, tick)
    except (KeyboardInterrupt, TimeLimit) as end:
        status = "stopped" if isinstance(end, KeyboardInterrupt) else "time limit"
        why = "stopped by the user" if isinstance(end, KeyboardInterrupt) else str(end)
        ended += [f"{request.name}: {why}. {len(done)} of {len(request.cases)} cases are done."]
    except NotSavedError as wrong:
        status = NOT_SAVED
        ended += [f"{wrong} Then the same call continues with the cases that are left."]
    finally:
        if ledger:
            ledger.close()
    table = replace(table_of(facts, outcomes), status=status, execution=execution)
    table = replace(table, warnings=(*ended, *table.warnings))
    announce(table.warnings)
    return table


def _run(
    task: Task,
    jobs: pool.Jobs,
    write: pool.Write,
    workers: int | None,
    executor: Executor | None,
    tick: pool.Tick,
) -> str:
    """Run cases; returns where, and why there."""
    if workers is not None and workers < 1:
        raise SarrusError(f"workers must be 1 at least, but is {workers}. Give a number of processes.")
    if executor is not None:
        pool.run_in(executor, task, jobs, write, tick)
        return "in the executor that was passed"
    if workers is None:
        return run_where_it_pays(task, jobs, write, tick)
    if min(workers, len(jobs)) <= 1:
        pool.run_here(task, jobs, write, tick)
        return "in this process"
    pool.run_in_processes(task, jobs, write, workers, tick)
    return f"in {min(workers, len(jobs))} processes, as asked for"


def _parameter(name: str, value: Any) -> Parameter:
    try:
        return parameter_of(value)
    except SarrusError as wrong:
        raise SarrusError(f"parameter {name!r}: {wrong}") from None


def _plain(parameter: Parameter) -> dict[str, Any]:
    entries = {name: value for name, value in vars(parameter).items() if name != "texts"}
    return {"type": type(parameter).__name__, **_listed(entries)}


def _listed(entries: Mapping[str, Any]) -> dict[str, Any]:
    return {name: list(value) if isinstance(value, tuple) else value for name, value in entries.items()}


@dataclass(frozen=True)
class Choice:
    """The number of processes, and why."""

    workers: int
    reason: str


def chosen_workers(loading: float, each: float, cases: int, processors: int) -> Choice:
    """The number of worker processes for the cases that are left.

    Parameters
    ----------
    loading : seconds that the first case took beyond the second one: every process loads its kernels, too
    each : seconds of a case
    cases : how many are left
    processors : that this process may use
    """
    here, workers = each * cases, min(processors, cases)
    if not cases:
        return Choice(1, "in this process: no cases are left")
    if workers < 2:
        return Choice(1, "in this process: there is one processor or one case")
    there = IMPORT + loading + here / workers
    if there > GAIN * here:
        return Choice(1, f"in this process in about {duration(here)}; {workers} processes: {duration(there)}")
    return Choice(
        workers, f"in {workers} processes in about {duration(there)}; in this one: {duration(here)}"
    )


def run_where_it_pays(task: Task, jobs: pool.Jobs, write: pool.Write, tick: pool.Tick) -> str:
    """Run the first cases here, and the others where they are done sooner; returns where and why."""
    processors, left, taken = pool.available(), dict(jobs), list[float]()
    while left and len(taken) < TRIED and processors > 1:
        case, began = next(iter(left)), time.perf_counter()
        pool.run_here(task, {case: left.pop(case)}, write, tick)
        taken.append(time.perf_counter() - began)
    each = taken[-1] if taken else 0.0
    choice = chosen_workers(max(taken, default=0.0) - each, each, len(left), processors)
    log.info("%s", choice.reason)
    if choice.workers > 1:
        pool.run_in_processes(task, left, write, choice.workers, tick)
    else:
        pool.run_here(task, left, write, tick)
    return choice.reason
