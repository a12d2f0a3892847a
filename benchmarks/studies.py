"""How a study scales: the same simulations of the slider-crank in this process, and in worker processes.

    python benchmarks/studies.py [--json] [--cases 1000] [--workers 2] [--repeats 3]

Times are from the call of `study` to its table, with the start of the processes; the best of the repeats, which are
interleaved. `load` is the number of other programs that wanted a processor when the measurement began: above 0.3 or
so the ratio says more about them. `speedup_by_processor_time` leaves them out: processor time in this process, over
that of this process with workers (as if they waited for all of it) and an equal share of the workers' own.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import time
from typing import Any, NamedTuple

import numpy as np

from sarrus import mechanisms
from sarrus.model import load
from sarrus.studies import LatinHypercube, Range, Simulation, StudyTable, study
from sarrus.studies.pool import available

UNTIL = 10.0


class Spent(NamedTuple):
    """Seconds by the clock, and of processor time in this process and in processes that have ended."""

    clock: float
    here: float
    workers: float


def spent() -> Spent:
    """All so far."""
    own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return Spent(time.perf_counter(), own.ru_utime + own.ru_stime, others.ru_utime + others.ru_stime)


def run(cases: int, workers: int) -> tuple[Spent, StudyTable]:
    """What one study took, and its table."""
    model = load(mechanisms.path("slider_crank"))
    parameters = {"spring.k": Range(5, 20), "rod.mass": Range(0.5, 2.0)}
    began = spent()
    table = study(
        model,
        parameters,
        {"reach": "max(slider.x) - min(slider.x)", "end": "slider.x"},
        analysis=Simulation(until=UNTIL),
        sample=LatinHypercube(cases, seed=1),
        workers=workers,
    )
    return Spent(*(after - before for before, after in zip(began, spent()))), table


def measured(cases: int, workers: int, repeats: int) -> dict[str, Any]:
    """Times, their ratio, and whether the numbers are the same."""
    load_before = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    run(2, 1)  # compiled and loaded
    times: dict[int, list[Spent]] = {1: [], workers: []}
    tables = {}
    for _ in range(repeats):
        for count in times:
            took, tables[count] = run(cases, count)
            times[count].append(took)
    alone, shared = (min(found) for found in times.values())  # by the clock
    by_processor = min(one.here for one in times[1]) / min(
        one.here + one.workers / workers for one in times[workers]
    )
    return {
        "cases": cases,
        "workers": workers,
        "processors": available(),
        "load": load_before,
        "seconds_in_this_process": alone.clock,
        "seconds_in_workers": shared.clock,
        "speedup": alone.clock / shared.clock,
        "processor_seconds_in_this_process": min(one.here for one in times[1]),
        "processor_seconds_with_workers": list(min(times[workers], key=lambda one: one.workers)[1:]),
        "speedup_by_processor_time": by_processor,
        "all_succeeded": bool(all(table.success.all() for table in tables.values())),
        "same_numbers": bool(np.array_equal(tables[1].found, tables[workers].found)),
    }


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=3)
    chosen = parser.parse_args()
    found = measured(chosen.cases, chosen.workers, chosen.repeats)
    if chosen.json:
        print(json.dumps(found))
        return
    for name, value in found.items():
        print(f"{name:<26} {value:.3g}" if isinstance(value, float) else f"{name:<26} {value}")


if __name__ == "__main__":
    main()
