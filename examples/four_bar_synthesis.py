"""The four-bar whose coupler point passes through given points: nine dimensions from sixteen coordinates.

python examples/four_bar_synthesis.py [FOLDER]

The crank is driven by one revolution. The initial poses of a design are computed from its dimensions, so that its loop
closes exactly. If the loop cannot be closed, the search takes a smaller step.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

ACROSS = (0, 0, 1)
UNTIL = 1.0  # s, one revolution of the crank
TURN = 2 * np.pi
WANTED = {
    "crank": 0.4,
    "rod": 1.2,
    "rocker": 1.0,
    "base": 1.3,
    "px": 0.7,
    "py": 0.6,
    "x": 0.0,
    "y": 0.0,
    "tilt": 0.2,
}
START = {
    "crank": 0.5,
    "rod": 1.4,
    "rocker": 1.2,
    "base": 1.5,
    "px": 0.5,
    "py": 0.4,
    "x": 0.1,
    "y": -0.1,
    "tilt": 0.0,
}
LIMITS = (
    (0.2, 0.7), (0.8, 2.0), (0.7, 1.8), (0.9, 2.0), (0.2, 1.2), (0.1, 1.0), (-0.5, 0.5), (-0.5, 0.5), (-0.6, 0.6)
)  # fmt: skip
BOUNDS = dict(zip(START, LIMITS))
TIMES = np.linspace(0.0, UNTIL, 9)[:-1]
EXACT = 1e-3  # m, scale of the distances from the points
SETTINGS = {"method": sr.Radau(rtol=1e-5, atol=1e-7)}


def numbers(d):
    """Parameters of the model for these dimensions; the crank is initially along the base."""
    c, s = np.cos(d["tilt"]), np.sin(d["tilt"])
    pivot = np.array([d["x"], d["y"]], dtype=object)
    across = np.array([c, s], dtype=object)
    up = np.array([-1 * s, c], dtype=object)
    pin, foot = pivot + d["crank"] * across, pivot + d["base"] * across
    far = d["base"] - d["crank"]
    along = (d["rod"] ** 2 - d["rocker"] ** 2 + far**2) / (2 * far)
    height = np.sqrt(d["rod"] ** 2 - along**2)
    knuckle = pin + along * across + height * up
    turned = {"crank": d["tilt"], "rod": _angle(knuckle - pin), "rocker": _angle(knuckle - foot)}
    origins = {"crank": pivot, "rod": pin, "rocker": foot}
    joints = {"motor_pin": pivot, "pin": pin, "foot": foot, "knuckle": knuckle}
    return {
        **{f"{name}.position": [*place, 0.0] for name, place in origins.items()},
        **{f"{name}.orientation.angle": angle for name, angle in turned.items()},
        **{f"{name}.point": [*place, 0.0] for name, place in joints.items()},
    }


def _angle(v):
    return np.arctan2(v[1], v[0])


def mechanism(dimensions) -> sr.System:
    """The four-bar of these dimensions, its crank driven."""
    n = numbers(dimensions)
    bodies = {
        name: sr.Body(
            name,
            mass=1,
            inertia=(1, 1, 1),
            position=n[f"{name}.position"],
            orientation=sr.AxisAngle(ACROSS, n[f"{name}.orientation.angle"]),
        )
        for name in ("crank", "rod", "rocker")
    }
    crank, rod, rocker = bodies.values()
    joints = [
        sr.Revolute("motor_pin", sr.ground, crank, point=n["motor_pin.point"], axis=ACROSS),
        sr.Revolute("pin", crank, rod, point=n["pin.point"], axis=ACROSS),
        sr.Revolute("foot", sr.ground, rocker, point=n["foot.point"], axis=ACROSS),
        sr.PointOnLine("knuckle", rocker, rod, point=n["knuckle.point"], axis=ACROSS),
    ]
    motor = sr.AngleDriver("motor", "motor_pin", motion=lambda t: TURN / UNTIL * t)
    return sr.System(sr.Model("four-bar", list(bodies.values()), joints, drivers=[motor]))


def coupler_x(o: sr.Outputs) -> object:
    """The x coordinate of the coupler point."""
    return o.position("rod", (o.parameter("px"), o.parameter("py"), 0))[0]


def coupler_y(o: sr.Outputs) -> object:
    """The y coordinate of the coupler point."""
    return o.position("rod", (o.parameter("px"), o.parameter("py"), 0))[1]


def curve(dimensions, times) -> np.ndarray:
    """Positions of the coupler point at some times (nt, 2)."""
    seen = [sr.At(axis, time=t) for axis in (coupler_x, coupler_y) for t in times]
    problem = sr.Problem(
        mechanism(dimensions), seen, ["px", "py"], until=UNTIL, design=dimensions, **SETTINGS
    )
    return problem.values(problem.x0).reshape(2, -1).T


def synthesize(places: np.ndarray) -> sr.Optimum:
    """The dimensions whose coupler point passes through the points at equal intervals of the crank's angle."""
    goals = [
        sr.Misfit(axis, at=tuple(TIMES), data=tuple(column), sigma=EXACT)
        for axis, column in zip((coupler_x, coupler_y), places.T)
    ]
    return sr.fit(
        mechanism(START),
        goals,
        design=START,
        formula=numbers,
        until=UNTIL,
        bounds=BOUNDS,
        tolerance=1e-8,
        **SETTINGS,
    )


def draw(places: np.ndarray, found: sr.Optimum, folder: Path) -> None:
    """The points, the coupler curves before and after the search, and the resulting mechanism."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4), layout="constrained")
    plane, way = figure.subplots(1, 2, width_ratios=(3, 2))
    final, all_times = dict(zip(found.names, found.x)), np.linspace(0, UNTIL, 81)
    plane.plot(*curve(START, all_times).T, color="#d9730d", linewidth=1, label="start")
    plane.plot(*curve(final, all_times).T, color="#1f5f99", label="found")
    plane.plot(*places.T, "o", color="#4b5058", markersize=5, label="wanted")
    n = numbers(final)
    pins = [np.array(n[f"{name}.point"][:2], dtype=float) for name in ("motor_pin", "pin", "knuckle", "foot")]
    plane.plot(*np.array(pins).T, "o-", color="#8a8f98", linewidth=2, markersize=4, zorder=0)
    point = curve(final, [0.0])[0]
    plane.fill(*np.array([pins[1], pins[2], point]).T, color="#8a8f98", alpha=0.3, zorder=0)
    plane.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    plane.legend(frameon=False, loc="lower right")
    found.plot(way)
    figure.savefig(folder / "four_bar_synthesis.png", dpi=80)


def main(folder: str | Path = ".") -> sr.Optimum:
    places = curve(WANTED, TIMES)
    found = synthesize(places)
    print(found)
    draw(places, found, Path(folder))
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
