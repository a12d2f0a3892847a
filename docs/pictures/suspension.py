"""Draw suspension.png: axes and positive angles of a right wheel in three views.

python docs/pictures/suspension.py
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

BLUE, ORANGE, GREY = "#1f5f99", "#d9730d", "#8a8f98"
DARK = "#3a3f46"


def arrow(
    ax: Any, begin: tuple[float, float], end: tuple[float, float], label: str, colour: str = DARK
) -> None:
    """An axis of the vehicle."""
    ax.annotate("", end, begin, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.4})
    direction = np.subtract(end, begin)
    x, y = np.array(end) + 0.09 * direction / np.linalg.norm(direction)
    ax.text(x, y, label, color=colour, ha="center", va="center")


def tilted(ax: Any, centre: tuple[float, float], half: tuple[float, float], angle: float) -> None:
    """A wheel seen along its plane: a rectangle, turned clockwise [deg]."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * half
    points = corners @ np.array([(c, -s), (s, c)])
    ax.fill(points[:, 0] + centre[0], points[:, 1] + centre[1], facecolor="#dbe7f3", edgecolor=BLUE, lw=1.5)


def rear(ax: Any) -> None:
    """From behind: camber, kingpin inclination, scrub radius."""
    ax.set_title("from behind")
    ax.axhline(0, color=GREY, lw=1)
    tilted(ax, (1.0, 0.55), (0.13, 0.55), 8)
    ax.plot([1.0, 1.0], [0.55, 1.35], ":", color=GREY)
    ax.plot([1.0, 1.112], [0.55, 1.35], "--", color=BLUE)
    ax.text(1.06, 1.4, "camber", color=BLUE, ha="center")
    ax.plot([0.80, 0.46], [0.0, 1.25], color=ORANGE, lw=1.8)
    ax.plot([0.80, 0.80], [0.0, 1.25], ":", color=GREY)
    ax.text(0.52, 1.32, "kingpin\ninclination", color=ORANGE, ha="center")
    ax.plot([0.80], [0], "o", color=ORANGE)
    ax.text(0.77, -0.11, "G", color=ORANGE, ha="center")
    ax.plot([0.93], [0.0], "o", color=BLUE)
    ax.text(0.96, -0.11, "A", color=BLUE, ha="center")
    ax.annotate("", (0.93, -0.2), (0.80, -0.2), arrowprops={"arrowstyle": "<->", "color": DARK})
    ax.text(0.87, -0.33, "scrub radius", ha="center", color=DARK)
    arrow(ax, (0.0, 0.2), (0.3, 0.2), "y")
    arrow(ax, (0.0, 0.2), (0.0, 0.5), "z")


def side(ax: Any) -> None:
    """From the right: caster and trail; the direction of travel is to the right."""
    ax.set_title("from the right")
    ax.axhline(0, color=GREY, lw=1)
    ax.add_patch(Circle((0.0, 0.55), 0.55, facecolor="#dbe7f3", edgecolor=BLUE, lw=1.5))
    ax.plot([0.0], [0.55], "o", color=BLUE)
    ax.text(-0.06, 0.62, "C", color=BLUE)
    ax.plot([0.28, -0.16], [0.0, 1.25], color=ORANGE, lw=1.8)
    ax.plot([0.28, 0.28], [0.0, 1.25], ":", color=GREY)
    ax.text(0.1, 1.32, "caster", color=ORANGE, ha="center")
    for x, name, colour in ((0.28, "G", ORANGE), (0.0, "A", BLUE)):
        ax.plot([x], [0], "o", color=colour)
        ax.text(x, -0.11, name, color=colour, ha="center")
    ax.annotate("", (0.0, -0.2), (0.28, -0.2), arrowprops={"arrowstyle": "<->", "color": DARK})
    ax.text(0.14, -0.33, "caster trail", ha="center", color=DARK)
    arrow(ax, (-0.65, 0.95), (-0.95, 0.95), "x")
    arrow(ax, (-0.65, 0.95), (-0.65, 1.25), "z")
    arrow(ax, (0.62, 1.1), (0.98, 1.1), "")
    ax.text(0.8, 1.2, "travel", ha="center", color=DARK)


def above(ax: Any) -> None:
    """From above: toe and the spin axis."""
    ax.set_title("from above")
    tilted(ax, (0.6, 0.55), (0.13, 0.55), -9)
    ax.plot([0.6, 0.6], [0.55, 1.35], ":", color=GREY)
    ax.plot([0.6, 0.473], [0.55, 1.35], "--", color=BLUE)
    ax.text(0.5, 1.4, "toe", color=BLUE, ha="center")
    ax.annotate("", (1.08, 0.626), (0.6, 0.55), arrowprops={"arrowstyle": "-|>", "color": ORANGE, "lw": 1.6})
    ax.text(1.1, 0.68, "s", color=ORANGE)
    ax.plot([0.0, 0.0], [0.0, 1.35], "-.", color=GREY, lw=1)
    ax.text(0.0, -0.12, "centre plane", color=GREY, ha="center")
    arrow(ax, (0.12, 0.4), (0.12, 0.1), "x")
    arrow(ax, (0.12, 0.4), (0.29, 0.4), "y")
    arrow(ax, (0.12, 0.8), (0.12, 1.15), "")
    ax.text(0.04, 1.22, "travel", color=DARK)


def main() -> None:
    """Draw the three views."""
    figure = Figure(figsize=(9, 4.0), layout="constrained")
    widths = (-0.1, 1.4), (-1.1, 1.1), (-0.25, 1.4)
    axes = figure.subplots(1, 3, width_ratios=[high - low for low, high in widths])
    for ax, draw, width in zip(axes, (rear, side, above), widths, strict=True):
        draw(ax)
        ax.set(xlim=width, ylim=(-0.42, 1.7))
        ax.set_aspect("equal")
        ax.set_axis_off()
    figure.savefig(Path(__file__).with_suffix(".png"), dpi=100)


if __name__ == "__main__":
    main()
