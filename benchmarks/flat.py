"""N four-bars in a row over positions where all links lie in one line: errors and steps of every method.

    python benchmarks/flat.py [--json] [--quick]

10 s with ten such positions; the angle is known from the equation of a pendulum. Errors are the largest of a point's
coordinates at 501 times, in m. ``pendulum`` is a rigid one with the same equation of motion.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import sarrus as sr

EXAMPLE = Path(__file__).resolve().parent.parent / "examples" / "four_bars.py"
G, UNTIL = 9.81, 10.0
COUNTS, TOLERANCES = (1, 2, 10, 40), (1e-4, 1e-6, 1e-8, 1e-10)
METHODS: dict[str, Any] = {"HHT": sr.HHT(), "Radau": sr.Radau(), "DOP853": sr.ODE()}


def stiffness(n: int) -> float:
    """c of the equation of motion, angle'' = c sin(angle), from the vertical."""
    return G * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)


def bars(n: int) -> sr.System:
    """The example."""
    spec = importlib.util.spec_from_file_location("four_bars", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    return sr.System(example.four_bars(n))


def pendulum(n: int) -> sr.System:
    """A rigid body with the same equation of motion; its centre goes as that of the first upright bar."""
    motion = {"position": (0, 0.5, 0), "velocity": (0.5, 0, 0), "angular_velocity": (0, 0, -1)}
    rod = sr.Body("upright_0", mass=1, inertia=(1, 1, 0.5 * G / stiffness(n) - 0.25), **motion)
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("pendulum", [rod], [pin], gravity=(0, -G, 0)))


def error(system: sr.System, n: int, rtol: float, method: Any) -> tuple[float, int]:
    """The largest error (not a number where the end is not reached), and the steps."""
    times = np.linspace(0, UNTIL, 501)
    run = sr.simulate(system, until=UNTIL, t_eval=times, method=replace(method, rtol=rtol, atol=rtol))
    if not run.success:
        return float("nan"), run.nsteps
    exact = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, "t_eval": times}
    angle = solve_ivp(lambda t, y: [y[1], stiffness(n) * np.sin(y[0])], (0, UNTIL), [0, 1.0], **exact).y[0]
    place = 2 * run["upright_0"].position[:, :2] - np.column_stack([np.sin(angle), np.cos(angle)])
    return float(abs(place).max()), run.nsteps


def measured(quick: bool) -> Iterator[tuple[str, float]]:
    """Error and steps under names like ``2.1e-06.Radau.error``."""
    for n in COUNTS[:1] if quick else COUNTS:
        for rtol in TOLERANCES[1:3] if quick else TOLERANCES[: 3 if n == COUNTS[-1] else None]:
            for label, method in METHODS.items():
                found, steps = error(bars(n), n, rtol, method)
                yield f"{n}.{rtol:.0e}.{label}.error", found
                yield f"{n}.{rtol:.0e}.{label}.steps", steps
            yield f"{n}.{rtol:.0e}.pendulum.error", error(pendulum(n), n, rtol, METHODS["HHT"])[0]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="one four-bar, two tolerances")
    given = parser.parse_args()
    found: dict[str, float] = {}
    for key, value in measured(given.quick):
        found[key] = value
        if not given.json:
            print(f"{key:28s} {value:.3g}", flush=True)
    if given.json:
        print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
