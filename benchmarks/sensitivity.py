"""Cost of derivatives of a run: backward and forward sweeps, Hessian products, beside finite differences and CasADi.

    python benchmarks/sensitivity.py [--json] [--quick] [--casadi PYTHON]

By HHT and Radau, on the vehicle, which starts with a rigid velocity on a flat road, or drives over a bump, and on the
spatial slider-crank: ratios to the time of the same run without derivatives. A run of 100,000 steps by checkpoints and
with all steps kept. On the planar slider-crank of SUNDIALS: gradient of the integral of the kinetic energy by 8
numbers, beside CasADi with IDAS (its index-1 form, adjoint), by a Python that has it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.sensitivity.combined import Composite
from sarrus.analyses.sensitivity.hessian import Curvature
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.responses.evaluation import Evaluation
from sarrus.analyses.sensitivity.run_chain import RunChain

FOLDER = Path(__file__).resolve().parent
TOLERANCES = {"rtol": 1e-5, "atol": 1e-7}
METHODS = {"hht": sr.HHT(), "radau": sr.Radau()}
FEW, MANY = 10, 100  # columns of forward sweeps
WAYS, TURNS = ("checkpoints", "steps", "both"), 5  # of long runs; how often both are timed


def best(function: Callable[[], Any], repeats: int) -> float:
    """The shortest of some processor times [s], after a first call."""
    return shortest({"": function}, repeats)[""]


def shortest(functions: dict[str, Callable[[], Any]], repeats: int) -> dict[str, float]:
    """The shortest of some processor times of each [s], taken in turn, after a first call."""
    found = dict.fromkeys(functions, np.inf)
    for turn in range(repeats + 1):
        for name, function in functions.items():
            began = time.process_time()
            function()
            found[name] = min(found[name], time.process_time() - began) if turn else np.inf
    return found


def rolling(system: sr.System) -> sr.Assembly:
    """The vehicle as it falls and rolls forward."""
    v = system.v0.copy().reshape(-1, 7)
    v[:, 0], v[:, 2] = 5.0, -0.3
    return sr.assemble(system, system.q0, v.reshape(-1))


def subjects(quick: bool) -> dict[str, tuple[sr.System, sr.Assembly, dict[str, Any], sr.Response]]:
    """System, start, settings of the run, and a response, of every subject."""
    sys.path.insert(0, str(FOLDER.parent / "examples"))
    from hmmwv_bump import SPEED, bump, moved, vehicle

    comfort = sr.Integral(lambda o: o("chassis.acceleration.z") ** 2)
    flat = sr.System(sr.load(mechanisms.path("hmmwv")))
    road = sr.System(vehicle({"left": bump}))
    crank = sr.System(sr.load(mechanisms.path("slider_crank")))
    fine = {"rtol": 1e-6, "atol": 1e-7}
    over = {"until": 0.4 if quick else 4.0, "method": {**fine, "max_step": 0.02}}
    turn = {"until": 1.0 if quick else 10.0, "method": fine}
    return {
        "hmmwv": (flat, rolling(flat), {"until": 0.3 if quick else 5.0, "method": TOLERANCES}, comfort),
        "hmmwv_bump": (road, moved(road, speed=SPEED), over, comfort),
        "slider_crank": (crank, sr.assemble(crank), turn, sr.Integral("energy.kinetic")),
    }


def tight(method: Any, settings: dict[str, Any]) -> Any:
    """A method with the tolerances of a run, whose steps are in one piece, as for chains."""
    return replace(method, **settings["method"])


def ratios(
    system: sr.System, start: sr.Assembly, settings: dict[str, Any], response: sr.Response, repeats: int
) -> dict[str, float]:
    """Times of derivatives as multiples of that of the run without any."""

    def simulated(store_steps: bool) -> sr.Trajectory:
        given = {"t_eval": [settings["until"]]}
        return sr.simulate(system, start, store="steps" if store_steps else "samples", **given, **settings)

    run = simulated(True)
    steps, parameters = run.steps, Parameters(system, start=run.steps.start)
    count, wanted = len(parameters.names), Composite(response).parts
    chain, evaluation = RunChain(system, steps), Evaluation(system, steps, wanted, parameters)
    curvature, direction = Curvature(chain, evaluation, parameters), np.ones(count)
    curvature.times(direction)
    nodes, _ = evaluation.gradients()
    functions: dict[str, Callable[[], Any]] = {
        "forward": lambda: simulated(False),
        "forward_kept": lambda: simulated(True),
        "sweep": lambda: chain.gradients(nodes),
        "adjoint": lambda: _gradient(chain, evaluation, parameters),
        "sensitivity": lambda: sr.sensitivity(run, response),
        "hessian_product": lambda: curvature.times(direction),
    }
    for columns in (1, FEW, min(MANY, count)):
        b, q, v, _ = parameters.along(np.eye(count)[:, :columns])
        functions[f"direct_{columns}"] = lambda b=b, q=q, v=v: chain.weighed(nodes, b, q, v)
        functions[f"state_derivatives_{columns}"] = lambda b=b, q=q, v=v: chain.along(b, q, v)
    found = shortest(functions, repeats)
    told = {f"{name}_ratio": value / found["forward"] for name, value in found.items() if name != "forward"}
    slope = (told[f"direct_{min(MANY, count)}_ratio"] - told[f"direct_{FEW}_ratio"]) / (
        min(MANY, count) - FEW
    )
    return {
        "steps": float(len(steps)),
        "parameters": float(count),
        "forward_s": found["forward"],
        **told,
        "direct_ratio_per_parameter": slope,
        "finite_differences_ratio": 2.0 * count,
        "construction_recorded_s": best(lambda: Parameters(system, start=steps.start).recorded(), 1),
        "kilobytes_a_step": steps.nbytes / len(steps) / 1000,
    }


def _gradient(chain: RunChain, evaluation: Evaluation, parameters: Parameters) -> Any:
    """One sweep backwards, and the way through start, assembly and the model's construction."""
    nodes, explicit = evaluation.gradients()
    return parameters.gradient(chain.gradients(nodes), explicit.c)


def long_run(way: str, quick: bool) -> dict[str, float]:
    """Time and memory of a gradient over 100,000 steps of the slider-crank, by a process of its own.

    Another process before it compiles what is not there yet: compiling takes more memory than the run.
    """
    for more in (["--quick"], ["--quick"] if quick else []):
        call = [sys.executable, __file__, "--long", way, *more]
        done = subprocess.run(call, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def measured_long_run(way: str, steps: int) -> dict[str, float]:
    """The same in this process; of "both" the least and the largest of some ratios of their times, taken in turn."""
    system = sr.System(sr.load(mechanisms.path("slider_crank")))
    settings: dict[str, Any] = {"method": sr.Radau(rtol=1e-6, atol=1e-7, max_step=1e-3)}
    energy = sr.Integral("energy.kinetic")

    def by_checkpoints(until: float) -> float:
        run = sr.simulate(system, until=until, t_eval=[until], **settings)
        began = time.process_time()
        sr.sensitivity(run, energy, memory="100 MB")  # which repeats the run
        return time.process_time() - began

    def by_steps(until: float) -> float:
        began = time.process_time()
        run = sr.simulate(system, until=until, t_eval=[until], store="steps", **settings)
        sr.sensitivity(run, energy)
        return time.process_time() - began

    by_checkpoints(0.1), by_steps(0.1)
    if way == "both":
        pairs = [(by_checkpoints(1e-3 * steps), by_steps(1e-3 * steps)) for _ in range(TURNS)]
        found = [one / other for one, other in pairs]
        return {"time_ratio_least": min(found), "time_ratio_most": max(found)}
    before = _peak()
    seconds = {"checkpoints": by_checkpoints, "steps": by_steps}[way](1e-3 * steps)
    return {"s": seconds, "peak_MB": _peak(), "peak_before_MB": before}


def _peak() -> float:
    """The most memory that this process has had [MB]; what `getrusage` tells may be that of the one that began it."""
    told = Path("/proc/self/status").read_text().split("VmHWM:")[1]
    return float(told.split()[0]) / 1024


def published(repeats: int) -> dict[str, float]:
    """The slider-crank of SUNDIALS: simulation and gradient, and how far from the reference they are."""
    sys.path.insert(0, str(FOLDER.parent))
    from tests.sensitivity.designs import SUNDIALS, sundials, sundials_crank

    told = json.loads((FOLDER.parent / "tests/reference/S04_sundials_slider_crank.json").read_text())
    wanted, system = np.array([told["grad"]["G"][name] for name in SUNDIALS]), sundials_crank()
    energy = sr.Integral("energy.kinetic")

    def both() -> sr.Gradient:
        run = sr.simulate(
            system, until=10.0, t_eval=[10.0], method=sr.Radau(rtol=1e-6, atol=1e-6), store="steps"
        )
        return sr.sensitivity(run, energy, list(SUNDIALS), design=SUNDIALS, formula=sundials)

    error = abs(both().matrix[0] - wanted).max() / abs(wanted).max()
    return {"run_and_gradient_s": best(both, repeats), "gradient_error": float(error)}


def with_casadi(python: str) -> dict[str, float]:
    """The same by CasADi and IDAS, in another Python."""
    done = subprocess.run([python, str(FOLDER / "idas_run.py")], capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise SystemExit(f"CasADi did not run: {done.stderr.strip().splitlines()[-1]}")
    return dict(json.loads(done.stdout))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quick", action="store_true", help="a short run, once")
    parser.add_argument("--casadi", metavar="PYTHON", help="a Python that has CasADi")
    parser.add_argument("--long", choices=WAYS, help="only the long run, in this process")
    chosen = parser.parse_args()
    if chosen.long:
        print(json.dumps(measured_long_run(chosen.long, 2000 if chosen.quick else 100_000)))
        return
    repeats = 1 if chosen.quick else 5
    found = {
        f"{name}.{method}.{key}": value
        for name, (system, start, settings, response) in subjects(chosen.quick).items()
        for method, own in METHODS.items()
        for key, value in ratios(
            system, start, settings | {"method": tight(own, settings)}, response, repeats
        ).items()
    }
    for way in WAYS:
        told = long_run(way, chosen.quick)
        found |= {f"long_run.{way}_{key}": value for key, value in told.items()}
    found |= {f"sundials_crank.{k}": v for k, v in published(repeats).items()}
    if chosen.casadi:
        found |= {f"sundials_crank.casadi_{k}": v for k, v in with_casadi(chosen.casadi).items()}
    if chosen.json:
        print(json.dumps(found, indent=1))
        return
    for name, value in found.items():
        print(f"{name:<45}{value:>12.5g}")


if __name__ == "__main__":
    main()
