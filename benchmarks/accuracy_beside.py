"""Default answers of several programs to the problems of `accuracy.py` that each can state.

python benchmarks/accuracy_beside.py --exudyn PYTHON     a Python that has Exudyn; MuJoCo is imported here

The error of a program is that of points of all bodies at the end of the motion, over the size of their motion; of
Sarrus also the largest over the motion. The
truth is a run of Sarrus with rtol 1e-12 that differs from what is known of the problem by less than 1e-7; where it
does not, and where no other program can state the problem, errors are those of the problem's own columns. SciPy
integrates reduced equations, where a problem has them, and is compared by the same columns.

Defaults: Sarrus simulate(until=...); SciPy solve_ivp (RK45, rtol 1e-3, atol 1e-6); Exudyn SolveDynamic (100 steps), and
with steps of 1 ms, as in its examples; MuJoCo mj_step (semi-implicit Euler, steps of 2 ms).
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from typing import Any
from unittest import mock

import accuracy_mujoco
import accuracy_problems.problem as problem_module
import numpy as np
from accuracy_problems import PROBLEMS, Problem
from accuracy_problems.oscillators import _damped
from accuracy_problems.pendulums import _elliptic
from accuracy_problems.problem import errors
from exudyn_told import Exudyn, Told

import sarrus as sr

TRUE = 1e-7  # of the size of the motion: what a tight run must agree with what is known
PLAIN = {"method": "RK45", "rtol": 1e-3, "atol": 1e-6}
REDUCED = {  # of problems with closed forms: the equation, its start, and what the position is counted from
    _damped: lambda m, k, c, x, v: (lambda t, y: (y[1], -(k * y[0] + c * y[1]) / m), (x, v), 0.0),
    _elliptic: lambda a, l, g, m: (lambda t, y: (y[1], -g / (1.001 * l) * np.sin(y[0])), (a, 0.0), a),
}
MOST = 200_000  # steps of a program with constant ones
COLUMNS = ("Sarrus", "Sarrus, largest", "SciPy", "Exudyn, 100 steps", "Exudyn, 1 ms", "MuJoCo")


def places(run: sr.Trajectory, told: Told) -> np.ndarray:
    """Global positions of the wanted points over time (nt, n, 3)."""
    names = (f"{p['body']}({', '.join(repr(float(x)) for x in p['at'])})" for p in told.data["points"])
    return np.stack(
        [np.stack([run.output(f"{name}.{x}").values for x in "xyz"], axis=1) for name in names], axis=1
    )


def told_of(problem: Problem, system: sr.System, start: sr.Assembly) -> Told:
    """The model from its start; wanted are a point of each body beside its origin."""
    size = max(float(abs(start.q.reshape(-1, 7)[:, :3]).max()), 1e-9)
    numbers = [value for force in system.model.forces for value in vars(force).values()]
    if (
        problem.events
        or system.model.drivers
        or any(callable(value) or isinstance(value, sr.Curve) for value in numbers)
    ):
        raise ValueError("only springs, weights and loads of constant numbers are told, and no impacts")
    points = [(body.name, (0.1 * size, 0.2 * size, 0.3 * size)) for body in system.model.bodies]
    return Told(system, start, points, [])


def row(problem: Problem, python: str) -> dict[str, float]:
    """Errors of all programs that can state the problem."""
    system, start = problem.make()
    start = start or sr.assemble(system)
    known = problem.solution()
    options: dict[str, Any] = {
        "until": problem.until,
        "events": problem.events,
        "limits": sr.Limits(time=600.0),
    }
    default = sr.simulate(system, start, t_eval=known.t, **options)
    columns = problem.columns(default)
    found = {"Sarrus": at_end(columns, known), "SciPy": scipy_error(problem, known)}
    found["Sarrus, largest"] = errors(columns, known)["positions"]
    tight = sr.simulate(system, start, method=sr.Radau(rtol=1e-12), t_eval=known.t, **options)
    if not tight.success or not errors(problem.columns(tight), known)["positions"] < TRUE:
        return found
    try:
        told = told_of(problem, system, start)
    except (AssertionError, AttributeError, ValueError):
        return found
    true = places(tight, told)
    size = float(np.ptp(true, axis=0).max())

    def error(end: Any) -> float:
        return float(abs(np.array(end) - true[-1]).max()) / size

    found["Sarrus"] = error(places(default, told)[-1])
    found["Sarrus, largest"] = float(abs(places(default, told) - true).max()) / size
    exudyn = Exudyn(python, told)
    for name, steps in (("Exudyn, 100 steps", 100), ("Exudyn, 1 ms", round(problem.until / 1e-3))):
        if 1 <= steps <= MOST:
            answer = exudyn.run(steps=steps, until=problem.until, solver="dense")
            found[name] = error(answer["end"]) if "end" in answer else np.inf
    exudyn.close()
    with suppress(ValueError):  # it cannot be stated, or MuJoCo refuses its numbers
        found["MuJoCo"] = error(accuracy_mujoco.end(system, told, problem.until)[0])
    return found


def scipy_error(problem: Problem, known: Any) -> float:
    """Of reduced equations at the end, by the default of `solve_ivp`; nan where the problem has none."""
    own, used = problem_module.solve_ivp, []

    def default(f: Any, span: Any, y0: Any, **options: Any) -> Any:
        used.append(span)
        return own(f, span, y0, **{**options, **PLAIN})

    if isinstance(problem.known, partial) and problem.known.func in REDUCED:
        f, y0, start = REDUCED[problem.known.func](*problem.known.args)
        end = own(f, (0.0, problem.until), y0, **PLAIN).y[0, -1:] - start
    else:
        with mock.patch.object(problem_module, "solve_ivp", default):
            end = problem.solution().positions[-1]
        if not used:
            return np.nan
    return float(abs(end - known.positions[-1]).max()) / problem_module.size(known.positions)


def at_end(found: Any, known: Any) -> float:
    """The error of a run's columns at the end; nan if it stopped before."""
    if len(found.positions) != len(known.positions):
        return np.nan
    return float(abs(found.positions[-1] - known.positions[-1]).max()) / problem_module.size(known.positions)


def rows(only: str, python: str) -> Iterator[tuple[str, dict[str, float]]]:
    """Name and errors of each problem."""
    for problem in PROBLEMS:
        if only in problem.name:
            yield problem.name, row(problem, python)


def cell(error: float) -> str:
    """One digit; nothing where there is no answer, and no number for one that is all wrong."""
    return "" if np.isnan(error) else f"{error:.0e}" if error < 1 else "> 1"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--exudyn", required=True, metavar="PYTHON")
    parser.add_argument("--only", default="")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    print("| problem | " + " | ".join(COLUMNS) + " |\n|---|" + "---|" * len(COLUMNS))
    for name, found in rows(chosen.only, chosen.exudyn):
        cells = (cell(found.get(column, np.nan)) for column in COLUMNS)
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
