"""A study as a picture: its responses over every parameter, and how they are distributed."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..studies import StudyTable
from .plots import BLUE, ORANGE, _tidy, figure_of

MOST = 11  # parameters in one picture
WIDTH, HEIGHT = 2.7, 2.6  # of one plot, in inches
FEW = 12  # values of a parameter that are joined by a line of means


def plot_study(table: StudyTable, response: str | None = None, axes: Any = None) -> Any:
    """Draw a response over each parameter that changes, and its distribution over all cases.

    Parameters
    ----------
    table : StudyTable
    response : a column of it; by default the first response
    axes : Matplotlib axes, one for each parameter that changes and one more; by default those of a new figure

    Returns
    -------
    The axes, the distribution's last.
    """
    chosen = table.responses[0] if response is None else response
    y = table[chosen]
    names = [name for name in table.parameters if np.ptp(table[name]) > 0][:MOST]
    places = _axes(len(names) + 1) if axes is None else np.ravel(axes)
    for ax, name in zip(places, names, strict=False):
        _over(ax, table[name], y, name)
    for ax in places[: len(names)]:
        ax.set_ylabel(chosen if ax is places[0] else "")
    _distribution(places[len(names)], y[np.isfinite(y)], chosen)
    return places[: len(names) + 1]


def _axes(count: int) -> Any:
    """Axes in rows of four at most."""
    columns = min(count, 4)
    rows = -(-count // columns)
    figure = figure_of(max(WIDTH * columns, 3.6), HEIGHT * rows)
    every = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for ax in every[count:]:
        ax.remove()
    return every[:count]


def _over(ax: Any, x: Any, y: Any, name: str) -> None:
    """Every case as a dot; of a parameter with few values, the mean response over each."""
    good = np.isfinite(y)
    size = 16 if len(x) < 300 else 5
    ax.scatter(x[good], y[good], s=size, color=BLUE, alpha=0.55, linewidths=0)
    values = np.unique(x[good])
    if 1 < len(values) <= FEW < len(x):
        ax.plot(values, [y[good & (x == value)].mean() for value in values], color=ORANGE, linewidth=1.6)
    for value in x[~good]:
        ax.axvline(value, ymax=0.04, color=ORANGE, linewidth=1)
    ax.set_xlabel(name)
    _tidy(ax)


def _distribution(ax: Any, y: Any, name: str) -> None:
    """A histogram, with the mean and one standard deviation to each side."""
    if len(y):
        ax.hist(y, bins=max(5, min(40, round(np.sqrt(len(y))))), color=BLUE, alpha=0.75)
        ax.axvline(y.mean(), color=ORANGE, linewidth=1.6)
        ax.axvspan(y.mean() - y.std(), y.mean() + y.std(), color=ORANGE, alpha=0.15, linewidth=0, zorder=0)
    ax.set_xlabel(name)
    ax.set_ylabel("cases")
    _tidy(ax)
