"""The 14-body vehicle drops onto its tyres, drives over a bump with its left wheels, and is steered by its rack.

python examples/hmmwv_bump.py [FOLDER]

Writes hmmwv-settle.png, hmmwv-bump.png and hmmwv-steer.png into the folder: bounce, pitch and roll of the chassis,
loads of the tyres and displacement of the wheels. The wheels do not spin, and the tyres have vertical forces only, so
the vehicle could not follow a curve: steering is shown at rest.
"""

import dataclasses
import sys
from collections.abc import Callable
from math import pi
from pathlib import Path

import numpy as np

import sarrus as sr
from sarrus import mechanisms
from sarrus.functions import positive, sin

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
SPEED = 5.0  # m/s
BUMP = {"start": 6.0, "length": 2.0, "height": 0.06}  # m along the road
LOOKS = ("-", "--", "-.", ":")


def vehicle(road: dict[str, Callable[[float], float]] | None = None, **more: object) -> sr.Model:
    """The shipped vehicle on tyres that can lift off, on a road for each side."""
    model = sr.load(mechanisms.path("hmmwv"))
    sides = road or {}
    forces = [
        sr.RoadTyre(f.name, f.point, f.k, f.c, f.radius, road=sides.get(f.name.split("_")[-1], 0.0))
        if isinstance(f, sr.Tyre)
        else f
        for f in model.forces
    ]
    return dataclasses.replace(model, forces=forces, **more)


def bump(x: float) -> float:
    """Height of the road at a position."""
    s = (x - BUMP["start"]) / BUMP["length"]
    return BUMP["height"] * sin(pi * s) ** 4 * positive(s) * positive(1 - s)


def moved(system: sr.System, rise: float = 0.0, speed: float = 0.0) -> sr.Assembly:
    """The rest position, lifted, with the same speed of all bodies."""
    q, v = system.q0.copy(), np.zeros(system.nq)
    q[2::7] += rise
    v[0::7] = speed
    return sr.assemble(system, q, v)


def settle() -> sr.Trajectory:
    """Dropped from 5 cm above its rest position."""
    system = sr.System(vehicle())
    return sr.simulate(system, moved(system, rise=0.05), until=3.0, method=sr.Radau(rtol=1e-6, atol=1e-7))


def over_the_bump() -> sr.Trajectory:
    """At 5 m/s over a bump of 6 cm under the left wheels; steps that are too long would miss the bump."""
    system = sr.System(vehicle({"left": bump}))
    return sr.simulate(
        system, moved(system, speed=SPEED), until=4.0, method=sr.Radau(rtol=1e-6, atol=1e-7, max_step=0.02)
    )


def steered() -> sr.Trajectory:
    """The rack moves 5 cm to the left and to the right, while the vehicle stands."""
    driver = sr.DisplacementDriver("steering", "rack", motion=lambda t: 0.05 * sin(pi * t))
    model = vehicle(drivers=[driver])
    return sr.simulate(sr.System(model), until=2.0, method=sr.Radau(rtol=1e-6, atol=1e-7))


def loads(run: sr.Trajectory) -> dict[str, np.ndarray]:
    """Force of each tyre over the run [N], from its compression and the rate of the compression."""
    wheels = {f.name.removeprefix("tyre_"): f for f in vehicle().forces if isinstance(f, sr.RoadTyre)}
    found = {}
    for name, tyre in wheels.items():
        height, rise = wheel(run, name)
        road = np.array([bump(x) if "left" in name else 0.0 for x in run[f"knuckle_{name}"].position[:, 0]])
        climb = np.gradient(road, run.t)
        depth = tyre.radius - (height - road)
        found[name] = np.where(depth > 0, np.maximum(tyre.k * depth + tyre.c * (climb - rise), 0), 0.0)
    return found


def wheel(run: sr.Trajectory, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Height of a wheel's centre, and its rate."""
    body = run[f"knuckle_{name}"]
    arm = np.array([0, 0.0340837328143118 * (1 if "left" in name else -1), 0])
    e0, e1, e2, e3 = body.euler.T
    height = body.position[:, 2] + 2 * (e2 * e3 + e0 * e1) * arm[1]
    return height, np.gradient(height, run.t)


def angles(run: sr.Trajectory, body: str) -> dict[str, np.ndarray]:
    """Roll, pitch (nose down) and yaw [deg] of a body."""
    e0, e1, e2, e3 = run[body].euler.T
    roll = np.arctan2(2 * (e2 * e3 + e0 * e1), e0**2 - e1**2 - e2**2 + e3**2)
    pitch = np.arcsin(2 * (e0 * e2 - e1 * e3))
    yaw = np.arctan2(2 * (e1 * e2 + e0 * e3), e0**2 + e1**2 - e2**2 - e3**2)
    return {"roll": np.degrees(roll), "pitch": np.degrees(pitch), "yaw": np.degrees(yaw)}


def picture(run: sr.Trajectory, title: str, path: Path, dpi: int) -> None:
    """Bounce and attitude of the chassis, displacement of the wheels, loads of the tyres."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 7), layout="constrained")
    figure.suptitle(title)
    bounce, attitude, displacement, load = figure.subplots(2, 2, sharex=True).flat
    bounce.plot(run.t, 1e3 * (run["chassis"].position[:, 2] - 0.76427807917))
    bounce.set(ylabel="chassis above rest [mm]")
    for (label, values), look in zip(angles(run, "chassis").items(), LOOKS, strict=False):
        attitude.plot(run.t, values, look, label=label)
    attitude.set(ylabel="chassis [deg]")
    for (name, force), look in zip(loads(run).items(), LOOKS, strict=False):
        heights = wheel(run, name)[0]
        displacement.plot(run.t, 1e3 * heights, look, label=name.replace("_", " "))
        load.plot(run.t, force / 1e3, look, label=name.replace("_", " "))
    displacement.set(ylabel="wheel centre above road level [mm]", xlabel="time [s]")
    load.set(ylabel="load of the tyre [kN]", xlabel="time [s]")
    for axes in (attitude, displacement, load):
        axes.legend(fontsize="small")
    for axes in (bounce, attitude, displacement, load):
        axes.grid(alpha=0.3)
    figure.savefig(path, dpi=dpi)


def steering_picture(run: sr.Trajectory, path: Path, dpi: int) -> None:
    """Angles of the front wheels over the displacement of the rack."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4.5), layout="constrained")
    over_rack, rear = figure.subplots(1, 2)
    rack = 1e3 * run.joint("rack").displacement
    chassis = angles(run, "chassis")["yaw"]
    for side, look in zip(("left", "right"), LOOKS, strict=False):
        turned = angles(run, f"knuckle_front_{side}")["yaw"] - chassis
        over_rack.plot(rack, turned, look, label=side)
        rear.plot(run.t, loads(run)[f"front_{side}"] / 1e3, look, label=f"front {side}")
    over_rack.set(xlabel="displacement of the rack [mm]", ylabel="steering angle [deg]", title="front wheels")
    rear.set(
        xlabel="time [s]", ylabel="load of the tyre [kN]", title="the chassis is lifted and rolls a little"
    )
    for axes in (over_rack, rear):
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
    figure.savefig(path, dpi=dpi)


def main(folder: Path, dpi: int = 50) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    picture(settle(), "Dropped from 5 cm above rest", folder / "hmmwv-settle.png", dpi)
    picture(
        over_the_bump(), "5 m/s over a bump of 6 cm under the left wheels", folder / "hmmwv-bump.png", dpi
    )
    steering_picture(steered(), folder / "hmmwv-steer.png", dpi)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
