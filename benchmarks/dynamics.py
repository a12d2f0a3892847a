"""Simulations beside Exudyn: seconds a step, and seconds to the same measured error; chains of growing length.

    python benchmarks/dynamics.py [--json] [--quick] [--only NAME] [--exudyn PYTHON]

PYTHON is an interpreter that has the package exudyn. Both codes run on one thread, in turns, and seconds are those of
the processor, the least of some runs; the error is the largest distance of some points at the end from a reference.
Both use generalized-α with rho_inf = 0.9 and steps of one length; Sarrus also chooses its steps. Models are told to
Exudyn as they are in Sarrus (`exudyn_told.py`). The memory of a chain is the most that a run of two steps has
allocated above its system.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable, Iterator
from typing import Any
from unittest.mock import patch

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import dynamics_problems as known  # noqa: E402  after the number of threads is set
import numpy as np  # noqa: E402
from dynamics_problems import Problem  # noqa: E402
from dynamics_runs import Compared  # noqa: E402

import sarrus as sr  # noqa: E402

FEW = (1e-4, 1e-6)  # tolerances that are tried in a hurry
LONG = (100, 1000, 10000)  # bodies of the chains that are looked at alone


def problems(quick: bool) -> Iterator[Callable[[], Problem]]:
    """All that are compared, made when they are wanted."""
    yield known.slider_crank
    yield known.andrews
    yield known.hmmwv
    yield known.four_bars
    yield lambda: known.chain(10, (100, 400))
    yield lambda: known.chain(100, (100, 400))
    if not quick:
        yield lambda: known.chain(1000, (100,))


def long_chain(n: int) -> dict[str, Any]:
    """A chain alone: a step, the set-up with two steps, memory; the difference of runs of 22 and of 2 steps."""
    problem = known.chain(n, (100,))
    compared = Compared(problem._replace(referenced=False), None)
    h = problem.until / 200

    def seconds(steps: int) -> float:
        began = time.process_time()
        end, method = steps * h, sr.GeneralizedAlpha(0.9, step=h)
        sr.simulate(problem.system, problem.start, until=end, t_eval=[end], method=method)
        return time.process_time() - began

    seconds(2)
    short, longer = (min(seconds(steps) for _ in range(1 if n > 1000 else 3)) for steps in (2, 22))
    told = {"microseconds_a_step_and_body": 1e6 * (longer - short) / 20 / n, "seconds_of_two_steps": short}
    return {"bodies": n, **told, "bytes_a_body": compared.memory()}


def share_of_python() -> float:
    """Part of the processor time of the vehicle's run over a bump that is not spent in compiled loops.

    The run of examples/hmmwv_bump.py, 4 s with 1001 states wanted, the least of three; the calls of the two compiled
    functions, steps and states, are timed on the way.
    """
    from hmmwv_bump import SPEED, bump, moved, vehicle

    from sarrus._jit.linking.link import link
    from sarrus.analyses.dynamics.dense_output import sampler
    from sarrus.analyses.dynamics.integrators import described

    system = sr.System(vehicle({"left": bump}))
    start = moved(system, speed=SPEED)
    spent: list[float] = []

    def watched(loop: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            began = time.process_time()
            result = loop(*arguments)
            spent.append(time.process_time() - began)
            return result

        return call

    def watched_link(function: Callable[..., Any]) -> Callable[..., Any]:
        return watched(link(function))

    def share() -> float:
        spent.clear()
        began = time.process_time()
        sr.simulate(system, start, until=4.0, method=sr.Radau(rtol=1e-6, atol=1e-7, max_step=0.02))
        return 1 - sum(spent) / (time.process_time() - began)

    with (
        patch.object(described, "link", watched_link),
        patch.object(sampler, "link", watched_link),
    ):
        return min(share() for _ in range(4))


def ratios(found: list[dict[str, Any]], chains: list[dict[str, Any]]) -> dict[str, float]:
    """Named ratios, Exudyn over Sarrus.

    `step_for_step`: a step, the median over the numbers of equal steps. `same_error`: the run that Sarrus needs for
    the error that Exudyn has with its most steps. With `_least`: the least over all numbers of steps;
    `as_it_comes`: with Exudyn's own tolerances of Newton's method, not the loosest that would do. And of the chains,
    the time of a step and body, the longest over the shortest.
    """
    result = {}
    for one in found:
        pairs = [(row["sarrus"], row["exudyn"]) for row in one["equal_steps"] if row["exudyn"]]
        if not pairs:
            continue
        steps = [other["seconds"] / mine["seconds"] for mine, other in pairs]
        result[f"{one['problem']}_step_for_step"] = float(np.median(steps))
        result[f"{one['problem']}_step_for_step_least"] = min(steps)
        usual = [
            row["exudyn_as_it_comes"]["seconds"] / row["sarrus"]["seconds"] for row in one["equal_steps"]
        ]
        result[f"{one['problem']}_step_for_step_as_it_comes_least"] = min(usual)
        runs = [*(row["sarrus"] for row in one["equal_steps"]), *one["sarrus_alone"]]
        same = [same_error(other, runs) for _, other in pairs]
        if one["reference_to"] is not None:
            result[f"{one['problem']}_same_error"] = same[-1]
            result[f"{one['problem']}_same_error_least"] = min(same)
    a_body = [chain["microseconds_a_step_and_body"] for chain in chains]
    return result | ({"chain_step_and_body_growth": a_body[-1] / a_body[0]} if len(a_body) > 1 else {})


def same_error(other: dict[str, Any], runs: list[dict[str, Any]]) -> float:
    """Seconds of a run of Exudyn over those of the quickest of ours that is as good."""
    return float(
        other["seconds"] / min((r["seconds"] for r in runs if r["error"] <= other["error"]), default=np.inf)
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quick", action="store_true", help="short chains and fewer steps only")
    parser.add_argument("--only", help="problems whose name begins so")
    parser.add_argument("--exudyn", metavar="PYTHON", help="an interpreter that has exudyn")
    chosen = parser.parse_args()
    found, chains = [], []
    for make in problems(chosen.quick):
        problem = make()
        if problem.name.startswith(chosen.only or ""):
            few = problem._replace(steps=problem.steps[:2], tolerances=FEW) if chosen.quick else problem
            found.append(Compared(few, chosen.exudyn).found())
    if not chosen.only:
        chains = [long_chain(n) for n in (LONG[:2] if chosen.quick else LONG)]
    named = ratios(found, chains)
    if not chosen.only:
        named["hmmwv_share_of_python"] = share_of_python()
    if chosen.json:
        print(json.dumps({"problems": found, "chains": chains, "ratios": named}, indent=1))
    else:
        told(found, chains, named)


def told(found: list[dict[str, Any]], chains: list[dict[str, Any]], named: dict[str, float]) -> None:
    """All figures, for people."""
    for one in found:
        to = "none" if one["reference_to"] is None else f"to {one['reference_to']:.1e} m"
        print(f"{one['problem']}, {one['coordinates']} coordinates, reference {to}")
        for row in one["equal_steps"]:
            for code in ("sarrus", "exudyn", "exudyn_as_it_comes"):
                if row[code]:
                    show(f"{code}, {row['steps']} equal steps", row[code])
        for run in one["sarrus_alone"]:
            show("sarrus", run)
    for chain in chains:
        figures = f"{chain['microseconds_a_step_and_body']:.2f} us a step and body"
        print(f"chain of {chain['bodies']}: {figures}, {chain['bytes_a_body'] / 1e3:.1f} kB a body")
    for name, value in named.items():
        print(f"{name}: {value:.3g}")


def show(title: str, run: dict[str, Any]) -> None:
    figures = f"{run['seconds']:9.4f} s {run['steps']:7d} steps {run['microseconds_a_step']:9.1f} us a step"
    print(f"  {title:<38} {figures}   error {run['error']:.2e}  {run['told']}", flush=True)


if __name__ == "__main__":
    main()
