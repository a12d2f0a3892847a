"""Torques that swing a two-link arm to another pose with little effort: 120 variables by adjoint gradients.

python examples/torque_history.py [FOLDER]

Each motor's torque over time is a sum of 60 cubic B-splines; their coefficients are the design variables. One adjoint
sweep gives all 120 derivatives.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

ACROSS = (0, 0, 1)
UNTIL = 1.5  # s
COUNT = 60  # splines of each motor
GOAL = (2.2, -1.0)  # rad, the joints' angles at the end, at rest
SETTINGS = {"method": sr.Radau(rtol=1e-5, atol=1e-7)}


def spline(place: int) -> sr.Curve:
    """One of the cubic B-splines on an even grid over time, whose sum is 1."""
    h = UNTIL / (COUNT - 3)
    first = (place - 3) * h
    knots = tuple(first + k * h for k in range(-1, 6))
    bend = np.array([
        (0, 0, 0, 0), (1, 0, 0, 0), (-3, 3, 3, 1), (3, -6, 0, 4), (-1, 3, -3, 1), (0, 0, 0, 0),
    ]) / 6 / h ** np.array([3, 2, 1, 0])  # fmt: skip
    return sr.Curve(knots, tuple(map(tuple, bend)))


def arm() -> sr.System:
    """Two links that hang down, with motors at the shoulder and at the elbow."""
    upper = sr.Body("upper", mass=2, inertia=(0.01, 0.06, 0.06), position=(0, -0.3, 0), orientation=DOWN)
    lower = sr.Body("lower", mass=1, inertia=(0.005, 0.03, 0.03), position=(0, -0.9, 0), orientation=DOWN)
    joints = [
        sr.Revolute("shoulder", sr.ground, upper, point=(0, 0, 0), axis=ACROSS),
        sr.Revolute("elbow", upper, lower, point=(0, -0.6, 0), axis=ACROSS),
    ]
    forces = []
    for n in range(COUNT):
        curve = spline(n)
        forces.append(sr.Torque(f"s{n}", upper, torque=(0, 0, 0.0), factor=curve))
        forces.append(sr.Torque(f"e{n}", lower, torque=(0, 0, 0.0), factor=curve))
        forces.append(sr.Torque(f"r{n}", upper, torque=(0, 0, 0.0), factor=curve))
    return sr.System(sr.Model("arm", [upper, lower], joints, forces=forces, gravity=(0, -9.81, 0)))


DOWN = sr.AxisAngle(ACROSS, -np.pi / 2)
NAMES = [f"{motor}{n}" for motor in ("shoulder", "elbow") for n in range(COUNT)]


def torques(d):
    """Parameters of the model for the coefficients of the splines; the elbow's motor acts on both links."""
    return {
        **{f"s{n}.torque.z": d[f"shoulder{n}"] for n in range(COUNT)},
        **{f"e{n}.torque.z": d[f"elbow{n}"] for n in range(COUNT)},
        **{f"r{n}.torque.z": -1 * d[f"elbow{n}"] for n in range(COUNT)},
    }


def effort(o: sr.Outputs) -> object:
    """Mean square of all coefficients."""
    return sum(o.parameter(name) ** 2 for name in NAMES) / COUNT


def miss(o: sr.Outputs) -> object:
    """Squared deviations of the final pose from the goal, and of the final velocity from zero."""
    places = [(o.joint(f"{pin}.angle") - goal) ** 2 for pin, goal in zip(("shoulder", "elbow"), GOAL)]
    rates = [o.joint(f"{pin}.angle", rate=True) ** 2 for pin in ("shoulder", "elbow")]
    return sum(places) + 0.1 * sum(rates)


def planned(iterations: int = 60, weight: float = 50.0) -> sr.Optimum:
    """The torques."""
    goal = sr.Combined(
        lambda m, e: weight * m + 0.01 * e, [sr.Final(miss), sr.Final(effort)], name="miss and effort"
    )
    zero = dict.fromkeys(NAMES, 0.0)
    return sr.optimize(
        arm(), goal, NAMES, until=UNTIL, design=zero, formula=torques, iterations=iterations, tolerance=1e-6,
        scale=dict.fromkeys(NAMES, 10.0), **SETTINGS,
    )  # fmt: skip


def draw(found: sr.Optimum, folder: Path) -> None:
    """The torques, the angles, and the arm at twelve times."""
    from matplotlib.figure import Figure

    times = np.linspace(0, UNTIL, 201)
    basis = np.array([[spline(n)(t) for n in range(COUNT)] for t in times])
    figure = Figure(figsize=(10, 3.4), layout="constrained")
    torque, angle, plane = figure.subplots(1, 3)
    run = sr.simulate(sr.System(found.model), until=UNTIL, t_eval=times, **SETTINGS)
    for motor, heights, goal, colour in zip(
        ("shoulder", "elbow"), found.x.reshape(2, COUNT), GOAL, ("#1f5f99", "#d9730d")
    ):
        torque.plot(times, basis @ heights, color=colour, label=motor)
        angle.plot(times, run.joint(motor).angle, color=colour)
        angle.plot(UNTIL, goal, "o", color=colour)
    for k in np.linspace(0, 200, 12).astype(int):
        first = -np.pi / 2 + run.joint("shoulder").angle[k]
        second = first + run.joint("elbow").angle[k]
        elbow = 0.6 * np.array([np.cos(first), np.sin(first)])
        hand = elbow + 0.6 * np.array([np.cos(second), np.sin(second)])
        plane.plot(
            *np.array([(0, 0), elbow, hand]).T, "o-", color="#1f5f99", alpha=0.2 + 0.8 * k / 200, markersize=3
        )
    torque.set(xlabel="t [s]", ylabel="torque [N m]")
    angle.set(xlabel="t [s]", ylabel="angle from the start [rad]")
    plane.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    torque.legend(frameon=False)
    figure.savefig(folder / "torque_history.png", dpi=80)


def main(folder: str | Path = ".", iterations: int = 60) -> sr.Optimum:
    found = planned(iterations)
    print(str(found).splitlines()[0])
    draw(found, Path(folder))
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
