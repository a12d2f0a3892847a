"""The car beside Exudyn: it coasts through a lane change, steered by a sine of the time, with the same tyres.

Drive and brakes are left out of both. The tyres of Exudyn are user functions in Python, which evaluate the formulas of
Sarrus, with the deflections and spins as states; what they take is told apart. The error is the largest distance of
six points of the car at the end from a run of Sarrus with tight tolerances.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from exudyn_told import Exudyn, Told

import sarrus as sr
from sarrus import euler

UNTIL, STEER = 4.0, 0.6  # [s], one period; [rad]
DRIVE = ("cruise", "motor", "axle", "speed", "brake", "drive")  # left out, with the brakes
SERVO = {"k": 2e6, "c": 2e4}  # [N/m], [N s/m] of car.yaml
STEPS = (250, 500, 1000)
NEWTON = {
    "relativeTolerance": 1e-6,
    "absoluteTolerance": 1e-8,
}  # looser than by default: quicker, and errors are no larger
POINTS = [("chassis", (x, 0.0, 0.0)) for x in (1.0, -1.0)] + [
    (f"upright_{axle}_{side}", (0.0, 0.0, 0.0)) for axle in ("front", "rear") for side in ("left", "right")
]


def coasting() -> sr.System:
    """The car without its drive and its brakes."""
    car = sr.load("car")
    forces = [one for one in car.forces if one.name not in DRIVE and not one.name.startswith("brake")]
    return sr.System(replace(car, forces=forces))


def told(system: sr.System, start: sr.Assembly) -> Told:
    """What Exudyn is told: bodies, joints and springs by `Told`, then the tyres, bars and the rack."""
    model, poses = system.model, system.model.design_poses()
    springs = replace(model, forces=[one for one in model.forces if isinstance(one, sr.TSDA)])
    own = np.concatenate([np.r_[system.coordinates_of(body)] for body in system.bodies])
    result = Told(sr.System(springs), SimpleNamespace(q=start.q[own], v=start.v[own]), POINTS, ())  # type: ignore[arg-type]
    frames = {
        joint.name: {end: part[end] for end in "ij"}
        for joint, part in zip(model.joints, result.data["joints"], strict=True)
        if part["type"] == "generic"
    }
    more: list[dict[str, Any]] = []
    for tyre in model.forces:
        if not isinstance(tyre, sr.MagicFormulaTyre):
            continue
        (_, coefficients), (primitive, _) = tyre.tyre_law(), tyre.primitives(poses)
        common = len(primitive.values) - len(coefficients) - 1
        states = [f"{tyre.name}.{word}" for word in ("deflection_x", "deflection_y", "spin")]
        more.append(
            {
                "type": "rolling_tyre",
                "body": primitive.bodies[1],
                "coefficients": {name: float(value) for name, value in coefficients.items()},
                "values": [np.array(value).tolist() for value in primitive.values[:common]],
                "inertia": tyre.spin_inertia,
                "start": [float(start.v[system.states[name].place]) for name in states],
            }
        )
    for axle in ("front", "rear"):
        sides = {side: frames[f"lower_pivot_{axle}_{side}"] for side in ("left", "right")}
        more.append({"type": "bar", **sides, "k": model.parameters[f"{axle}_bar"]})
    radius = model.parameters["pinion_radius"]
    rack = {"joint": frames["rack_guide"], "radius": radius, "amplitude": STEER, "period": UNTIL}
    result.data["forces"] += [*more, {"type": "steered", **rack, **SERVO}]
    return result


def end(run: sr.Trajectory) -> np.ndarray:
    """The points at the end."""
    places = [
        run[body].position[-1] + np.array(euler.rotate(run[body].euler[-1], np.array(at)), dtype=float)
        for body, at in POINTS
    ]
    return np.array(places)


def beside(python: str, times: int) -> dict[str, Any]:
    """Processor seconds of both, in turns, and the largest distance of a point from a reference [m]."""
    system = coasting()
    start = sr.rolling_start(system, 80 / 3.6)
    steer = {"steer": f"{STEER}*sin(2*pi*t/{UNTIL})"}

    def ours(**options: Any) -> dict[str, Any]:
        began = time.process_time()
        run = sr.simulate(system, start, until=UNTIL, t_eval=[0.0, UNTIL], inputs=steer, **options)
        return {"seconds": time.process_time() - began, "steps": int(run.nsteps), "end": end(run)}

    reference, check = (ours(method=sr.Radau(rtol=tol, atol=tol))["end"] for tol in (1e-10, 1e-9))
    peer = Exudyn(python, told(system, start), "exudyn_vehicle.py")
    ways: dict[str, Callable[[], dict[str, Any]]] = {
        "Sarrus, Radau": ours,
        "Sarrus, Radau, 1e-6": lambda: ours(method=sr.Radau(rtol=1e-6, atol=1e-6)),
        "Sarrus, HHT": lambda: ours(method=sr.HHT()),
    }
    for n in STEPS:
        ways[f"Exudyn, {n} steps"] = lambda n=n: peer.run(
            steps=n, until=UNTIL, solver="sparse", newton=NEWTON
        )
    found: dict[str, Any] = {}
    for name, run in [*ways.items()] * times:
        one = run()
        if "trouble" in one:
            raise RuntimeError(f"{name}: {one['trouble']}")
        one["end"] = np.array(one["end"])
        if name not in found or one["seconds"] < found[name]["seconds"]:
            found[name] = one
    peer.close()
    rows = {name: _row(one, reference) for name, one in found.items()}
    return {"reference_to": distance(check, reference), "runs": rows}


def _row(one: dict[str, Any], reference: np.ndarray) -> dict[str, float]:
    """Figures of a run."""
    figures = {name: one[name] for name in ("seconds", "steps", "spent") if name in one}
    return {**figures, "error": distance(one["end"], reference)}


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """The largest distance of a point [m]."""
    return float(np.linalg.norm(one - other, axis=1).max())


def show(found: dict[str, Any]) -> None:
    """All figures, for people."""
    print(f"coasting lane change of {UNTIL:g} s, reference to {found['reference_to']:.1e} m")
    for name, run in found["runs"].items():
        tyres = f", {run['spent']:.2f} s of it in the tyres" if "spent" in run else ""
        figures = f"{run['seconds']:8.3f} s {run['steps']:5d} steps, error {run['error']:.1e} m"
        print(f"  {name:20} {figures}{tyres}")
