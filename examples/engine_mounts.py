"""Natural frequencies of the vehicle with its engine on four bushings, placed by the stiffness of the bushings.

python examples/engine_mounts.py [FOLDER]

The wheels hop at 9.0 to 9.3 Hz. Roll, pitch and bounce of the engine must be above, and apart from each other: their
frequencies are functions of three stiffnesses, with exact gradients through the equilibrium.
"""

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

import sarrus as sr
from sarrus.model.written import with_numbers, written_numbers

MASS, CENTRE, TURNING = 420.0, (1.45, 0.0, 0.78), 300.0  # kg, m, N m/rad of a bushing
MOUNTS = {(end, side): (x, y) for end, x in (("front", 0.35), ("rear", -0.35))
          for side, y in (("left", 0.3), ("right", -0.3))}  # m from the centre  # fmt: skip
START = {"fore_aft": 9e5, "lateral": 5e5, "vertical": 6.5e5}  # N/m of each bushing
WANTED = {
    "mode12.frequency": 12.0,
    "mode13.frequency": 13.2,
    "mode14.frequency": 16.5,
}  # Hz: roll, pitch, bounce


@cache
def vehicle() -> sr.System:
    """The vehicle without damping, whose engine is a part of its own on bushings."""
    model = sr.load("hmmwv")
    bodies = [replace(one, mass=one.mass - MASS) if one.name == "chassis" else one for one in model.bodies]
    chassis = next(one for one in bodies if one.name == "chassis")
    engine = sr.Body("engine", mass=MASS, inertia=(25, 45, 40), position=CENTRE)
    stiffness = (*START.values(), TURNING, TURNING, TURNING)
    mounts = [
        sr.Bushing(
            f"mount_{end}_{side}", chassis, engine, point=(CENTRE[0] + x, y, 0.65), stiffness=stiffness
        )
        for (end, side), (x, y) in MOUNTS.items()
    ]
    whole = replace(model, bodies=[*bodies, engine], forces=[*model.forces, *mounts])
    undamped = {name: 0.0 for name in written_numbers(whole) if name.endswith(".c")}
    return sr.System(with_numbers(whole, undamped))


def stiffnesses(d):
    """The stiffness of all bushings, along the axes of the vehicle."""
    return {
        f"mount_{end}_{side}.stiffness.{n}": d[name]
        for end, side in MOUNTS for n, name in enumerate(START, 1)
    }  # fmt: skip


def misplaced(*frequencies):
    """Squares of the distances from the wanted frequencies."""
    return sum((one - wanted) ** 2 for one, wanted in zip(frequencies, WANTED.values()))


def draw(before: sr.Modes, after: sr.Modes, slopes: sr.Gradient, folder: Path) -> None:
    """All frequencies before and after, and what each stiffness changes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.4), layout="constrained")
    levels, bars = figure.subplots(1, 2)
    levels.axhspan(9.0, 9.3, color="#d9d9d9", label="wheels")
    for n, pair in enumerate(zip(before.frequencies[3:], after.frequencies[3:]), 4):
        placed = f"mode{n}.frequency" in WANTED
        levels.plot([0, 1], pair, "o-", color="#d9730d" if placed else "#1f5f99", markersize=3, lw=1)
    for one in WANTED.values():
        levels.axhline(one, color="#d9730d", lw=0.6, ls="--")
    levels.set(
        xticks=[0, 1], xticklabels=["start", "placed"], ylabel="natural frequency [Hz]", xlim=(-0.2, 1.2)
    )
    levels.legend(frameon=False, loc="upper left")
    for n, name in enumerate(slopes.names):
        change = 0.1 * slopes.matrix[:, n] * START[name]
        bars.bar(np.arange(3) + 0.25 * (n - 1), change, width=0.22, label=name.replace("_", "-"))
    bars.set(
        xticks=range(3), xticklabels=["roll", "pitch", "bounce"], ylabel="change by 10 % more stiffness [Hz]"
    )
    bars.legend(frameon=False)
    figure.savefig(folder / "engine_mounts.png", dpi=80)


def main(folder: str | Path = ".") -> tuple[sr.Optimum, sr.Modes]:
    system = vehicle()
    before = sr.modes(system, sr.equilibrium(system))
    slopes = sr.sensitivity(before, [*WANTED], design=START, formula=stiffnesses)
    print(slopes)
    best = sr.optimize(
        system, sr.Combined(misplaced, [*WANTED]), design=START, formula=stiffnesses, analysis=sr.Vibration(),
        bounds={name: (0.3 * value, 3 * value) for name, value in START.items()},
    )  # fmt: skip
    print(best)
    placed = sr.System(best.model)
    after = sr.modes(placed, sr.equilibrium(placed))
    draw(before, after, slopes, Path(folder))
    return best, after


if __name__ == "__main__":
    main(*sys.argv[1:])
