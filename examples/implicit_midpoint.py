"""A user-defined method: the implicit midpoint rule, without numerical damping. Events, gradients, Hessians work.

python examples/implicit_midpoint.py [FOLDER]
"""

import sys
from dataclasses import replace
from pathlib import Path

import sarrus as sr


def step(h: float, ratio: float) -> sr.Step:
    """The motion at the middle; q' = v - Φ_qᵀμ over the step; both constraints at its end. Q is q₁, V is h v₁."""
    middle = sr.Stage(
        0.5, q={"q": 0.5, "Q": 0.5}, v={"v": 0.5, "V": 0.5 / h}, a={"v": -1 / h, "V": 1 / h**2}, lam={"L": 1 / h**2},
        mu={"N": 1 / h}, rate={"q": -1 / h, "Q": 1 / h, "v": -0.5, "V": -0.5 / h},
    )  # fmt: skip
    end = sr.Stage(1.0, q={"Q": 1.0}, v={"V": 1 / h})
    kinds = [("kinematic", 0, h), ("motion", 0, h**2), ("position", 1, 1.0), ("velocity", 1, h)]
    return sr.Step((middle, end), tuple(sr.Equation(*kind) for kind in kinds), {"q": end.q, "v": end.v})


UNKNOWNS = {"Q": "coordinates", "V": "coordinates", "L": "constraints", "N": "constraints"}
METHOD = sr.Description(UNKNOWNS, step, name="implicit midpoint")


def pendulum() -> sr.System:
    """A rod of 1 m on a pin, released from the horizontal."""
    rod = sr.Body("rod", mass=2.0, inertia=(0.01, 1 / 6, 1 / 6), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("pendulum", bodies=[rod], joints=[pin], gravity=(0, -9.81, 0)))


def main(folder: str | Path = ".") -> tuple[dict[str, sr.Trajectory], sr.Gradient, sr.Hessian]:
    """Energies of a long run with equal steps, compared with HHT; the gradient and the Hessian of the last position."""
    system, low = pendulum(), sr.Event("rod.x", direction=-1, name="low")
    equal = replace(METHOD, error=sr.Estimate(2, 0.0, lambda h, ratio: {}))  # all steps are max_step long
    midpoint = sr.DescribedMethod(equal, first_step=0.02, max_step=0.02)
    methods = {"implicit midpoint": midpoint, "HHT": sr.HHT(step=0.02)}
    runs = {name: sr.simulate(system, until=50, method=one, events=low) for name, one in methods.items()}
    short = sr.simulate(system, until=1.0, method=METHOD, store="steps")
    numbers = ["rod.inertia.zz", "gravity.y"]
    gradient = sr.sensitivity(short, sr.Final("rod.x"), numbers)
    hessian = sr.hessian(short, sr.Final("rod.x"), numbers)
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 3.2), layout="constrained")
    axes = figure.subplots()
    for name, run in runs.items():
        axes.plot(run.t, run.total_energy, label=name, lw=0.8)
    axes.set(xlabel="t [s]", ylabel="energy [J]")
    axes.legend(frameon=False)
    figure.savefig(Path(folder) / "implicit_midpoint.png", dpi=80)
    return runs, gradient, hessian


if __name__ == "__main__":
    print(*main(*sys.argv[1:])[1:], sep="\n\n")
