"""How far a run is from the true motion, for mechanisms whose motion is known.

python benchmarks/accuracy.py                    the default call on all problems
python benchmarks/accuracy.py --method radau --rtol 1e-6 --only pendulum
python benchmarks/accuracy.py --error            estimated errors over true ones, and their cost over that of a gradient

Errors are the largest ones over the run, over the size of the motion. Times are of a second run, without compilation.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from accuracy_problems import PROBLEMS, Problem
from accuracy_problems.problem import KINDS, errors
from effectivity import effectivities

import sarrus as sr

METHODS = {
    "hht": sr.HHT(),
    "stabilized": sr.HHT(stabilized=True),
    "alpha": sr.GeneralizedAlpha(),
    "radau": sr.Radau(),
}
WANTED, WRONG = 1e-4, 1e-3  # of the size of the motion: what a run should reach, and what must not be silent
PATIENCE = 120.0  # s for a run


class Row(NamedTuple):
    """What became of one problem."""

    name: str
    errors: dict[str, float]
    seconds: float
    steps: int
    status: str
    warnings: tuple[str, ...]

    @property
    def worst(self) -> float:
        """Of positions; those of velocities and reactions are shown, but a bounce has no velocity to compare."""
        return self.errors["positions"]

    @property
    def silent(self) -> bool:
        """Whether nothing tells that the run may be wrong."""
        return self.status == "ok" and not self.warnings


def measured(problem: Problem, **settings: Any) -> Row:
    """One problem with some settings."""
    known = problem.solution()
    system, start = problem.make()
    given = {
        "until": problem.until,
        "t_eval": known.t,
        "events": problem.events,
        "limits": sr.Limits(time=PATIENCE),
        **settings,
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sr.simulate(system, start, **{**given, "until": known.t[1], "t_eval": None})
        begun = time.perf_counter()
        run = sr.simulate(system, start, **given)
        seconds = time.perf_counter() - begun
        found = errors(problem.columns(run), known)
    return Row(problem.name, found, seconds, run.nsteps, "ok" if run.success else run.status, run.warnings)


def table(rows: Iterator[Row]) -> Iterator[Row]:
    """Print rows as they come."""
    print(
        f"{'problem':46s}{'positions':>11s}{'velocities':>12s}{'reactions':>11s}{'s':>8s}{'steps':>9s}  status"
    )
    for row in rows:
        figures = "".join(
            f"{row.errors[kind]:{width}.1e}" for kind, width in zip(KINDS, (11, 12, 11), strict=True)
        ).replace("nan", "  -")
        print(
            f"{row.name:46s}{figures}{row.seconds:8.2f}{row.steps:9d}  {row.status}"
            + "".join(f"\n{'':10s}{message}" for message in row.warnings),
            flush=True,
        )
        yield row


def summary(rows: Sequence[Row]) -> str:
    """How many are right, and which are wrong without a word."""
    worst = np.array([row.worst for row in rows])
    right = np.count_nonzero(worst <= WANTED)
    wrong = [row.name for row in rows if not row.worst <= WRONG and row.silent]
    lines = [f"{right} of {len(rows)} within {WANTED:.0e}; {len(wrong)} beyond {WRONG:.0e} without a warning"]
    return "\n".join([*lines, *(f"  {name}" for name in wrong)])


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--method", choices=METHODS, help="instead of the default")
    parser.add_argument("--rtol", type=float)
    parser.add_argument("--atol", type=float)
    parser.add_argument("--error", action="store_true", help="how good estimates of the error are")
    parser.add_argument("--only", default="", help="problems whose names contain this")
    given = parser.parse_args(arguments)
    settings = {name: getattr(given, name) for name in ("rtol", "atol") if getattr(given, name) is not None}
    settings = {"method": replace(METHODS[given.method] if given.method else sr.Radau(), **settings)}
    chosen = [problem for problem in PROBLEMS if given.only in problem.name]
    if given.error:
        print(effectivities(chosen, **settings))
        return 0
    rows = list(table(measured(problem, **settings) for problem in chosen))
    print(summary(rows))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
