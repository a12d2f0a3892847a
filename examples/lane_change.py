"""A double lane change of a small car: its path between the cones, and which hardpoints change the distance to them.

python examples/lane_change.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

import sarrus as sr
from sarrus.vehicles.lane_change import severe

SPEED, WIDTH, AHEAD = 80 / 3.6, 1.7, 80 / 3.6  # [m/s], [m] of the car, [m] from the start to the first cone
MARGIN = "margin_2"  # the distance to the cones of the second lane
WRT = [
    "hardpoints",
    "front_bar",
    "rear_bar",
    "pinion_radius",
    "brake_bias",
    *(f"tyre_{axle}_{side}.coefficients.{name}" for axle in ("front", "rear") for side in ("left", "right")
      for name in ("PKY1", "PDY1")),
]  # fmt: skip


def lane_change() -> sr.Manoeuvre:
    """The manoeuvre of ISO 3888-1 at 80 km/h."""
    return sr.double_lane_change(sr.System(sr.load("car")), SPEED, width=WIDTH)


def picture(result: sr.Manoeuvre, gradient: sr.Gradient, path: Path, dpi: int) -> None:
    """The path between the cones, histories, and the hardpoints with the largest influence."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 5.8), layout="constrained")
    axes = figure.subplot_mosaic([["road", "road"], ["left", "right"]])
    road, left, right = (axes[name] for name in ("road", "left", "right"))
    run = result.run
    for lane in severe(WIDTH):
        for side in (-0.5, 0.5):
            cones = np.linspace(lane.begin, lane.end, 5)
            road.plot(cones, np.full(5, lane.centre + side * lane.width), "^", color="#d9730d", markersize=5)
    road.plot(run["chassis.x"] - AHEAD, run["chassis.y"], color="#1f5f99")
    road.set(xlabel="x [m]", ylabel="y [m]")
    left.plot(run.t, result["lateral_accelerations"], color="#1f5f99", label="lateral acceleration [m/s²]")
    left.plot(run.t, 10 * result["steering_angles"], color="#8a8f98", label="steering wheel [0.1 rad]")
    left.set(xlabel="t [s]")
    left.legend(frameon=False, fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    points = [name for name in gradient.names if name.endswith((".x", ".y", ".z"))]
    changes = {name: gradient.matrix[0][gradient.names.index(name)] for name in points}  # m/m, as mm/mm
    ranked = sorted(changes, key=lambda name: abs(changes[name]))[-8:]
    right.barh(ranked, [changes[name] for name in ranked], color="#d9730d", height=0.6)
    right.set(xlabel="change of the second margin [mm per mm]")
    for ax in (road, left, right):
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(alpha=0.25)
    figure.savefig(path, dpi=dpi)


def main(folder: str | Path = ".", dpi: int = 80) -> sr.Manoeuvre:
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    result = lane_change()
    print(result)
    gradient = result.sensitivity(MARGIN, wrt=WRT)
    print(gradient.table(most=8))
    picture(result, gradient, folder / "lane_change.png", dpi)
    sr.load("car").view(folder / "lane_change-car.png")
    result.run.animate(folder / "lane_change.html", traces=["chassis"], follow="chassis")
    return result


if __name__ == "__main__":
    main(*sys.argv[1:2])
