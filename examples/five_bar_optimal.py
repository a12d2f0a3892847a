"""Energy-optimal and time-optimal motion of a five-bar from rest to rest, by direct shooting.

python examples/five_bar_optimal.py [FOLDER]

Two motors rotate the cranks of a horizontal five-bar. The motion of least energy needs smooth torques, which are tables
over time. The motion of least time T needs the largest torques, whose signs change at times that are optimized. With
the time scaled to t/T, torques act as if they were T² times as large: T² is a factor of the torques in a motion of unit
duration.
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

BASE, CRANK, ROD = 0.1, 0.25, 0.4  # m
GOAL = {"left": -0.9, "right": -0.5}  # rad, angles of the cranks from their start
DURATION, NODES, MOST = 0.5, 7, 2.0  # s; values of a table; N m
AIM = [sr.Within(f"{side}.angle", angle, angle) for side, angle in GOAL.items()]
AIM += [sr.Within(f"{side}.rate", 0.0, 0.0) for side in GOAL]


def five_bar(torque: dict[str, sr.Input]) -> sr.System:
    """Cranks that open outwards by 30° from upright, each with a motor."""
    bodies, joints = [], []
    tip = (0, CRANK * 0.75**0.5 + (ROD**2 - (BASE + CRANK / 2) ** 2) ** 0.5, 0)
    for side, sign in (("left", -1), ("right", 1)):
        foot, elbow = (sign * BASE, 0, 0), (sign * (BASE + CRANK / 2), CRANK * 0.75**0.5, 0)
        crank = sr.Body.rod(f"crank_{side}", foot, elbow, mass=1.0)
        rod = sr.Body.rod(f"rod_{side}", elbow, tip, mass=0.8)
        joints.append(sr.Revolute(side, sr.ground, crank, point=foot, axis=(0, 0, 1)))
        joints.append(sr.Revolute(f"elbow_{side}", crank, rod, point=elbow, axis=(0, 0, 1)))
        bodies += [crank, rod]
    joints.append(sr.PointOnLine("tip", bodies[1], bodies[3], point=tip, axis=(0, 0, 1)))
    motors = [sr.Torque(f"motor_{side}", side, value=f"u_{side}") for side in GOAL]
    return sr.System(sr.Model("five-bar", bodies, joints, forces=[*torque.values(), *motors]))


def least_energy() -> sr.Optimum:
    """The motion of least energy: values of tables of torques, which are zero at first."""
    table = [[t, 0.0] for t in np.linspace(0, DURATION, NODES)]
    system = five_bar({side: sr.Input(f"u_{side}", table, unit="N m") for side in GOAL})
    names = [f"u_{side}.value.{n}.y" for side in GOAL for n in range(1, NODES + 1)]
    energy = sr.Integral(lambda o: o("u_left") ** 2 + o("u_right") ** 2, name="energy")
    return sr.optimize(system, energy, names, until=DURATION, constraints=AIM)


# T² [s²], and the intervals between changes of sign as fractions of T; torques are negative first
START = {"square": 0.15, "left_1": 0.5, "right_1": 0.45, "right_2": 0.25, "right_3": 0.05}


def switches(d, side: str) -> list:
    """The times at which the torque of a motor changes its sign."""
    return [*np.cumsum([d[name] for name in START if name.startswith(side)])]


def switched(d):
    """The parameters of both torques for the design variables."""
    square = {f"u_{side}.parameters.s": d["square"] for side in GOAL}
    return square | {f"u_{side}.parameters.t{n}": t for side in GOAL for n, t in enumerate(switches(d, side))}


def least_time() -> sr.Optimum:
    """The motion of least time: one change of sign on the left and three on the right, as the optimum requires."""
    inputs = {}
    for side in GOAL:
        times = {f"t{n}": t for n, t in enumerate(switches(START, side))}
        steps = [f"{2 * (-1) ** n}*step(t, {t} - 1e-3, 0, {t} + 1e-3, 1)" for n, t in enumerate(times)]
        value = f"{MOST}*s*({' + '.join(steps)} - 1)"
        inputs[side] = sr.Input(f"u_{side}", value, unit="N m", parameters={"s": START["square"], **times})
    bounds = dict.fromkeys(START, (0.01, 1.0))
    square = sr.Final(lambda o: o.parameter("square"), name="square of the time")
    return sr.optimize(
        five_bar(inputs), square, until=1.0, design=START, formula=switched, bounds=bounds, constraints=AIM
    )


def main(folder: str | Path = ".") -> tuple[sr.Optimum, sr.Optimum]:
    from matplotlib.figure import Figure

    energy, time = least_energy(), least_time()
    shortest = time["square"] ** 0.5
    print(energy)
    print(time)
    print(f"least time: {shortest:.4f} s")
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for side, colour in (("left", "#1f5f99"), ("right", "#d9730d")):
        left.plot(energy.run.t, energy.run[f"u_{side}"], color=colour, label=f"{side} motor")
        right.plot(shortest * time.run.t, time.run[f"u_{side}"] / time["square"], color=colour)
    for ax, title in ((left, "least energy"), (right, "least time")):
        ax.set(xlabel="t [s]", ylabel="torque [N m]", title=title)
    left.legend(frameon=False)
    figure.savefig(Path(folder) / "five_bar_optimal.png", dpi=80)
    return energy, time


if __name__ == "__main__":
    main(*sys.argv[1:])
