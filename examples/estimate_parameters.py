"""Masses, a damping coefficient and the position of a joint, estimated from noisy measurements, with their errors.

python examples/estimate_parameters.py [FOLDER]

A four-bar swings on a spring and damper. The angle of its crank and the height of a point on its coupler are
measured. The data are simulated with the true parameters; the fit begins with other values.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

ACROSS = (0, 0, 1)
KNOWN = {"crank_mass": 1.0, "stiffness": 60.0}  # kg, N/m
TRUE = {"coupler_mass": 2.0, "rocker_mass": 1.5, "damping": 5.0, "foot": 1.5} | KNOWN  # kg, kg, N s/m, m
GUESS = {"coupler_mass": 1.6, "rocker_mass": 1.9, "damping": 8.0, "foot": 1.52} | KNOWN
UNKNOWN = [name for name in TRUE if name not in KNOWN]
BOUNDS = {"coupler_mass": (0.2, 5), "rocker_mass": (0.2, 5), "damping": (0, 50), "foot": (1.3, 1.7)}
TIMES = np.linspace(0.025, 1.5, 60)
SETTINGS = {"method": sr.Radau(rtol=1e-6, atol=1e-8)}
CRANK, COUPLER, ROCKER = 0.5, 1.4, 1.0  # m


def numbers(d):
    """Parameters of the model for a design; lengths are constant, so moving the foot rotates the other rods."""
    foot = d["foot"]
    knee = np.array([0.0, CRANK], dtype=object)
    across = np.array([foot, 0.0], dtype=object) - knee
    far = np.sqrt(across @ across)
    along = (COUPLER**2 - ROCKER**2 + far**2) / (2 * far)
    height = np.sqrt(COUPLER**2 - along**2)
    u = across / far
    end = knee + along * u + height * np.array([-u[1], u[0]])
    middle, leg = (knee + end) / 2, (end + np.array([foot, 0.0], dtype=object)) / 2
    rod = d["coupler_mass"] * COUPLER**2 / 12
    bar = d["rocker_mass"] * ROCKER**2 / 12
    return {
        "crank.mass": d["crank_mass"],
        "crank.inertia": 3 * [d["crank_mass"] * CRANK**2 / 12],
        "spring.k": d["stiffness"],
        "coupler.mass": d["coupler_mass"],
        "coupler.inertia": [rod / 50, rod, rod],
        "coupler.position": [middle[0], middle[1], 0.0],
        "coupler.orientation.angle": np.arctan2(end[1] - knee[1], end[0] - knee[0]),
        "rocker.mass": d["rocker_mass"],
        "rocker.inertia": [bar / 50, bar, bar],
        "rocker.position": [leg[0], leg[1], 0.0],
        "rocker.orientation.angle": np.arctan2(end[1], end[0] - foot),
        "damper.c": d["damping"],
        "foot.point.x": foot,
        "knuckle.point": [end[0], end[1], 0.0],
    }


def mechanism(values):
    """The four-bar with parameters of these values."""
    n = numbers(values)
    turned = {name: sr.AxisAngle(ACROSS, n[f"{name}.orientation.angle"]) for name in ("coupler", "rocker")}
    crank = sr.Body("crank", mass=n["crank.mass"], inertia=n["crank.inertia"], position=(0, CRANK / 2, 0))
    coupler, rocker = (
        sr.Body(
            name,
            mass=n[f"{name}.mass"],
            inertia=n[f"{name}.inertia"],
            position=n[f"{name}.position"],
            orientation=turned[name],
        )
        for name in ("coupler", "rocker")
    )
    joints = [
        sr.Revolute("pivot", sr.ground, crank, point=(0, 0, 0), axis=ACROSS),
        sr.Revolute("knee", crank, coupler, point=(0, CRANK, 0), axis=ACROSS),
        sr.Revolute("foot", sr.ground, rocker, point=(n["foot.point.x"], 0, 0), axis=ACROSS),
        sr.PointOnLine("knuckle", rocker, coupler, point=n["knuckle.point"], axis=ACROSS),
    ]
    spring = sr.TSDA(
        "spring", sr.ground.point(-1.0, 0.2, 0), coupler.point(0, 0, 0), k=n["spring.k"], length=1.2
    )
    damper = sr.TSDA(
        "damper", sr.ground.point(-1.0, 0.2, 0), coupler.point(0, 0, 0), k=0, c=n["damper.c"], length=1.2
    )
    model = sr.Model(
        "four-bar", [crank, coupler, rocker], joints, forces=[spring, damper], gravity=(0, -9.81, 0)
    )
    return sr.System(model)


def tip(o: sr.Outputs) -> object:
    """Height of a point on the coupler."""
    return o.position("coupler", (0.2, 0.3, 0))[1]


SENSORS = {"pivot.angle": 2e-3, tip: 1e-3}  # rad, m: what is measured, with its standard deviation


def measurements(seed: int) -> list[sr.Misfit]:
    """Measurements of two sensors on the true mechanism, with noise."""
    seen = [sr.At(of, time=t) for of in SENSORS for t in TIMES]
    problem = sr.Problem(mechanism(TRUE), seen, [], until=TIMES[-1], method=sr.Radau(rtol=1e-8, atol=1e-10))
    sigmas = np.repeat([*SENSORS.values()], len(TIMES))
    data = problem.values(problem.x0) + sigmas * np.random.default_rng(seed).normal(size=len(sigmas))
    parts = np.split(data, len(SENSORS))
    return [
        sr.Misfit(of, at=tuple(TIMES), data=tuple(part), sigma=sigma)
        for (of, sigma), part in zip(SENSORS.items(), parts)
    ]


def estimate(data: list[sr.Misfit], wrt: list[str]) -> sr.Optimum:
    """The parameters estimated from the data."""
    limits = {name: limits for name, limits in BOUNDS.items() if name in wrt}
    return sr.fit(mechanism(GUESS), data, wrt, design=GUESS, formula=numbers, bounds=limits, **SETTINGS)


def draw(data: list[sr.Misfit], found: sr.Optimum, folder: Path) -> None:
    """The data, the motions before and after the fit, and the confidence intervals relative to the parameters."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 3.6), layout="constrained")
    motion, rest, intervals = figure.subplots(1, 3, width_ratios=(3, 3, 2))
    motion.plot(TIMES, data[0].data, ".", color="#8a8f98", markersize=4, label="measured")
    for values, colour, name in (
        (GUESS, "#d9730d", "guess"),
        (GUESS | dict(zip(found.names, found.x)), "#1f5f99", "fit"),
    ):
        run = sr.simulate(mechanism(values), until=TIMES[-1], t_eval=[0.0, *TIMES], **SETTINGS)
        motion.plot(run.t, run.joint("pivot").angle, color=colour, linewidth=1.2, label=name)
    left = (np.array(data[0].data) - run.joint("pivot").angle[1:]) / data[0].sigma
    rest.plot(TIMES, left, ".", color="#1f5f99", markersize=4)
    rest.axhspan(-2, 2, color="#1f5f99", alpha=0.1)
    for place, name in enumerate(found.names):
        ends = np.array(found.interval(name)) / TRUE[name] - 1
        intervals.plot(100 * ends, [place, place], color="#1f5f99", linewidth=3)
        intervals.plot(100 * (found[name] / TRUE[name] - 1), place, "o", color="#1f5f99")
    intervals.axvline(0, color="#8a8f98", linewidth=0.8)
    intervals.set(yticks=range(len(found.names)), yticklabels=found.names, xlabel="interval - truth [%]")
    motion.set(xlabel="t [s]", ylabel="pivot.angle [rad]")
    rest.set(xlabel="t [s]", ylabel="residual / standard deviation")
    motion.legend(frameon=False)
    figure.savefig(folder / "estimate_parameters.png", dpi=80)


def main(folder: str | Path = ".", seed: int = 0) -> list[sr.Optimum]:
    data = measurements(seed)
    found = estimate(data, UNKNOWN)
    print(found)
    draw(data, found, Path(folder))
    print("\nAll parameters at once; the motion determines only ratios of masses, stiffness and damping:")
    every = estimate(data, [*TRUE])
    print(every)
    return [found, every]


if __name__ == "__main__":
    main(*sys.argv[1:])
