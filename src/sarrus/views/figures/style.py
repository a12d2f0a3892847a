"""Figures of trajectories and of the derivative check."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...results import Trajectory

BLUE, ORANGE, GREY = "#1f5f99", "#d9730d", "#8a8f98"
MISSING = 'plots need Matplotlib: pip install "sarrus[plot]"'
STYLES: tuple[dict[str, Any], ...] = (  # of x, y and z: each is seen where they are equal
    {"color": BLUE, "linewidth": 1.4},
    {"color": ORANGE, "linewidth": 2.8},
    {"color": "#4b5058", "linewidth": 1.4, "linestyle": (0, (3, 3))},
)
FLOOR = 1e-17  # shown in place of an error of exactly zero


def figure_of(width: float, height: float) -> Any:
    """Return a figure that belongs to no window: it is returned, shown by notebooks, and saved."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise ImportError(MISSING) from None
    return Figure(figsize=(width, height), layout="constrained")


def plot_axes(ax: Any, width: float = 7.0, height: float = 3.2) -> Any:
    """The axes to draw into, or those of a new figure of pyplot, so that ``plt.show()`` shows it; tidied."""
    if ax is None:
        try:
            import matplotlib.pyplot as plt
        except ImportError:
            raise ImportError(MISSING) from None
        ax = plt.subplots(figsize=(width, height), layout="constrained")[1]
    return tidied(ax)


def tidied(ax: Any) -> Any:
    """Axes without a frame above and on the right, with a faint grid."""
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(alpha=0.25, linewidth=0.6)
    return ax


def motion_figure(run: Trajectory, sliding: str, turning: str) -> Any:
    """One body's position and velocity, another's spin, and the constraint violation over time, as one figure."""
    slide, figure = run[sliding], figure_of(9.5, 5.6)
    axes = figure.subplots(2, 2, sharex=True)
    panels = {
        f"{sliding}: position [m]": slide.position,
        f"{sliding}: velocity [m/s]": slide.velocity,
        f"{turning}: spin in body axes [rad/s]": run[turning].angular_velocity_body,
    }
    for ax, (label, curves) in zip(axes.flat, panels.items(), strict=False):
        for curve, name, style in zip(curves.T, "xyz", STYLES, strict=True):
            ax.plot(run.t, curve, label=name, **style)
        tidied(ax).set_title(label, loc="left", fontsize=10)
    lines = axes[0, 0].get_lines()
    figure.legend(handles=lines, frameon=False, ncols=3, loc="upper right", fontsize=10)
    axes[1, 1].semilogy(run.t, np.maximum(run.violation, FLOOR), color=BLUE, linewidth=0.8)
    tidied(axes[1, 1]).set_title("largest constraint violation |Φ|", loc="left", fontsize=10)
    for ax in axes[1]:
        ax.set_xlabel("t [s]")
    figure.suptitle(run.name, x=0.01, ha="left")
    return figure


def check_figure(report: Any, tolerance: float) -> Any:
    """How far every operator is from its independent value, as one figure."""
    findings = list(report.findings)[::-1]
    figure = figure_of(7.5, 0.24 * len(findings) + 1.2)
    ax = figure.subplots()
    errors = [max(f.error, FLOOR) for f in findings]
    colours = [BLUE if f.ok else ORANGE for f in findings]
    ax.hlines(range(len(findings)), FLOOR, errors, color=colours, linewidth=1.2)
    ax.scatter(errors, range(len(findings)), color=colours, s=18, zorder=3)
    ax.axvline(tolerance, color=ORANGE, linestyle="--", linewidth=1.0)
    note = {"color": ORANGE, "ha": "right", "va": "center", "fontsize": 8}
    ax.text(tolerance * 0.7, len(findings) - 1, "tolerance", **note)
    ax.set_xscale("log")
    ax.set_ylim(-0.7, len(findings) - 0.3)
    ax.set_xlim(FLOOR / 2, max(10 * tolerance, *errors))
    ax.set_yticks(range(len(findings)), [f.operator.name for f in findings], fontsize=8, family="monospace")
    ax.set_xlabel("largest relative difference from the independent value")
    ax.set_title(f"{report.system}: every operator, checked", loc="left", fontsize=10)
    tidied(ax)
    return figure
