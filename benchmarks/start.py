"""First uses of Sarrus: processor time and clock of processes, with an empty cache of kernels and with a filled one.

    python benchmarks/start.py                                  # simulate, sensitivity, hessian, script
    python benchmarks/start.py modes workspace --warm           # other actions of distribution/actions.py, filled only
    python benchmarks/start.py --json

``script`` loads the slider-crank, assembles it, simulates 10 s and computes one gradient. Each action is a process of
its own, imports included, and has its own empty cache; the filled one is what it leaves. Of three warm processes the
least processor time and the least clock count. A wheel with compiled kernels is measured by a Python that has it.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = """
import sarrus as sr
from sarrus import mechanisms
system = sr.System(sr.load(mechanisms.path("slider_crank")))
run = sr.simulate(system, sr.assemble(system), until=10.0, store="steps")
print(sr.sensitivity(run, sr.Final("slider.x")).table(most=3))
"""
ACTION = """
import sys
sys.path.insert(0, {root!r})
from distribution.actions import ACTIONS
ACTIONS[{name!r}]()
"""
USUAL = ["simulate", "sensitivity", "hessian", "script"]
REPEATS = 3


def measured(name: str, cache: str) -> tuple[float, float]:
    """Processor time and clock [s] of a process that does one action with this cache."""
    code = SCRIPT if name == "script" else ACTION.format(root=str(ROOT), name=name)
    settings = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**settings, "SARRUS_CACHE_DIR": cache},
        capture_output=True,
        text=True,
        check=False,
    )
    clock, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(f"{name}: {done.stderr}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, clock


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", default=USUAL, help="of distribution/actions.py, or script")
    parser.add_argument("--warm", action="store_true", help="with the user's cache, which is filled first")
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    found = {}
    for name in chosen.names:
        with tempfile.TemporaryDirectory() as empty:
            cache = os.environ.get("SARRUS_CACHE_DIR", "") if chosen.warm else empty
            cold = measured(name, cache)
            warm = tuple(map(min, zip(*(measured(name, cache) for _ in range(REPEATS)), strict=True)))
        found[name] = {"warm_cpu_s": warm[0], "warm_s": warm[1]}
        if not chosen.warm:
            found[name] |= {"cold_cpu_s": cold[0], "cold_s": cold[1]}
        if not chosen.json:
            print(name, *(f"{key} {value:.2f}" for key, value in found[name].items()), flush=True)
    if chosen.json:
        print(json.dumps(found))


if __name__ == "__main__":
    main()
