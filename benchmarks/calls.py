"""Everyday calls: processor time of the first one in a process and of later ones, for a slider-crank and a vehicle.

    python benchmarks/calls.py [--json] [--quick] [--only NAME]

The first call finds its kernels in the cache and makes what is kept with the system; of later calls the least counts.
`simulate` goes over 0.1 ms with one state, which is what a run takes beside its steps; derivatives are ratios to the
time of the run that they belong to, which has stored steps and begins and ends with them. `readme` is a process that
runs the Python blocks of README.md as one script: all of it, and what it takes to import the packages that they use.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402  after the number of threads is set

import sarrus as sr  # noqa: E402
from sarrus import mechanisms  # noqa: E402

README = Path(__file__).parents[1] / "README.md"
IMPORTS = "import numba, numpy, pydantic, scipy.linalg, scipy.sparse.linalg, yaml\n"  # other packages
SHORT = 1e-4  # s: a run of one step or two
METHODS = {"hht": sr.HHT(), "radau": sr.Radau()}


class Subject(NamedTuple):
    """A mechanism, its start, a coordinate that is looked at, whether that has a range, and the end of runs. [s]"""

    model: sr.Model
    system: sr.System
    start: sr.Assembly
    output: str
    closed: bool
    until: float


def subjects(quick: bool) -> dict[str, Subject]:
    """The mechanisms."""
    found = {}
    for name, output, closed, until in (
        ("slider_crank", "slider.x", True, 10.0),
        ("hmmwv", "chassis.z", False, 2.0),
    ):
        model = sr.load(mechanisms.path(name))
        system = sr.System(model)
        end = 0.1 * until if quick else until
        found[name] = Subject(model, system, sr.assemble(system), output, closed, end)
    return found


def calls(of: Subject) -> dict[str, Callable[[], Any]]:
    """Calls that need no run."""

    def shortly(method: Any) -> sr.Trajectory:
        return sr.simulate(of.system, of.start, until=SHORT, t_eval=[SHORT], method=method)

    rest = sr.equilibrium(of.system)
    found = {
        "System": lambda: sr.System(of.model),
        "assemble": lambda: sr.assemble(of.system),
        "simulate.hht": lambda: shortly(METHODS["hht"]),
        "simulate.radau": lambda: shortly(METHODS["radau"]),
        "simulate.equal_steps": lambda: shortly(sr.HHT(step=SHORT)),
        "equilibrium": lambda: sr.equilibrium(of.system),
        "linearize": lambda: sr.linearize(of.system, rest),
    }
    if of.closed:
        found["workspace_range"] = lambda: sr.workspace_range(of.system, of.output)
    return found


def derivatives(of: Subject, method: str) -> dict[str, float]:
    """A run with 1001 states, its outputs, and derivatives and errors of it as multiples of the run."""

    def simulated() -> sr.Trajectory:
        return sr.simulate(of.system, of.start, until=of.until, method=METHODS[method], store="steps")

    responses = {"final": sr.Final, "integral": sr.Integral, "maximum": sr.Maximum}
    run = simulated()
    parts: dict[str, Callable[[], Any]] = {
        **{name: lambda kind=kind: sr.sensitivity(run, kind(of.output)) for name, kind in responses.items()},
        "error": lambda: run.error(sr.Final(of.output)),
    }
    first, later = timed(simulated)
    _, looked = timed(lambda: simulated()[of.output])
    found = {"run.first_ms": first, "run.later_ms": later, "one_output.later_ms": looked - later}
    for name, part in parts.items():
        first, again = timed(part)
        found |= {f"{name}.first_ratio": first / later, f"{name}.later_ratio": again / later}
    return {f"{method}.{name}": value for name, value in found.items()}


def timed(call: Callable[[], Any]) -> tuple[float, float]:
    """The processor time of the first call, and the least of some later ones. [ms]"""
    times = list[float]()
    while len(times) < 3 or (len(times) < 30 and sum(times) < 0.5):
        began = time.process_time()
        call()
        times.append(time.process_time() - began)
    return 1e3 * times[0], 1e3 * min(times[1:])


def measured(of: Subject) -> dict[str, float]:
    """All figures of a mechanism."""
    found = dict[str, float]()
    for name, call in calls(of).items():
        first, later = timed(call)
        found |= {f"{name}.first_ms": first, f"{name}.later_ms": later}
    for method in METHODS:
        found |= derivatives(of, method)
    return found


def readme() -> dict[str, float]:
    """Processor times of warm processes: README's Python blocks as one script, and the imports of other packages."""
    code = "".join(re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL))
    return {f"readme.{name}_ms": script(text) for name, text in (("all", code), ("imports", IMPORTS))}


def script(text: str) -> float:
    """The least processor time of some processes that run a text, after one that fills the cache. [ms]"""
    text += "import sys, time\nprint(time.process_time(), file=sys.stderr)"
    runs = [
        subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
        for _ in range(4)
    ]
    return 1e3 * min(float(run.stderr.split()[-1]) for run in runs[1:])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quick", action="store_true", help="short runs")
    parser.add_argument("--only", help="the mechanism of this name, or readme")
    chosen = parser.parse_args()
    figures: dict[str, float] = readme() if chosen.only in (None, "readme") else {}
    for name, subject in subjects(chosen.quick).items():
        if chosen.only in (None, name):
            figures |= {f"{name}.{key}": value for key, value in measured(subject).items()}
    if chosen.json:
        print(json.dumps(figures, indent=1))
    else:
        for name, value in figures.items():
            print(f"{name:<48} {np.round(value, 3):10.3f}")


if __name__ == "__main__":
    main()
