"""Many runs of one model with other numbers: what is asked, who runs it, and where the results go."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..model import Model, SarrusError, announce, reports_warnings
from ..system import System
from . import pool
from .case import Outcome, Task
from .ledger import Ledger
from .parameters import Array, Parameter, parameter_of
from .responses import described, responses_of
from .runs import run_of
from .samples import Sample, sample_of
from .source import Source, facts
from .table import StudyTable, table_of

Progress = Callable[[int], None]


@dataclass(frozen=True)
class Asked:
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
            "parameters": {name: _plain(one) for name, one in self.parameters.items()},
            "sample": _listed(self.sample.described()),
            "analysis": self.task.run.described(),
            "responses": dict(described(self.task.responses)),
            "versions": versions(),
            "cases": self.cases.tolist(),
        }

    def values(self, case: int) -> dict[str, float]:
        """The parameters of one case."""
        return {name: float(x) for name, x in zip(self.parameters, self.cases[case], strict=True)}


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
    retry_failed: bool = False,
    progress: Progress | None = None,
    strict: bool = False,
) -> StudyTable:
    """Run an analysis of a model for many values of its numbers.

    Parameters
    ----------
    model : as it was loaded or made
    parameters : numbers of the model by name (``spring.k``, ``pin.point.x``), parameters of its file, or coordinates of
        the guess (``start.q.crank.r.x``, for many starts); for each a list of values, a `Range` or a `Distribution`
    responses : formulas by name, ``{"reach": "max(slider.x)"}``, see `sarrus.studies.responses`; or functions of the
        result
    analysis : `Simulation`, `Kinematics`, `Statics`, `Vibration`, or a function of the system that returns a result or
        a mapping of numbers
    sample : `Grid` (the default), `LatinHypercube`, `Sobol`, `MonteCarlo` or `Listed`
    name : in tables and plots; by default the model's
    folder : where results are written as they come; a study that was stopped goes on where it was
    workers : processes; by default as many as there are processors, and 1 runs everything in this one
    executor : any executor of ``concurrent.futures`` in the place of processes of our own, such as Dask's
    time_limit : clock seconds after which a simulation counts as failed
    retry_failed : run cases of the folder that failed once more
    progress : called with the number of cases that are done
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    StudyTable
        A case that failed has its sentence there, and stops no other.

    Raises
    ------
    SarrusError
        If something is asked that cannot be meant; before anything is run.
    """
    pool.refuse_inside_start()
    asked = ask(
        model, parameters, responses, analysis=analysis, sample=sample, name=name, time_limit=time_limit
    )
    return carry_out(asked, folder, workers, executor, retry_failed, progress)


def ask(
    model: Model | System,
    parameters: Mapping[str, Any],
    responses: Any,
    *,
    analysis: Any,
    sample: Any = None,
    name: str = "",
    time_limit: float = np.inf,
) -> Asked:
    """Check a study: its names, values and formulas. For parameters see `study`."""
    source = Source.of(model.model if isinstance(model, System) else model)
    source.check(parameters)
    run = run_of(analysis)
    task = Task(source, run, responses_of(responses), time_limit)
    if not task.responses:
        raise SarrusError("a study needs a response; give one such as max(slider.x)")
    found = {key: _parameter(key, given) for key, given in parameters.items()}
    chosen = sample_of(sample)
    return Asked(name or source.model.name, task, found, chosen, chosen.cases(found))


def carry_out(
    asked: Asked,
    folder: str | Path | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    retry_failed: bool = False,
    progress: Progress | None = None,
) -> StudyTable:
    """Run the cases that are not done yet. For parameters see `study`."""
    told = asked.facts()
    ledger = Ledger(Path(folder), told, asked.task.source.files) if folder is not None else None
    outcomes = ledger.found if ledger else {}
    done = {case for case, outcome in outcomes.items() if outcome.success or not retry_failed}
    jobs = {case: asked.values(case) for case in range(len(asked.cases)) if case not in done}

    def write(case: int, outcome: Outcome) -> None:
        ledger.write(case, outcome) if ledger else outcomes.__setitem__(case, outcome)
        done.add(case)
        if progress:
            progress(len(done))

    try:
        _run(asked.task, jobs, write, workers, executor)
    finally:
        if ledger:
            ledger.close()
    table = table_of(told, outcomes)
    announce(table.warnings)
    return table


def _run(
    task: Task, jobs: pool.Jobs, write: pool.Write, workers: int | None, executor: Executor | None
) -> None:
    count = workers if workers is not None else pool.available()
    if count < 1:
        raise SarrusError(f"workers must be 1 at least, but is {count}")
    if executor is not None:
        pool.run_in(executor, task, jobs, write)
    elif min(count, len(jobs)) <= 1:
        pool.run_here(task, jobs, write)
    else:
        pool.run_in_processes(task, jobs, write, count)


def _parameter(name: str, given: Any) -> Parameter:
    try:
        return parameter_of(given)
    except SarrusError as wrong:
        raise SarrusError(f"parameter {name!r}: {wrong}") from None


def _plain(one: Parameter) -> dict[str, Any]:
    return {"type": type(one).__name__, **_listed(vars(one))}


def _listed(given: Mapping[str, Any]) -> dict[str, Any]:
    return {name: list(value) if isinstance(value, tuple) else value for name, value in given.items()}


def versions() -> dict[str, str]:
    """The versions of all that numbers depend on."""
    from importlib import import_module
    from importlib.metadata import version

    others = {name: version(name) for name in ("numpy", "scipy", "numba")}
    return {"sarrus": import_module("sarrus").__version__, "python": platform.python_version(), **others}
