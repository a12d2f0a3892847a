"""The vehicle's suspension, tuned for its ride over a bump: fourteen parameters with bounds, and limited extensions.

python examples/hmmwv_ride.py [FOLDER]

The parameters are those of the springs and dampers of both axles and their attachment points on the chassis, symmetric
about the middle plane. The free lengths follow, so that the load of every spring at rest is the same as before.
"""

import dataclasses
import sys
from functools import cache
from pathlib import Path

import numpy as np

import sarrus as sr
from sarrus import mechanisms
from sarrus.functions import positive, sin
from sarrus.model.written import written_numbers
from sarrus.views import plot_gradient

SPEED, UNTIL = 8.0, 1.5  # m/s, s
START, LENGTH, HEIGHT = 3.2, 2.5, 0.06  # m along the road
SETTINGS = {"method": sr.Radau(rtol=1e-4, atol=1e-6, max_step=0.02), "until": UNTIL}
SIDES = {"right": 1, "left": -1}


def road(x):
    """A bump under all wheels, one axle after the other."""
    s = (x - START) / LENGTH
    return HEIGHT * sin(np.pi * s) ** 4 * positive(s) * positive(1 - s)


@cache
def vehicle() -> sr.System:
    """The shipped vehicle at its speed, on tyres that can lift off."""
    model = sr.load(mechanisms.path("hmmwv"))
    forces = [
        sr.RoadTyre(f.name, f.point, f.k, f.c, f.radius, road=road) if isinstance(f, sr.Tyre) else f
        for f in model.forces
    ]
    bodies = [dataclasses.replace(body, velocity=(SPEED, 0, 0)) for body in model.bodies]
    return sr.System(dataclasses.replace(model, bodies=bodies, forces=forces))


PLACES = {
    "spring_x": ("spring", 0), "spring_y": ("spring", 1), "spring_z": ("spring", 2),
    "damper_y": ("damper", 1), "damper_z": ("damper", 2),
}  # fmt: skip
REACH = 0.06  # m, how far an attachment point may move on the chassis
AXLES = ("front", "rear")


def start() -> dict[str, float]:
    """The original design: for each axle stiffness, damping, and five coordinates of attachment points (right side)."""
    known = written_numbers(vehicle().model)
    found = {}
    for axle in AXLES:
        found[f"{axle}_k"] = known[f"spring_{axle}_right.k"]
        found[f"{axle}_c"] = known[f"damper_{axle}_right.c"]
        for name, (part, k) in PLACES.items():
            found[f"{axle}_{name}"] = known[f"{part}_{axle}_right.point_i.{'xyz'[k]}"]
    return found


def limits() -> dict[str, tuple[float, float]]:
    """Half to twice the stiffness, a tenth to twice the damping, and attachment points within `REACH`."""
    found = {}
    for name, value in start().items():
        low, high = {"k": (0.5, 2.0), "c": (0.1, 2.0)}.get(name.split("_", 1)[1], (0, 0))
        found[name] = (low * value, high * value) if high else (value - REACH, value + REACH)
    return found


def numbers(d):
    """Parameters of the model for a design: points are mirrored, and free lengths keep the load at rest."""
    known = written_numbers(vehicle().model)
    found = {}
    for axle in AXLES:
        for side, sign in SIDES.items():
            for part in ("spring", "damper"):
                own = {k: d[f"{axle}_{name}"] for name, (of, k) in PLACES.items() if of == part}
                own = {k: sign * value if k == 1 else value for k, value in own.items()}
                name = f"{part}_{axle}_{side}"
                found |= {f"{name}.point_i.{'xyz'[k]}": value for k, value in own.items()}
                if part == "spring":
                    top, low = (
                        np.array([known[f"{name}.point_{e}.{x}"] for x in "xyz"], dtype=object) for e in "ij"
                    )
                    foot = _at_rest(f"LCA_{axle}_{side}", low)
                    at = [_at_rest("chassis", place) - foot for place in (top, _moved(top, own))]
                    before, after = (np.sqrt(x @ x) for x in at)
                    load = known[f"{name}.k"] * (known[f"{name}.length"] - before)
                    found |= {f"{name}.k": d[f"{axle}_k"], f"{name}.length": after + load / d[f"{axle}_k"]}
                else:
                    found[f"{name}.c"] = d[f"{axle}_c"]
    return found


def _at_rest(body, point):
    """The place at the start, the static equilibrium, of a point of a body in the design position."""
    own = next(one for one in vehicle().model.bodies if one.name == body)
    start = own.initial_pose()
    return start.r + start.A @ (point - own.pose().r)


def _moved(place, own):
    return np.array([own.get(k, x) for k, x in enumerate(place)], dtype=object)


def shaking(o: sr.Outputs) -> object:
    """Vertical acceleration of the seat, and pitch rate, squared."""
    return o.acceleration("chassis", SEAT)[2] ** 2 + 25 * o("chassis.angular_velocity.y") ** 2


SEAT = (-0.2, 0.6, 0.3)  # m, in the chassis
RIDE = sr.Integral(shaking, name="shaking")
REST = {"spring_front_left": 0.26831, "spring_rear_left": 0.35261}  # m, lengths at rest
MOST = 14.0  # mm that a spring may extend


def extension(spring: str) -> sr.Maximum:
    """How far a spring extends beyond its length at rest, which the attachment points hardly change."""
    return sr.Maximum(
        lambda o: 1e3 * (o(f"{spring}.length") - REST[spring]),
        name=f"{spring} extends by [mm]",
    )


def tuned(*constraints: sr.Within, iterations: int = 20) -> sr.Optimum:
    """The suspension with the best ride."""
    return sr.optimize(
        vehicle(), RIDE, bounds=limits(), constraints=constraints, design=start(), formula=numbers,
        iterations=iterations, tolerance=1e-4, **SETTINGS,
    )  # fmt: skip


def draw(found: list[sr.Optimum], folder: Path) -> None:
    """Seat and spring over time before and after the search, and the sensitivities of the initial design."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 6.4), layout="constrained")
    seat, pitch, spring, bars = figure.subplots(2, 2).flat
    problem = sr.Problem(vehicle(), RIDE, design=start(), formula=numbers, **SETTINGS)
    before = problem.at(problem.x0)
    runs = {"before": before.run, "best": found[0].run, f"best within {MOST:g} mm": found[1].run}
    for (name, run), colour in zip(runs.items(), ("#8a8f98", "#d9730d", "#1f5f99")):
        motion = sr.simulate(run.system, run.steps.start, **SETTINGS)
        accelerations = motion.output(f"chassis{SEAT}.acceleration.z").values
        rates, lengths = (
            motion.output(f).values for f in ("chassis.angular_velocity.y", "spring_front_left.length")
        )
        seat.plot(motion.t, accelerations, color=colour, label=name)
        pitch.plot(motion.t, np.degrees(rates), color=colour)
        spring.plot(motion.t, 1e3 * (lengths - REST["spring_front_left"]), color=colour)
    plot_gradient(before.gradient, bars)
    seat.set(xlabel="t [s]", ylabel="seat, vertical acceleration [m/s²]")
    pitch.set(xlabel="t [s]", ylabel="pitch rate [°/s]")
    spring.set(xlabel="t [s]", ylabel="front spring, longer than at rest [mm]")
    seat.legend(frameon=False)
    figure.savefig(folder / "hmmwv_ride.png", dpi=70)


def main(folder: str | Path = ".", iterations: int = 20) -> list[sr.Optimum]:
    limited = [sr.Within(extension(name), upper=MOST) for name in REST]
    found = [tuned(iterations=iterations), tuned(*limited, iterations=iterations)]
    for one in found:
        print(one)
    draw(found, Path(folder))
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
