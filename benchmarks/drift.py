"""Drift of the energy of conservative mechanisms against the tolerance; what stabilized methods do about constraints.

    python benchmarks/drift.py [--json] [--quick]

Energy: examples without dampers and drivers; the largest change of kinetic and potential energy over the run, relative
to the range of the kinetic energy. ``free_body.100s`` is that of a body that tumbles freely for 100 s, with Radau, and
the change of its angular momentum, relative to what they are.

Constraints, on the slider-crank over 5 s at the method's own steps, before anything is projected: the largest
|Phi_q v + Phi_t|, and the largest difference of multipliers from those that the equations of motion give there.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.dynamics.stepping.stepper import Settings
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances
from sarrus.analyses.equations.motion import EquationsOfMotion
from sarrus.analyses.equations.projection import Projection
from sarrus.euler import A, G

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SUBJECTS = {"simple_pendulum": 10.0, "double_pendulum_3d": 5.0, "bricard": 10.0, "heavy_top": 1.0}
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
TUMBLING = (1e-8, 1e-10, 1e-11, 1e-12, 1e-13)
METHODS: dict[str, Any] = {
    "HHT": sr.HHT(),
    "stabilized": sr.HHT(stabilized=True),
    "Radau": sr.Radau(),
    "DOP853": sr.ODE(),
}
SCHEMES: dict[str, Any] = {
    f"{name}{'.stabilized' if stabilized else ''}": kind(value, stabilized=stabilized)
    for name, kind, value in (("HHT", sr.HHT, -0.1), ("trapezoidal", sr.HHT, 0.0))
    for stabilized in (False, True)
}


def drift(system: sr.System, until: float, rtol: float, method: Any) -> float:
    """The largest change of the energy, over the range of the kinetic energy."""
    times = np.linspace(0, until, 201)
    run = sr.simulate(system, until=until, t_eval=times, method=replace(method, rtol=rtol, atol=rtol))
    energy = run.total_energy
    return (
        float(np.max(abs(energy - energy[0])) / np.ptp(run.kinetic_energy)) if run.success else float("nan")
    )


def tumbling(rtol: float) -> dict[str, float]:
    """The largest relative changes of energy and of angular momentum of a free body within 100 s, and the steps."""
    system, times = sr.System(sr.load(EXAMPLES / "free_body.yaml")), np.linspace(0, 100, 401)
    inertia = np.array([1.0, 2.0, 3.0])
    settings = {"t_eval": times, "method": sr.Radau(rtol=rtol, atol=rtol)}
    run = sr.simulate(system, until=100.0, **settings)
    spin = np.array(
        [A(p) @ (inertia * (2 * G(p) @ v)) for p, v in zip(run.q[:, 3:], run.v[:, 3:], strict=True)]
    )
    changed = np.linalg.norm(spin - spin[0], axis=1) / np.linalg.norm(spin[0])
    energy = abs(run.kinetic_energy / run.kinetic_energy[0] - 1)
    return {"energy": float(energy.max()), "momentum": float(changed.max()), "steps": run.nsteps}


def constraints(system: sr.System, method: Any, until: float, rtol: float) -> dict[str, float]:
    """Steps, the largest defect of velocities at them, and the largest error of multipliers."""
    start, motion = sr.assemble(system), EquationsOfMotion(system)
    stepper, project = (
        method.stepper(system, start, Settings(Tolerances.of(system, rtol, rtol))),
        Projection(system),
    )
    stepper.restart(0.0, start.q, start.v, until)
    defect, noise, largest = 0.0, 0.0, 0.0
    while stepper.t < until:
        nodes = stepper.advance(until, 400)
        for t, q, v, lam in zip(nodes.t, nodes.q, nodes.v, nodes.lam, strict=True):
            defect = max(defect, abs(system.Phi_q_xi(q, v, t) + system.Phi_t(q, t)).max())
            right = motion.acceleration(t, *project(t, q, v))[1]
            noise, largest = max(noise, abs(lam - right).max()), max(largest, abs(right).max())
    return {"steps": stepper.tally.nsteps, "defect": defect, "multipliers": noise, "largest": largest}


def measured(quick: bool) -> Iterator[tuple[str, float]]:
    """All figures by name."""
    for name, until in list(SUBJECTS.items())[: 1 if quick else None]:
        system = sr.System(sr.load(EXAMPLES / f"{name}.yaml"))
        for rtol in TOLERANCES[1:3] if quick else TOLERANCES:
            for label, method in METHODS.items():
                yield f"{name}.{rtol:.0e}.{label}", drift(system, until, rtol, method)
    for rtol in TUMBLING[:1] if quick else TUMBLING:
        yield from ((f"free_body.100s.{rtol:.0e}.{key}", value) for key, value in tumbling(rtol).items())
    crank = sr.System(sr.load(mechanisms.path("slider_crank")))
    for rtol in TOLERANCES[1:2] if quick else TOLERANCES[:3]:
        for label, method in SCHEMES.items():
            for key, value in constraints(crank, method, 5.0, rtol).items():
                yield f"slider_crank.{rtol:.0e}.{label}.{key}", value


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="one example, two tolerances")
    given = parser.parse_args()
    found: dict[str, float] = {}
    for key, value in measured(given.quick):
        found[key] = value
        if not given.json:
            print(f"{key:48s} {value:.3g}", flush=True)
    if given.json:
        print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
