"""Drift of the energy of conservative mechanisms against the tolerance, for every method.

    python benchmarks/drift.py [--json] [--quick]

Examples without dampers and drivers; the largest change of kinetic and potential energy over the run, relative to the
range of the kinetic energy.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

import sarrus as sr

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SUBJECTS = {"simple_pendulum": 10.0, "double_pendulum_3d": 5.0, "bricard": 10.0, "heavy_top": 1.0}
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)


def drift(system: sr.System, model: sr.Model, until: float, rtol: float, method: Any) -> float:
    """The largest change of the energy, over the range of the kinetic energy; none of these has springs."""
    run = sr.simulate(
        system, until=until, t_eval=np.linspace(0, until, 201), rtol=rtol, atol=rtol, method=method
    )
    mass, g = np.array([body.mass for body in model.bodies]), np.array(model.gravity)
    kinetic = np.array([system.kinetic_energy(q, v) for q, v in zip(run.q, run.v, strict=True)])
    height = run.q.reshape(len(run.t), -1, 7)[:, :, :3] @ -g
    energy = kinetic + height @ mass
    return float(np.max(abs(energy - energy[0])) / np.ptp(kinetic)) if run.success else float("nan")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="one example, two tolerances")
    given = parser.parse_args()
    methods = {"HHT": sr.HHT(), "Radau": sr.Radau(), "DOP853": sr.ODE()}
    found: dict[str, float] = {}
    for name, until in list(SUBJECTS.items())[: 1 if given.quick else None]:
        model = sr.load(EXAMPLES / f"{name}.yaml")
        system = sr.System(model)
        for rtol in TOLERANCES[1:3] if given.quick else TOLERANCES:
            for label, method in methods.items():
                found[f"{name}.{rtol:.0e}.{label}"] = drift(system, model, until, rtol, method)
                if not given.json:
                    print(
                        f"{name}.{rtol:.0e}.{label:8s} {found[f'{name}.{rtol:.0e}.{label}']:.1e}", flush=True
                    )
    if given.json:
        print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
