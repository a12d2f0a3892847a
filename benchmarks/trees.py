"""Trees without contact, from MJCF files: processor time against error, beside MuJoCo.

    python -m benchmarks.trees FILE... [--json FILE] [--until 1]

Both programs integrate the same file without limits, contacts, fluid and dry friction, from the same random state, to
the same time. Errors are the largest distance [m] of a body's origin at the end from that of a reference, MuJoCo's RK4
with a step of 1e-5 s; `reference` is the distance of Sarrus's Radau at a tolerance of 1e-10 from it. The time of each
program at equal error is interpolated in the table of its runs. Times are of the processor, the best of three, without
compiling and without the setup of the model. `call` is the time of a run of 0.1 ms, which prepares all that a longer
one does; the ratios are Radau's time over that of RK4, with and without it.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from tests.io.beside_mujoco import mujoco, random_configuration

import sarrus as sr

from .corpora import without_friction

METHODS = {
    "Radau": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8),
    "HHT": (1e-2, 1e-3, 1e-4, 1e-5),
    "DOP853": (1e-4, 1e-6, 1e-8),
}
INTEGRATORS = {
    "RK4": (0.02, 0.01, 0.005, 0.002, 0.001, 5e-4, 2e-4),
    "IMPLICIT": (0.01, 0.005, 0.002, 0.001, 5e-4, 1e-4),
}
EXACT = 1e-5  # [s] step of the reference
ERRORS = (1e-3, 1e-4, 1e-5, 1e-6)  # [m] at which times are compared
REPEATS = 3
LEFT_OUT = ("limits", "contacts", "fluid")


MAKERS = {"Radau": sr.Radau, "HHT": sr.HHT, "DOP853": lambda: sr.ODE("DOP853")}


class Problem:
    """One file in both programs, and the state from which they start."""

    def __init__(self, path: Path, until: float) -> None:
        self.until = until
        robot = sr.load_mjcf(path, inertia="given", ignore=LEFT_OUT)
        forces = without_friction(robot.forces)
        self.system = sr.System(sr.Model(robot.name, robot.bodies, robot.joints, forces, robot.gravity))
        self.spec = mujoco.MjModel.from_xml_path(str(path))
        flags = mujoco.mjtDisableBit
        self.spec.opt.disableflags |= int(flags.mjDSBL_CONTACT) | int(flags.mjDSBL_LIMIT)
        self.spec.opt.density = self.spec.opt.viscosity = 0
        self.spec.dof_frictionloss[:] = 0
        space, rng = sr.JointSpace(sr.System(robot)), np.random.default_rng(4)
        theta, self.qpos, order = random_configuration(space, self.spec, rng)
        rates = rng.normal(size=space.freedoms)
        self.qvel = rates[order]
        self.start = sr.assemble(self.system, space.q(theta), space.T(theta) @ rates)
        names = {self.spec.body(k).name or f"body{k}": k for k in range(self.spec.nbody)}
        self.bodies = {name: names[name] for name in self.system.bodies if name in names}

    def by_sarrus(self, method: str, tolerance: float) -> Any:
        return sr.simulate(
            self.system,
            self.start,
            until=self.until,
            t_eval=[self.until],
            method=replace(MAKERS[method](), rtol=tolerance, atol=tolerance),
        )

    def setup(self) -> float:
        """Return the time of a run of 0.1 ms [s]: what a call takes before the first step."""
        return timed(
            lambda: sr.simulate(self.system, self.start, until=1e-4, t_eval=[1e-4], method=sr.Radau())
        )[1]

    def by_mujoco(self, integrator: str, step: float) -> Any:
        self.spec.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
        self.spec.opt.timestep = step
        data = mujoco.MjData(self.spec)
        data.qpos[:], data.qvel[:] = self.qpos, self.qvel
        mujoco.mj_step(self.spec, data, nstep=round(self.until / step))
        mujoco.mj_kinematics(self.spec, data)
        return data

    def origins(self, run: Any) -> Any:
        """Positions of all bodies at the end. (bodies, 3)"""
        if isinstance(run, mujoco.MjData):
            return np.array([run.xpos[k] for k in self.bodies.values()])
        return np.array([run[name].position[-1] for name in self.bodies])


def timed(run: Callable[[], Any]) -> tuple[Any, float]:
    """Return the result of a function, and its shortest processor time [s] after the first call."""
    done, best = run(), np.inf
    for _ in range(REPEATS):
        begin = time.process_time()
        run()
        best = min(best, time.process_time() - begin)
    return done, best


def measured(path: Path, until: float) -> dict[str, Any]:
    """Return sizes, and for each program and method its runs: tolerance or step, error, time, steps."""
    problem = Problem(path, until)
    exact = problem.origins(problem.by_mujoco("RK4", EXACT))
    finest = problem.origins(problem.by_sarrus("Radau", 1e-10))
    found: dict[str, Any] = {
        "file": path.name,
        "bodies": len(problem.system.bodies),
        "freedoms": int(problem.spec.nv),
        "coordinates": problem.system.nq,
        "equations": problem.system.m,
        "reference": float(abs(finest - exact).max()),
        "call": problem.setup(),
        "runs": {},
    }
    for method, tolerances in METHODS.items():
        for tolerance in tolerances:
            run, seconds = timed(lambda method=method, tol=tolerance: problem.by_sarrus(method, tol))  # type: ignore[misc]
            if run.success:
                error = float(abs(problem.origins(run) - exact).max())
                found["runs"].setdefault(method, []).append([tolerance, error, seconds, run.nsteps])
    for integrator, steps in INTEGRATORS.items():
        for step in steps:
            run, seconds = timed(lambda name=integrator, step=step: problem.by_mujoco(name, step))  # type: ignore[misc]
            error = float(abs(problem.origins(run) - exact).max())
            if np.isfinite(error):
                found["runs"].setdefault(integrator, []).append([step, error, seconds, round(until / step)])
    return found


def time_at(runs: list[list[float]], error: float) -> float:
    """Return the time with which a method reaches an error, between its runs; infinite if it does not."""
    better = [(run[1], run[2]) for run in runs if run[1] <= error]
    worse = [(run[1], run[2]) for run in runs if run[1] > error]
    if not better:
        return np.inf
    after = min(better, key=lambda one: one[1])
    before = max((one for one in worse if one[1] < after[1]), key=lambda one: one[1], default=None)
    if before is None:
        return after[1]
    part = np.log(error / before[0]) / np.log(after[0] / before[0])
    return float(np.exp(np.log(before[1]) + part * np.log(after[1] / before[1])))


def printed(found: dict[str, Any]) -> None:
    """Print the times at equal errors."""
    sizes = ", ".join(f"{found[key]} {key}" for key in ("bodies", "freedoms", "coordinates", "equations"))
    print(
        f"{found['file']}: {sizes}; references differ by {found['reference']:.1e} m; call {1e3 * found['call']:.1f} ms"
    )
    for error in ERRORS:
        times = {name: 1e3 * time_at(runs, error) for name, runs in found["runs"].items()}
        text = ", ".join(f"{name} {t:.2f} ms" for name, t in times.items() if np.isfinite(t))
        radau, rk4 = times["Radau"], times["RK4"]
        ratios = (
            f"Radau over RK4 {radau / rk4:.1f}, without the call {(radau - 1e3 * found['call']) / rk4:.1f}"
        )
        print(f"  {error:g} m: {text}; {ratios}", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--until", type=float, default=1.0, help="[s]")
    parser.add_argument("--json", type=Path, help="file for all runs")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = []
    for path in chosen.files:
        rows.append(measured(path, chosen.until))
        printed(rows[-1])
    if chosen.json:
        chosen.json.write_text(json.dumps(rows, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
