"""What the default call costs beside the best choice by hand with no larger error, on the problems of `accuracy.py`.

    python benchmarks/accuracy_cost.py [--only NAME]

By hand: every method with a row of tolerances. Times are the least of three runs, of the processor, one after another.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from accuracy_problems import PROBLEMS, Problem
from accuracy_problems.problem import errors

import sarrus as sr

BY_HAND: list[tuple[str, Any, Sequence[int]]] = [
    ("radau", sr.Radau(), range(4, 12)),
    ("hht", sr.HHT(), range(4, 9)),
    ("dop853", sr.ODE(), range(4, 13)),
]
RUNS, PATIENCE, ALLOWED = 3, 2.0, 1.5


class Timed(NamedTuple):
    """Error of positions and seconds of a choice."""

    title: str
    error: float
    seconds: float


def timed(problem: Problem, title: str, limit: float = 300.0, **settings: Any) -> Timed | None:
    """The least time of some runs; None where it fails or takes too long."""
    known = problem.solution()
    system, start = problem.make()
    given = {"until": problem.until, "t_eval": known.t, "events": problem.events, **settings}
    seconds = np.inf
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sr.simulate(system, start, **{**given, "until": known.t[1], "t_eval": None})
        for _ in range(RUNS):
            began = time.process_time()
            run = sr.simulate(system, start, time_limit=limit, **given)
            seconds = min(seconds, time.process_time() - began)
            if not run.success:
                return None
    return Timed(title, errors(problem.columns(run), known)["positions"], seconds)


def choices(problem: Problem, limit: float) -> Iterator[Timed]:
    """Every method and tolerance by hand."""
    for name, method, powers in BY_HAND:
        for k in powers:
            try:
                found = timed(problem, f"{name} 1e-{k}", limit, method=method, rtol=10.0**-k)
            except (ValueError, TypeError):
                break
            if found is None:
                break
            yield found


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", default="", help="problems whose names contain this")
    given = parser.parse_args(arguments)
    print(
        f"{'problem':46s}{'error':>9s}{'ms':>9s}   {'best by hand':14s}{'error':>9s}{'ms':>9s}{'ratio':>8s}"
    )
    ratios = []
    for problem in (one for one in PROBLEMS if given.only in one.name):
        own = timed(problem, "default")
        if own is None:
            print(f"{problem.name:46s} does not finish")
            continue
        known = [one for one in choices(problem, PATIENCE * own.seconds + 0.2) if one.error <= own.error]
        best = min([own, *known], key=lambda one: one.seconds)
        ratios.append(own.seconds / best.seconds)
        print(
            f"{problem.name:46s}{own.error:9.1e}{1e3 * own.seconds:9.1f}   {best.title:14s}{best.error:9.1e}"
            f"{1e3 * best.seconds:9.1f}{ratios[-1]:8.2f}",
            flush=True,
        )
    print(
        f"{np.count_nonzero(np.array(ratios) <= ALLOWED)} of {len(ratios)} at most {ALLOWED} times the best"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
