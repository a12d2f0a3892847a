"""The gradient of one response three ways: Sarrus, central differences of its runs, and CasADi with IDAS.

    python benchmarks/sensitivity_beside.py [--json] [--quick] [--casadi PYTHON]

The planar slider-crank of SUNDIALS, the integral of its kinetic energy over 10 s by 8 numbers, whose gradient is
known to twelve digits. Sarrus: three bodies, 21 coordinates, run and one sweep backwards. Differences: 16 more runs,
with the step that comes nearest to the known gradient. IDAS: three coordinates, by a Python that has CasADi.
Processor times, the shortest of some.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import sarrus as sr
from sensitivity import best

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
ENERGY = sr.Integral("energy.kinetic")
UNTIL = 10.0  # [s]
METHODS = {"HHT": (sr.HHT(), (1e-4, 1e-6, 1e-8)), "Radau": (sr.Radau(), (1e-4, 1e-6, 1e-8, 1e-10))}
STEPS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # [-] of a number, for its difference


class Subject:
    """The mechanism, and what is known of it."""

    def __init__(self) -> None:
        from tests.sensitivity.designs import SUNDIALS, sundials, sundials_crank

        told = json.loads((FOLDER.parent / "tests/reference/S04_sundials_slider_crank.json").read_text())
        self.design, self.formula, self.system = SUNDIALS, sundials, sundials_crank()
        self.value = told["psi"]["G"]
        self.wanted = np.array([told["grad"]["G"][name] for name in SUNDIALS])

    def run(self, keep: bool = False, **settings: Any) -> sr.Trajectory:
        """The simulation."""
        found = sr.simulate(
            self.system, until=UNTIL, t_eval=[UNTIL], store="steps" if keep else "samples", **settings
        )
        if not found.success:
            raise SystemExit(found.message)
        return found

    def gradient(self, **settings: Any) -> sr.Gradient:
        """Of a run of its own."""
        run = self.run(keep=True, **settings)
        return sr.sensitivity(run, ENERGY, [*self.design], design=self.design, formula=self.formula)

    def error(self, slopes: np.ndarray) -> float:
        """Of the largest entry."""
        return float(abs(slopes - self.wanted).max() / abs(self.wanted).max())

    def differenced(self, step: float, settings: dict[str, Any]) -> np.ndarray:
        """The gradient by central differences, a pair of runs for each number."""
        named = {"design": self.design, "formula": self.formula}
        problem = sr.Problem(self.system, ENERGY, [*self.design], until=UNTIL, **named, **settings)
        x, changes = problem.x0, step * np.diag(problem.x0)
        ends = [[problem.values(x + sign * change)[0] for sign in (1, -1)] for change in changes]
        return np.array([(up - down) / (2 * size) for (up, down), size in zip(ends, step * x, strict=True)])


def rows(subject: Subject, method: str, tolerance: float, repeats: int) -> list[dict[str, Any]]:
    """Sarrus and central differences of its runs with a method at a tolerance."""
    settings = {"method": replace(METHODS[method][0], rtol=tolerance, atol=tolerance)}
    found = subject.gradient(**settings)
    common = {"rtol": tolerance, "value_error": float(abs(found.values[0] - subject.value))}
    run = best(lambda: subject.run(**settings), repeats)
    tried = STEPS if repeats > 1 else STEPS[1:3]
    differences = {step: subject.error(subject.differenced(step, settings)) for step in tried}
    nearest = min(differences, key=lambda step: differences[step])
    return [
        {
            **common,
            "way": f"Sarrus, {method}, backwards",
            "gradient_error": subject.error(found.matrix[0]),
            "run_s": run,
            "run_and_gradient_s": best(lambda: subject.gradient(**settings), repeats),
        },
        {
            **common,
            "way": f"Sarrus, {method}, central differences, step {nearest:g}",
            "gradient_error": differences[nearest],
            "run_s": run,
            "run_and_gradient_s": run * (1 + 2 * len(subject.design)),
        },
    ]


def with_casadi(python: str) -> list[dict[str, Any]]:
    """The rows of CasADi and IDAS, in another Python."""
    call = [python, str(FOLDER / "idas_run.py"), "--table"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise SystemExit(f"CasADi did not run: {done.stderr.strip().splitlines()[-1]}")
    found = json.loads(done.stdout.strip().splitlines()[-1])
    return [row | {"way": f"CasADi, IDAS, {row['way']}"} for row in found]


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--quick", action="store_true", help="one tolerance, once")
    parser.add_argument("--casadi", metavar="PYTHON", help="a Python that has CasADi")
    chosen = parser.parse_args()
    subject = Subject()
    found = [
        row
        for method, (_, tolerances) in METHODS.items()
        for tolerance in tolerances[: 1 if chosen.quick else None]
        for row in rows(subject, method, tolerance, 1 if chosen.quick else 5)
    ]
    found += with_casadi(chosen.casadi) if chosen.casadi else []
    if chosen.json:
        print(json.dumps(found, indent=1))
        return
    print("| way | rtol | error of G | error of the gradient | run [ms] | run and gradient [ms] |")
    print("|---|---|---|---|---|---|")
    for row in sorted(found, key=lambda row: (row["way"].split(", step")[0], -row["rtol"])):
        errors = f"{row['value_error']:.1e} | {row['gradient_error']:.1e}"
        times = " | ".join(f"{1e3 * row[key]:.1f}" for key in ("run_s", "run_and_gradient_s"))
        print(f"| {row['way']} | {row['rtol']:.0e} | {errors} | {times} |")


if __name__ == "__main__":
    main()
