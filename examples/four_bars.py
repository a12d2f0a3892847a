"""N four-bar mechanisms in a row, for any N: the model of four_bars.yaml, made in Python.

python examples/four_bars.py [N [SECONDS]]
"""

import sys

import sarrus as sr

ACROSS = (0, 0, 1)


def four_bars(n: int, speed: float = 1.0) -> sr.Model:
    """Return n mechanisms, upright, whose couplers have the given speed [m/s]."""
    uprights, couplers = (
        [upright(i, speed) for i in range(n + 1)],
        [coupler(i, speed) for i in range(1, n + 1)],
    )
    joints = [
        sr.Revolute(f"foot_{i}", sr.ground, uprights[i], point=(i, 0, 0), axis=ACROSS) for i in range(n + 1)
    ]
    for i, bar in enumerate(couplers, start=1):
        joints.append(sr.Revolute(f"knee_{i}", uprights[i - 1], bar, point=(i - 1, 1, 0), axis=ACROSS))
        joints.append(sr.PointOnLine(f"close_{i}", uprights[i], bar, point=(i, 1, 0), axis=ACROSS))
    return sr.Model(f"{n} four-bar mechanisms", [*uprights, *couplers], joints, gravity=(0, -9.81, 0))


def upright(i: int, speed: float) -> sr.Body:
    motion = {"velocity": (speed / 2, 0, 0), "angular_velocity": (0, 0, -speed)}
    return sr.Body(f"upright_{i}", mass=1, inertia=(1 / 12, 1 / 1200, 1 / 12), position=(i, 0.5, 0), **motion)


def coupler(i: int, speed: float) -> sr.Body:
    place = {"position": (i - 0.5, 1, 0), "velocity": (speed, 0, 0)}
    return sr.Body(f"coupler_{i}", mass=1, inertia=(1 / 1200, 1 / 12, 1 / 12), **place)


def main(n: int = 40, seconds: float = 0.5) -> sr.Trajectory:
    run = sr.simulate(sr.System(four_bars(n)), until=seconds)
    x, y, _ = 2 * run["upright_0"].position[-1]
    print(f"{run.name}: {run.message}; B_0 is at ({x:.6f}, {y:.6f}) m after {seconds:g} s")
    return run


if __name__ == "__main__":
    main(*(kind(word) for kind, word in zip((int, float), sys.argv[1:])))
