"""Cost of derivatives of a run: backward and forward sweeps, Hessian products, beside finite differences and CasADi.

    python benchmarks/sensitivity.py [--json] [--quick] [--casadi PYTHON]

On the vehicle, which starts with a rigid velocity on a flat road: ratios to the time of the same run without
derivatives. On the planar slider-crank of SUNDIALS: gradient of the integral of the kinetic energy by 8 numbers, beside
CasADi with IDAS (its index-1 form, adjoint), by a Python that has it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.sensitivity.chain import Chain
from sarrus.analyses.sensitivity.derivatives import as_responses
from sarrus.analyses.sensitivity.evaluation import Evaluation
from sarrus.analyses.sensitivity.hessian import Curvature
from sarrus.analyses.sensitivity.parameters import Parameters

FOLDER = Path(__file__).resolve().parent
TOLERANCES = {"rtol": 1e-5, "atol": 1e-7}
FEW, MANY = 10, 100  # columns of forward sweeps


def best(function: Callable[[], Any], repeats: int) -> float:
    """The shortest of some times [s], after a first call."""
    function()
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        function()
        times.append(time.perf_counter() - began)
    return min(times)


def rolling(system: sr.System) -> sr.Assembly:
    """The vehicle as it falls and rolls forward."""
    v = system.v0.copy().reshape(-1, 7)
    v[:, 0], v[:, 2] = 5.0, -0.3
    return sr.assemble(system, system.q0, v.reshape(-1))


def vehicle(until: float, repeats: int) -> dict[str, float]:
    """Ratios on the vehicle."""
    system = sr.System(sr.load(mechanisms.path("hmmwv")))
    start = rolling(system)

    def simulated(keep_steps: bool) -> sr.Trajectory:
        return sr.simulate(system, start, until=until, t_eval=[until], keep_steps=keep_steps, **TOLERANCES)

    forward, kept = best(lambda: simulated(False), repeats), best(lambda: simulated(True), repeats)
    run = simulated(True)
    steps, parameters = run.steps, Parameters(system, start=run.steps.start)
    comfort = as_responses(sr.Integral(lambda o: o("chassis.acceleration.z") ** 2))
    chain, evaluation = Chain(system, steps), Evaluation(system, steps, comfort, parameters)
    nodes, explicit = evaluation.gradients()
    sweep = best(lambda: parameters.gradient(chain.gradients(nodes), explicit.c), repeats)
    curvature = Curvature(chain, evaluation, parameters)
    curvature.times(np.ones(len(parameters.names)))
    product = best(lambda: curvature.times(np.ones(len(parameters.names))), repeats)
    found = {
        "steps": float(len(steps)),
        "parameters": float(len(parameters.names)),
        "forward_s": forward,
        "forward_kept_ratio": kept / forward,
        "construction_recorded_s": best(lambda: Parameters(system, start=steps.start), 1),
        "adjoint_ratio": sweep / forward,
        "hessian_product_ratio": product / forward,
        "finite_differences_ratio": 2.0 * len(parameters.names),
        "kilobytes_a_step": steps.nbytes / len(steps) / 1000,
    }
    for count in (1, FEW, MANY):
        b, q, v, _ = parameters.along(np.eye(len(parameters.names))[:, :count])
        found[f"direct_ratio_{count}"] = best(lambda b=b, q=q, v=v: chain.along(b, q, v), repeats) / forward
    found["direct_ratio_per_parameter"] = (found[f"direct_ratio_{MANY}"] - found[f"direct_ratio_{FEW}"]) / (
        MANY - FEW
    )
    return found


def published(repeats: int) -> dict[str, float]:
    """The slider-crank of SUNDIALS: simulation and gradient, and how far from the reference they are."""
    sys.path.insert(0, str(FOLDER.parent))
    from tests.sensitivity.designs import SUNDIALS, sundials, sundials_crank

    told = json.loads((FOLDER.parent / "tests/reference/S04_sundials_slider_crank.json").read_text())
    wanted, system = np.array([told["grad"]["G"][name] for name in SUNDIALS]), sundials_crank()
    energy = sr.Integral("energy.kinetic")

    def both() -> sr.Gradient:
        run = sr.simulate(system, until=10.0, t_eval=[10.0], rtol=1e-6, atol=1e-6, keep_steps=True)
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
    chosen = parser.parse_args()
    repeats = 1 if chosen.quick else 5
    found = {f"hmmwv.{k}": v for k, v in vehicle(0.3 if chosen.quick else 5.0, repeats).items()}
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
