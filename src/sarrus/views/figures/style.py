"""Axes, colours and sizes that all figures share."""

from __future__ import annotations

from typing import Any

BLUE, ORANGE, GREY = "#1f5f99", "#d9730d", "#8a8f98"
MISSING = 'plots need Matplotlib: pip install "sarrus[plot]"'


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
