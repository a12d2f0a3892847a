"""The spring and damper that minimize the motion of a slider-crank, a map of the cost, and a design with a limit.

python examples/optimal_spring.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr

MODEL = Path(__file__).parent / "sundials_slider_crank.yaml"
UNTIL = 10.0  # s
SETTINGS = {"method": sr.Radau(rtol=1e-6, atol=1e-8)}  # few steps, many digits
BOUNDS = {"spring.k": (0.2, 2.0), "spring.c": (0.2, 2.5)}
MOST = 0.35  # N, largest compressive force in the second design


def swing(o: sr.Outputs) -> object:
    """Cost: the kinetic energy, and a price for springs and dampers that differ from the initial ones."""
    k, c = o.parameter("spring.k"), o.parameter("spring.c")
    return o.kinetic_energy() + 0.05 * ((k - 1) ** 2 + (c - 1) ** 2)


COST = sr.Integral(swing, name="swing and cost")
PRESSURE = sr.Maximum(lambda o: -o("spring.tension"), name="largest pressure")


def best(system: sr.System, *limits: sr.Within) -> sr.Optimum:
    """The spring and damper of the least cost."""
    return sr.optimize(system, COST, [*BOUNDS], until=UNTIL, bounds=BOUNDS, constraints=limits, **SETTINGS)


def landscape(system: sr.System, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The cost on a grid of springs and dampers."""
    k, c = (np.linspace(*limits, count) for limits in BOUNDS.values())
    problem = sr.Problem(system, COST, [*BOUNDS], until=UNTIL, **SETTINGS)
    return k, c, np.array([[problem.values([x, y])[0] for x in k] for y in c])


def draw(system: sr.System, found: list[sr.Optimum], folder: Path, count: int) -> None:
    """The map with the iterates of the solver, and the motion before and after."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    plane, motion = figure.subplots(1, 2)
    levels = plane.contourf(*landscape(system, count), levels=24, cmap="Blues")
    figure.colorbar(levels, ax=plane, label=COST.title)
    before = sr.simulate(system, until=UNTIL)
    motion.plot(before.t, before.joint("pivot").angle, color="#8a8f98", linewidth=1, label="before")
    names = "best", f"best with at most {MOST:g} N"
    for one, colour, name in zip(found, ("#d9730d", "#4b5058"), names):
        plane.plot(*one.trace.T, "o-", color=colour, markersize=3, linewidth=1, label=name)
        plane.plot(*one.x, "*", color=colour, markersize=13)
        run = sr.simulate(sr.System(one.model), until=UNTIL)
        motion.plot(run.t, run.joint("pivot").angle, color=colour, label=name)
    plane.set(
        xlabel="stiffness [N/m]", ylabel="damping [N s/m]", xlim=BOUNDS["spring.k"], ylim=BOUNDS["spring.c"]
    )
    motion.set(xlabel="t [s]", ylabel="angle of the crank from its start [rad]")
    for ax in (plane, motion):
        ax.legend(frameon=ax is plane)
    figure.savefig(folder / "optimal_spring.png", dpi=80)
    figure = found[0].plot().figure
    figure.savefig(folder / "optimal_spring-convergence.png", dpi=80)


def main(folder: str | Path = ".", count: int = 12) -> list[sr.Optimum]:
    system = sr.System(sr.load(MODEL))
    found = [best(system), best(system, sr.Within(PRESSURE, upper=MOST))]
    for one in found:
        print(one)
    draw(system, found, Path(folder), count)
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
