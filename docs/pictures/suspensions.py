"""Draw suspensions.png: the left sides of the suspensions of the package, seen obliquely from ahead.

python docs/pictures/suspensions.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import sarrus as sr

BLUE, ORANGE, GREY = "#1f5f99", "#d9730d", "#8a8f98"
RODS = {  # polylines through hardpoints
    "double_wishbone": ("lower_front lower_ball lower_rear", "upper_front upper_ball upper_rear",
                        "tie_inner tie_outer", "lower_ball upper_ball spindle", "tie_outer spindle wheel"),
    "macpherson": ("arm_front ball arm_rear", "tie_inner tie_outer spindle wheel",
                   "ball strut_bottom spindle", "strut_bottom strut_top"),
    "solid_axle": ("lower_body lower_axle", "upper_body upper_axle", "panhard_body panhard_axle"),
    "trailing_arm": ("pivot_inner spindle pivot_outer pivot_inner", "spindle wheel"),
    "multi_link": ("upper_front_body upper_front_knuckle", "upper_rear_body upper_rear_knuckle",
                   "lower_front_body lower_front_knuckle", "lower_rear_body lower_rear_knuckle",
                   "toe_body toe_knuckle",
                   "upper_front_knuckle upper_rear_knuckle toe_knuckle lower_rear_knuckle lower_front_knuckle "
                   "upper_front_knuckle"),
}  # fmt: skip
SPRINGS = {
    "double_wishbone": ("spring_arm", "spring_top"), "macpherson": ("strut_bottom", "strut_top"),
    "multi_link": ("spring_seat", "spring_top"), "solid_axle": ("spring_seat", "spring_top"),
    "trailing_arm": ("spring_seat", "spring_top"),
}  # fmt: skip


def seen(places: np.ndarray) -> np.ndarray:
    """Points (n, 3) on the sheet (n, 2): y to the right, z upward, x obliquely downward to the left."""
    x, y, z = np.asarray(places, dtype=float).T
    return np.stack([y - 0.5 * x, z - 0.3 * x], axis=1)


def coil(first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """A zigzag between two points of the sheet."""
    along = last - first
    across = 0.03 * np.array([-along[1], along[0]]) / np.linalg.norm(along)
    s = np.linspace(0.12, 0.88, 17)
    sway = np.where(np.arange(17) % 2, 1.0, -1.0)
    inner = first + np.outer(s, along) + np.outer(sway, across)
    return np.vstack([first, inner, last])


def main() -> None:
    figure = Figure(figsize=(10, 6.4), layout="constrained")
    axes = figure.subplot_mosaic(
        [["double_wishbone", "macpherson", "multi_link"], ["trailing_arm", "solid_axle", "solid_axle"]]
    )
    for name, rods in RODS.items():
        ax, table = axes[name], sr.load(name).hardpoints
        points = {one: np.array([float(x) for x in table[one]]) for one in table}
        angle = np.linspace(0, 2 * np.pi, 80)
        rim = points["wheel"][2] * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
        for side in (1, -1) if name == "solid_axle" else (1,):
            mirror = np.array([1, side, 1])
            for names in rods:
                ends = [points[one] for one in names.split()]
                line = seen(ends if "panhard" in names else [one * mirror for one in ends])
                ax.plot(*line.T, "o-", color=BLUE, lw=2.2, ms=4.5)
            first, last = (seen([points[one] * mirror])[0] for one in SPRINGS[name])
            ax.plot(*coil(first, last).T, color=ORANGE, lw=1.3)
            ax.plot(*seen(points["wheel"] * mirror + rim).T, color=GREY, lw=1.8)
        if name == "solid_axle":
            ends = seen([points["wheel"], points["wheel"] * (1, -1, 1)])
            ax.plot(*ends.T, color=BLUE, lw=5, solid_capstyle="round")
        ax.set_title(name, fontsize=11, family="monospace")
        ax.set_aspect("equal")
        ax.margins(0.03)
        ax.axis("off")
    figure.savefig(Path(__file__).with_suffix(".png"), dpi=90)


if __name__ == "__main__":
    main()
