"""Driven motion of a six-bar with redundant constraints: time of kinematics and of a simulation, for each output time.

    python -m benchmarks.kinematics

Processor time, the least of several runs; `run` is what each further output time adds to a simulation.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from tests.analyses.driven import six_bar

import sarrus as sr

TIMES, FEW, REPEATS = 4001, 2, 7


def least(analysis: Callable[[], object]) -> float:
    """The least processor time of several runs [µs]."""
    analysis()
    found = []
    for _ in range(REPEATS):
        began = time.process_time()
        analysis()
        found.append(time.process_time() - began)
    return 1e6 * min(found)


def main() -> None:
    """Measure."""
    system, grid, ends = six_bar(), np.linspace(0.0, 1.0, TIMES), np.linspace(0.0, 1.0, FEW)
    driven = least(lambda: sr.kinematics(system, grid))
    run, short = (least(lambda t=t: sr.simulate(system, until=1.0, t_eval=t)) for t in (grid, ends))
    print(f"kinematics {driven / TIMES:.1f} µs per time, simulation {run / TIMES:.1f} µs per time")
    print(f"output times of the run {(run - short) / (TIMES - FEW):.1f} µs each")


if __name__ == "__main__":
    main()
