"""A user-defined method that uses the previous step: BDF2 with variable steps, for stiff mechanisms.

python examples/bdf2.py [FOLDER]
"""

import sys
from pathlib import Path

import sarrus as sr


def step(h: float, ratio: float) -> sr.Step:
    """q' = v - Φ_qᵀμ and v' = a by the parabola through three states, at the end. Q is q₁, V is h v₁.

    `dq` and `dv` are the slopes of the previous step, (q₀ - q₋₁) / h₋₁ and (v₀ - v₋₁) / h₋₁; `ratio` is h / h₋₁.
    """
    new, old = (1 + 2 * ratio) / (1 + ratio), ratio / (1 + ratio)
    slope = {"Q": new / h, "q": -new / h, "dq": -old}
    bend = {"V": new / h**2, "v": -new / h, "dv": -old}
    end = sr.Stage(
        1.0, q={"Q": 1.0}, v={"V": 1 / h}, a=bend, lam={"L": 1 / h**2}, mu={"N": 1 / h}, rate={**slope, "V": -1 / h}
    )  # fmt: skip
    kinds = [("kinematic", 0, h), ("motion", 0, h**2), ("position", 0, 1.0), ("velocity", 0, h)]
    slopes = {"dq": {"Q": 1 / h, "q": -1 / h}, "dv": {"V": 1 / h**2, "v": -1 / h}}
    return sr.Step((end,), tuple(sr.Equation(*kind) for kind in kinds), {"q": end.q, "v": end.v, **slopes})


UNKNOWNS = {"Q": "coordinates", "V": "coordinates", "L": "constraints", "N": "constraints"}
METHOD = sr.Description(UNKNOWNS, step, extra={"dq": {"v": 1.0}, "dv": {"a": 1.0}}, name="BDF2")


def bouncer() -> sr.System:
    """A rod of 1 m on a pin falls from the horizontal; a stiff, damped spring holds a light ball at its end."""
    rod = sr.Body("rod", mass=2.0, inertia=(0.01, 1 / 6, 1 / 6), position=(0.5, 0, 0))
    ball = sr.Body("ball", mass=0.1, inertia=(1e-4, 1e-4, 1e-4), position=(1.02, 0, 0))
    joints = [sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1)),
              sr.Translational("slide", rod, ball, point=(1, 0, 0), axis=(1, 0, 0))]  # fmt: skip
    spring = sr.TSDA("spring", rod.point(-0.5, 0, 0), ball.point(0, 0, 0), k=1e6, length=1.02, c=100.0)
    return sr.System(sr.Model("bouncer", [rod, ball], joints, forces=[spring], gravity=(0, -9.81, 0)))


def main(folder: str | Path = ".") -> tuple[sr.Trajectory, sr.Gradient]:
    """The rod bounces off a stop; the gradient of its last angle goes through the impacts."""
    stop = sr.Event("rod.x", direction=-1, reset=sr.Impact(0.6), name="stop")
    run = sr.simulate(bouncer(), until=2.0, method=METHOD, events=stop, store="steps")
    numbers = ["rod.mass", "ball.mass", "gravity.y", "stop.restitution"]
    gradient = sr.sensitivity(run, sr.Final("pin.angle"), numbers)
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 3.2), layout="constrained")
    figure.subplots().plot(run.t, run.sol(run.t).q[:, 0])  # rod.x, the first of all coordinates
    figure.axes[0].set(xlabel="t [s]", ylabel="rod.x [m]")
    figure.savefig(Path(folder) / "bdf2.png", dpi=80)
    return run, gradient


if __name__ == "__main__":
    print(*main(*sys.argv[1:]), sep="\n\n")
