"""Processor time of a step of Radau as a multiple of that of HHT, with equal tolerances.

    python benchmarks/steps.py [--json] [--quick]

On the vehicle on a flat road and on 40 four-bar mechanisms. Rejected steps count: they cost as much as accepted ones.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import sarrus as sr
from sarrus import mechanisms
from sensitivity import rolling

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "examples"))
METHODS: dict[str, Any] = {"hht": sr.HHT(), "radau": sr.Radau()}
TOLERANCES = (1e-5, 1e-6, 1e-7)
REPEATS = 5
warnings.simplefilter(
    "ignore", sr.SarrusWarning
)  # the four-bars pass a position where all links are collinear


def subjects() -> dict[str, tuple[sr.System, sr.Assembly, float]]:
    """System, start and end [s] of each."""
    from four_bars import four_bars

    flat, bars = sr.System(sr.load(mechanisms.path("hmmwv"))), sr.System(four_bars(40))
    return {"hmmwv": (flat, rolling(flat), 5.0), "four_bars_40": (bars, sr.assemble(bars), 1.0)}


def measured(quick: bool) -> dict[str, float]:
    """Time of a step, how many there are, and the ratio, by subject and tolerance."""
    found: dict[str, float] = {}
    for name, (system, start, until) in subjects().items():
        for rtol in TOLERANCES[1:2] if quick else TOLERANCES:
            times = dict.fromkeys(METHODS, float("inf"))
            for _ in range(2 if quick else REPEATS + 1):
                for label, method in METHODS.items():
                    began = time.process_time()
                    run = sr.simulate(
                        system,
                        start,
                        until=until,
                        t_eval=[until],
                        method=replace(method, rtol=rtol, atol=rtol),
                    )
                    steps = run.nsteps + run.nrejected
                    times[label] = min(times[label], (time.process_time() - began) / steps)
                    found[f"{name}.{rtol:.0e}.{label}.steps"] = float(steps)
            found |= {f"{name}.{rtol:.0e}.{label}.step_s": own for label, own in times.items()}
            found[f"{name}.{rtol:.0e}.ratio"] = times["radau"] / times["hht"]
    return found


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--quick", action="store_true", help="one tolerance, two repetitions")
    given = parser.parse_args()
    found = measured(given.quick)
    print(json.dumps(found) if given.json else "\n".join(f"{key:40s} {x:.4g}" for key, x in found.items()))


if __name__ == "__main__":
    main()
