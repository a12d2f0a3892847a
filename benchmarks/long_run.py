"""A million steps: what remains of the constraints and of the unit length of Euler parameters, and how memory grows.

    python benchmarks/long_run.py [--json] [--steps 1000000]

``driven``: the slider-crank with its crank driven, ``undriven``: as it falls; HHT with steps of one length. A run is
made in ten parts, each from the last state of the part before; the largest constraint residual and the largest
difference of the Euler parameters' length from 1 at their ends are printed, and the growth of memory from the first
part to the last.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from typing import Any

import numpy as np

import sarrus as sr
from sarrus import mechanisms

PARTS = 10
STEP = 1e-3  # [s]


def subject(driven: bool) -> sr.System:
    """The slider-crank; driven, its crank turns at 2 rad/s."""
    model = sr.load(mechanisms.path("slider_crank"))
    if not driven:
        return sr.System(model)
    crank = next(joint for joint in model.joints if isinstance(joint, sr.Revolute))
    motor = sr.AngleDriver("motor", crank.name, "2*t")
    return sr.System(sr.Model("driven", model.bodies, model.joints, model.forces, model.gravity, [motor]))


def figures(driven: bool, steps: int) -> dict[str, Any]:
    """Residuals, lengths and memory of a run."""
    system = subject(driven)
    start: Any = sr.assemble(system)
    each, taken, begin = steps // PARTS, 0, time.perf_counter()
    residual, length, memory = 0.0, 0.0, []
    for _ in range(PARTS):
        until = start.t + each * STEP
        run = sr.simulate(
            system,
            start,
            until=until,
            t_eval=[until],
            method=sr.HHT(step=STEP),
            limits=sr.Limits(steps=10 * steps),
        )
        if not run.success:
            return {"message": run.message, "steps": taken}
        start, taken = run.final, taken + run.nsteps
        residual = max(residual, float(np.abs(system.Phi(start.q, start.t)).max()))
        lengths = np.linalg.norm(start.q.reshape(-1, 7)[:, 3:], axis=1)
        length = max(length, float(np.abs(lengths - 1).max()))
        memory.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    return {
        "steps": taken,
        "seconds": time.perf_counter() - begin,
        "residual": residual,
        "length": length,
        "megabytes_grown": memory[-1] - memory[0],
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--steps", type=int, default=1_000_000)
    chosen = parser.parse_args()
    found = {name: figures(name == "driven", chosen.steps) for name in ("driven", "undriven")}
    if chosen.json:
        print(json.dumps(found))
        return
    for name, told in found.items():
        print(
            f"{name}: "
            + ", ".join(
                f"{key} {value:.3g}" if isinstance(value, float) else f"{key} {value}"
                for key, value in told.items()
            )
        )


if __name__ == "__main__":
    main()
