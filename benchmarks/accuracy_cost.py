"""What the default call costs beside the best choice by hand with no larger error, on the problems of `accuracy.py`.

    python benchmarks/accuracy_cost.py [--only NAME]

By hand: every method with a row of tolerances. Errors are compared while the default's digits last: later, in chaos,
all choices are equally wrong. Times are of the processor, the least of three runs; of the default and the best choice
by hand then the median ratio of pairs, taken in turn.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from accuracy_problems import PROBLEMS, Problem
from accuracy_problems.problem import size

import sarrus as sr
from sarrus.algebra import Array

BY_HAND: list[tuple[str, Any, Sequence[int]]] = [
    ("radau", sr.Radau(), range(4, 12)),
    ("hht", sr.HHT(), range(4, 9)),
    ("dop853", sr.ODE(), range(4, 13)),
]
RUNS, PAIRS, ALLOWED = 3, 5, 1.5
LONG = 2.0  # s of a run that is not repeated
# s of a default run; of others by the time of that, on a busy machine
LIMIT, PATIENCE, GRACE = 300.0, 4.0, 0.5
LOST = 1e-3  # error over the size of the motion, from which on no digit is reported without a warning


class Timed(NamedTuple):
    """Seconds of a choice, and its errors of positions up to each time, over the size of the motion."""

    title: str
    settings: dict[str, Any]
    seconds: float
    errors: Array

    def error(self, last: int = -1) -> float:
        """The largest error up to a time."""
        return float(self.errors[last])

    @property
    def last(self) -> int:
        """The last time before digits are lost."""
        return int(np.searchsorted(self.errors, LOST, side="right")) - 1


def timed(
    problem: Problem, title: str, limit: float = LIMIT, runs: int = RUNS, **settings: Any
) -> Timed | str:
    """The least time of some runs; the status of one that ends early."""
    known = problem.solution()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        system, start = problem.make()
        given = {"until": problem.until, "t_eval": known.t, "events": problem.events, **settings}
        sr.simulate(system, start, **{**given, "until": known.t[1], "t_eval": None})
        seconds = np.inf
        for _ in range(runs):
            began = time.process_time()
            run = sr.simulate(system, start, limits=sr.Limits(time=limit), **given)
            seconds = min(seconds, time.process_time() - began)
            if not run.success:
                return str(run.status)
            if seconds > LONG:
                break
    found = abs(problem.columns(run).positions - known.positions).max(axis=1) / size(known.positions)
    return Timed(title, settings, seconds, np.maximum.accumulate(found))


def choices(problem: Problem, limit: float) -> Iterator[Timed]:
    """Every method and tolerance by hand."""
    for name, method, powers in BY_HAND:
        for k in powers:
            try:
                found = timed(problem, f"{name} 1e-{k}", limit, method=method, rtol=10.0**-k)
            except (ValueError, TypeError):
                break
            if found == "time limit":
                break
            if isinstance(found, Timed):
                yield found


def ratio(problem: Problem, own: Timed, best: Timed) -> float:
    """The time of the default over that of a choice by hand."""
    if own.seconds > LONG:
        return own.seconds / best.seconds
    pairs = [[timed(problem, one.title, runs=1, **one.settings) for one in (own, best)] for _ in range(PAIRS)]
    both = [(one, other) for one, other in pairs if isinstance(one, Timed) and isinstance(other, Timed)]
    return float(np.median([one.seconds / other.seconds for one, other in both]))


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
        if isinstance(own, str):
            print(f"{problem.name:46s} no figure: the default run ends with {own}", flush=True)
            continue
        last = own.last
        known = [
            one
            for one in choices(problem, PATIENCE * own.seconds + GRACE)
            if one.error(last) <= own.error(last)
        ]
        best = min([own, *known], key=lambda one: one.seconds)
        ratios.append(1.0 if best is own else ratio(problem, own, best))
        print(
            f"{problem.name:46s}{own.error():9.1e}{1e3 * own.seconds:9.1f}   {best.title:14s}{best.error():9.1e}"
            f"{1e3 * best.seconds:9.1f}{ratios[-1]:8.2f}",
            flush=True,
        )
    print(
        f"{np.count_nonzero(np.array(ratios) <= ALLOWED)} of {len(ratios)} at most {ALLOWED} times the best"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
