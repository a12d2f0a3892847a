"""Who runs the cases: as many processes as the measured time of the first cases suggests."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass

from ..analyses.progress import duration
from . import pool
from .case import Task

# Cases run in this process first: the first one also loads kernels, the second shows what a case takes
TRIED = 2
IMPORT = 4.0  # s: a new process imports Python's numerical libraries and Sarrus
GAIN = 0.8  # predicted time with processes over that without: above it they are not worth their memory
log = logging.getLogger("sarrus.study")


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
