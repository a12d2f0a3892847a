"""Axes, colours and sizes that all figures share."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

BLUE, ORANGE, GREY = "#1f5f99", "#d9730d", "#8a8f98"
ROUND_OFF = 1e-11  # [-] of the largest number of a kind
LONG = 16  # characters of a vertical label
MISSING = 'plots need Matplotlib: pip install "sarrus[plot]"'


class Inches(NamedTuple):
    """Sizes of figures."""

    width: float = 7.0
    bar: float = 0.27
    labels: float = 1.1  # of a panel with bars
    panel: float = 2.7  # one of several in a row
    wide_panel: float = 4.2  # one of two in a row
    panel_height: float = 2.8


INCHES = Inches()
BARS = 4  # that fill the axes: fewer are no wider
DECADE = 10.0  # ratio of numbers from which a scale is logarithmic


def figure_of(width: float, height: float) -> Any:
    """Return a figure that belongs to no window: it is returned, shown by notebooks, and saved."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise ImportError(MISSING) from None
    return Figure(figsize=(width, height), layout="constrained")


def new_figure(width: float, height: float) -> Any:
    """A figure of pyplot, which ``plt.show()`` shows and ``plt.savefig()`` saves."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError(MISSING) from None
    return plt.figure(figsize=(width, height), layout="constrained")


def plot_axes(ax: Any, width: float = 7.0, height: float = 3.2) -> Any:
    """The axes to draw into, or those of a new figure; tidied."""
    return tidied(new_figure(width, height).subplots() if ax is None else ax)


def panels(ax: Any, count: int, height: float = 2.2, sharex: bool = True) -> list[Any]:
    """As many axes, by default with one time axis: those given, those of a given figure, or of a new one.

    Raises
    ------
    ValueError
        If another number of axes is given.
    """
    if ax is None and count == 1:
        return [plot_axes(None)]
    ax = new_figure(7.0, height * count) if ax is None else ax
    if hasattr(ax, "subplots"):
        ax = np.ravel(ax.subplots(count, 1, sharex=sharex))
    found = [ax] if hasattr(ax, "plot") else list(ax)
    if len(found) != count:
        raise ValueError(
            f"ax: {len(found)} axes for {count} panels. Give a list of {count} axes, or a figure."
        )
    return [tidied(one) for one in found]


def over_time(axes: list[Any], label: str = "t [s]") -> Any:
    """Label the common axis of some panels, by default of time; a single one alone, several as an array."""
    axes[-1].set_xlabel(label)
    return axes[0] if len(axes) == 1 else np.array(axes)


def suppress_round_off(ax: Any, largest: float, scale: float, unit: str) -> None:
    """Where curves are round-off of a scale, state a bound in words instead of drawing them at full height."""
    if 0 < largest <= ROUND_OFF * scale:
        bound = 10.0 ** np.ceil(np.log10(max(largest, np.finfo(float).tiny)))
        ax.set_ylim(-1, 1)
        ax.set_yticks([0])
        ax.text(0.5, 0.6, f"< {bound:.0e} {unit}".rstrip(), transform=ax.transAxes, ha="center", color=GREY)


def legend_beside(ax: Any, own: bool, title: str = "") -> None:
    """A legend to the right of the axes of a new figure, whose layout adapts; in axes of the user over the curves."""
    if own:
        place = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.0}
        ax.legend(frameon=False, title=title, **place)
    else:
        ax.legend(frameon=True, framealpha=0.8, edgecolor="none")


def in_two_lines(label: str) -> str:
    """The label of a vertical axis, its unit in a line of its own if both are longer than a panel is high."""
    return label.replace(" [", "\n[") if len(label) > LONG else label


def tidied(ax: Any) -> Any:
    """Axes without a frame above and on the right, with a faint grid."""
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(alpha=0.25, linewidth=0.6)
    return ax
