"""A vehicle of 14 bodies with four tyres of the Magic Formula in a lane change of 10 s, and its gradient.

    python benchmarks/vehicles.py [--json] [--quick] [--exudyn PYTHON]

Processor time on one thread, the least of some calls behind the first one. `real_time` is the length of the motion over
the time of the run, with the default method and tolerances and 1001 outputs; `gradient` are derivatives of a response
by all parameters as multiples of the run that stores its steps. PYTHON is an interpreter that has exudyn: with it,
both programs simulate a shorter lane change, see `vehicles_beside.py`.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402  after the number of threads is set
import vehicles_beside  # noqa: E402

import sarrus as sr  # noqa: E402

SPEED, UNTIL = 80 / 3.6, 10.0  # [m/s], [s]
RESPONSES = {
    "final": sr.Final("chassis.y"),
    "integral": sr.Integral("chassis.acceleration_body.y**2"),
    "maximum": sr.Maximum("abs(chassis.acceleration_body.y)"),
}


def least(call: Callable[[], Any], times: int) -> float:
    """Processor seconds of a call, the least of some behind the first."""
    call()
    found = []
    for _ in range(times):
        begin = time.process_time()
        call()
        found.append(time.process_time() - begin)
    return min(found)


def measured(times: int) -> dict[str, Any]:
    """All figures of the lane change."""
    manoeuvre = sr.double_lane_change(sr.System(sr.load("car")), SPEED).run
    car, start, grid = manoeuvre.system, manoeuvre.steps.start, np.linspace(0.0, UNTIL, 1001)

    def run(**options: Any) -> sr.Trajectory:
        return sr.simulate(car, start, until=UNTIL, t_eval=grid, **options)

    stored, seconds = run(store="steps"), least(run, times)
    of_stored = least(lambda: run(store="steps"), times)
    gradients = {
        name: least(lambda one=one: sr.sensitivity(stored, one), times) / of_stored
        for name, one in RESPONSES.items()
    }
    return {
        "bodies": len(car.bodies),
        "parameters": sr.sensitivity(stored, RESPONSES["final"]).matrix.shape[1],
        "steps": int(stored.nsteps),
        "seconds": seconds,
        "real_time": UNTIL / seconds,
        "hht_real_time": UNTIL / least(lambda: run(method=sr.HHT()), times),
        "gradient": gradients,
    }


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one object")
    parser.add_argument("--quick", action="store_true", help="one call each")
    parser.add_argument("--exudyn", metavar="PYTHON", help="an interpreter that has exudyn")
    chosen = parser.parse_args(arguments)
    found = measured(1 if chosen.quick else 5)
    if chosen.exudyn:
        found["beside"] = vehicles_beside.beside(chosen.exudyn, 1 if chosen.quick else 2)
    if chosen.json:
        print(json.dumps(found, indent=2))
        return
    print(f"{found['bodies']} bodies, {found['parameters']} parameters, {found['steps']} steps")
    print(
        f"{found['seconds']:.2f} s, {found['real_time']:.1f} x real time (HHT {found['hht_real_time']:.1f} x)"
    )
    print("gradient over run: " + ", ".join(f"{name} {x:.2f}" for name, x in found["gradient"].items()))
    if "beside" in found:
        vehicles_beside.show(found["beside"])


if __name__ == "__main__":
    main()
