"""Simulations beside Exudyn: seconds a step, and seconds to the same measured error; chains of growing length.

    python benchmarks/dynamics.py [--json] [--quick] [--exudyn PYTHON]

PYTHON is an interpreter that has the package exudyn. Both codes run on one thread, in turns, and seconds are those of
the processor; the error is that of a point at the end of the run, against a reference solution. Both use generalized-α
with rho_inf = 0.9 and steps of one length; Sarrus also chooses its steps. The memory of a chain is the most that a run
of two steps has allocated above its system.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402  after the number of threads is set

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "examples"))
ROUNDS = 2


class Problem(NamedTuple):
    """One problem: the name that exudyn_run.py knows, the system, the point that is looked at, and where it ends."""

    name: str
    system: Any
    point: Callable[[Any], Any]
    until: float
    reference: tuple[float, float] | None
    steps: tuple[int, ...]


def problems(quick: bool) -> list[Problem]:
    """All that are compared."""
    from four_bars import four_bars

    import sarrus as sr

    crank = sr.System(sr.load(HERE.parent / "examples" / "sundials_slider_crank.yaml"))
    bars = sr.System(four_bars(40))
    found = [
        Problem("slider_crank", crank, lambda run: run["rod"].position[-1, :2], 10.0, (1.0235785589798, 0.0),
                (250, 500, 1000, 2000)),
        Problem("four_bars:40", bars, lambda run: 2 * run["upright_0"].position[-1, :2], 10.0,
                (0.180512226686728, 0.983572740582312), (1000, 2000, 5000)),
    ]  # fmt: skip
    for n in (10, 100) if quick else (10, 100, 1000, 10000):
        counts = (100,) if n > 1000 else (100, 400)
        found.append(
            Problem(f"chain:{n}", chain(n), lambda run: 2 * run["rod_0"].position[-1, :2], 0.5, None, counts)
        )
    return found


def chain(n: int) -> Any:
    """Rods of 1 m and 1 kg in a row, pinned to each other and to the ground, that fall."""
    import sarrus as sr

    bodies = [
        sr.Body(f"rod_{k}", mass=1, inertia=(1 / 1200, 1 / 12, 1 / 12), position=(k + 0.5, 0, 0))
        for k in range(n)
    ]
    pairs = zip([sr.ground, *bodies], bodies, strict=False)
    joints = [
        sr.Revolute(f"pin_{k}", i, j, point=(float(k), 0, 0), axis=(0, 0, 1))
        for k, (i, j) in enumerate(pairs)
    ]
    return sr.System(sr.Model(f"chain of {n}", bodies, joints, gravity=(0, -9.81, 0)))


def ours(problem: Problem, start: Any, steps: int, tol: float = 1e-6) -> dict[str, Any]:
    """One run with steps of one length."""
    import sarrus as sr

    method = sr.GeneralizedAlpha(0.9, step=problem.until / steps)
    return timed(problem, start, method, tol)


def timed(problem: Problem, start: Any, method: Any, tol: float) -> dict[str, Any]:
    """Seconds, steps and the end of a run."""
    import sarrus as sr

    began = time.process_time()
    run = sr.simulate(
        problem.system, start, until=problem.until, t_eval=[problem.until], method=method, rtol=tol, atol=tol
    )
    taken = time.process_time() - began
    end = problem.point(run).tolist() if run.success else [np.nan, np.nan]
    return {"seconds": taken, "steps": run.nsteps, "end": end, "message": run.message}


def theirs(python: str, problem: Problem, steps: int) -> dict[str, Any]:
    """One run of Exudyn."""
    command = [python, str(HERE / "exudyn_run.py"), problem.name, str(steps)]
    out = subprocess.run(command, capture_output=True, text=True, check=True, timeout=900).stdout
    found: dict[str, Any] = json.loads(out.split("RESULT", 1)[1])
    return found


def error(problem: Problem, run: dict[str, Any]) -> float:
    """Of the end."""
    if problem.reference is None:
        return float("nan")
    return float(np.hypot(*(np.array(run["end"]) - problem.reference)))


def compared(problem: Problem, python: str | None) -> dict[str, Any]:
    """All runs of one problem: the least seconds of some rounds, in turns."""
    import sarrus as sr

    start = sr.assemble(problem.system)
    ours(problem, start, problem.steps[0])  # compiled, or found
    rows = []
    for steps in problem.steps:
        mine, other = [], []
        for _ in range(1 if problem.name.endswith("0000") else ROUNDS):
            mine.append(ours(problem, start, steps))
            if python and not problem.name.endswith("0000"):
                other.append(theirs(python, problem, steps))
        rows.append(
            {"steps": steps, "sarrus": best(problem, mine), "exudyn": best(problem, other) if other else None}
        )
    free = []
    if problem.reference is not None:
        for tol in (1e-5, 1e-6, 1e-7, 1e-8):
            for method in (sr.HHT(-0.05), sr.Radau()):
                runs = [timed(problem, start, method, tol) for _ in range(2)]
                free.append({"method": type(method).__name__, "tol": tol, **best(problem, runs)})
    found = {"problem": problem.name, "coordinates": problem.system.nq, "steps": rows, "free": free}
    return found | ({"bytes_a_body": memory(problem, start)} if problem.name.startswith("chain") else {})


def memory(problem: Problem, start: Any) -> float:
    """The most that a run of two steps has allocated, for each body."""
    import sarrus as sr

    end, method = problem.until / 100, sr.GeneralizedAlpha(0.9, step=problem.until / 200)
    tracemalloc.start()
    sr.simulate(problem.system, start, until=end, t_eval=[end], method=method)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / len(problem.system.bodies)


def share_of_python() -> float:
    """Part of the processor time of the vehicle's run over a bump that is not spent in compiled loops."""
    from hmmwv_bump import SPEED, bump, moved, vehicle

    import sarrus as sr
    from sarrus.analyses.dynamics import alpha, sampler

    system = sr.System(vehicle({"left": bump}))
    start = moved(system, speed=SPEED)

    def run() -> sr.Trajectory:
        return sr.simulate(system, start, until=4.0, rtol=1e-6, atol=1e-7, max_step=0.02)

    run()
    spent: list[float] = []

    def watched(loop: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            began = time.process_time()
            result = loop(*arguments)
            spent.append(time.process_time() - began)
            return result

        return call

    advance, (sample, settle) = alpha.compiled_parts()["advance"], sampler._compiled()
    with (
        patch.object(alpha, "compiled_parts", lambda: {"advance": watched(advance)}),
        patch.object(sampler, "_compiled", lambda: (watched(sample), settle)),
    ):
        began = time.process_time()
        run()
        return 1 - sum(spent) / (time.process_time() - began)


def best(problem: Problem, runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The quickest of some runs, with its error."""
    quickest = min(runs, key=lambda run: run["seconds"])
    return {
        "seconds": quickest["seconds"],
        "microseconds_a_step": 1e6 * quickest["seconds"] / max(quickest["steps"], 1),
        "taken": quickest["steps"],
        "error": error(problem, quickest),
        "end": quickest["end"],
    }


def ratios(found: list[dict[str, Any]]) -> dict[str, float]:
    """Named ratios, Exudyn over Sarrus: a step, and the run to the error that Exudyn has with its finest steps."""
    result = {}
    for one in found:
        pairs = [row for row in one["steps"] if row["exudyn"]]
        if pairs:
            name = one["problem"].replace(":", "_")
            both = [
                row["exudyn"]["microseconds_a_step"] / row["sarrus"]["microseconds_a_step"] for row in pairs
            ]
            result[f"{name}_step_for_step"] = float(np.median(both))
            goal = pairs[-1]["exudyn"]
            mine = [*(row["sarrus"] for row in one["steps"]), *one["free"]]
            good = [run["seconds"] for run in mine if run["error"] <= goal["error"]]
            if good:
                result[f"{name}_same_error"] = goal["seconds"] / min(good)
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quick", action="store_true", help="short chains only")
    parser.add_argument("--only", help="problems whose name begins so")
    parser.add_argument("--exudyn", metavar="PYTHON", help="an interpreter that has exudyn")
    chosen = parser.parse_args()
    wanted = [p for p in problems(chosen.quick) if p.name.startswith(chosen.only or "")]
    found = [compared(problem, chosen.exudyn) for problem in wanted]
    named = ratios(found)
    if not chosen.only:
        named["hmmwv_share_of_python"] = share_of_python()
    if chosen.json:
        print(json.dumps({"problems": found, "ratios": named}, indent=1))
        return
    for one in found:
        print(f"{one['problem']}, {one['coordinates']} coordinates")
        for row in one["steps"]:
            for code in ("sarrus", "exudyn"):
                if row[code]:
                    show(f"{code}, {row['steps']} equal steps", row[code])
        for run in one["free"]:
            show(f"sarrus, {run['method']}, {run['tol']:g}", run)
        if "bytes_a_body" in one:
            print(f"  memory: {one['bytes_a_body'] / 1e3:.1f} kB a body")
    for name, value in named.items():
        print(f"{name}: {value:.2f}")


def show(title: str, run: dict[str, Any]) -> None:
    figures = f"{run['seconds']:9.4f} s {run['taken']:7d} steps {run['microseconds_a_step']:9.1f} us a step"
    print(f"  {title:<32} {figures}   error {run['error']:.2e}")


if __name__ == "__main__":
    main()
