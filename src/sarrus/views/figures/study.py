"""Studies: responses over one parameter or several, two parameters as a contour, and their distribution."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...model import show
from ...outputs.output import labelled
from .style import BLUE, INCHES, ORANGE, new_figure, tidied

if TYPE_CHECKING:
    from ...studies import StudyTable

MOST = 11  # parameters in one picture
LEVELS = 14  # of a contour
NOISE = 1e-5  # of the largest value: a response that varies less has no contour, see `plot_study`
ENOUGH = 4  # cases that a contour needs


def plot_study(table: StudyTable, *responses: str, ax: Any = None) -> Any:
    """Draw responses over each parameter that changes, and their distributions over all cases; one panel for each.

    Where two parameters change, a response is a contour over both, with a mark for every case; cases without a result
    are crosses. A response that varies by less than 1e-5 of its largest value, as errors of simulations may, has no
    contour.

    Parameters
    ----------
    table : StudyTable
    responses : columns of it; by default all responses
    ax : a figure, or Matplotlib axes: for each response one for each parameter that changes, or one for a contour,
        and one more; by default a new figure

    Returns
    -------
    The axes, those of the first response first, its distribution last.
    """
    chosen = responses or list(table.responses)
    names = [name for name in table.parameters if np.ptp(table[name]) > 0][:MOST]
    parts = [_panels(table, names, response) for response in chosen]
    count = [len(part) for part in parts]
    ax = new_figure(INCHES.wide_panel, INCHES.panel_height) if ax is None else ax
    places = _axes(count, ax) if hasattr(ax, "subplots") else np.ravel(ax)
    for place, draw in zip(places, (draw for part in parts for draw in part), strict=False):
        draw(place)
    return places[: sum(count)]


def _panels(table: StudyTable, names: list[str], response: str) -> list[Any]:
    """Return the functions that draw the panels of a response."""
    y, label = table[response], labelled(response, table.units.get(response, ""))
    titles = [labelled(name, table.units.get(name, "")) for name in names]
    if len(names) == 2 and _spread(table, names, y):
        panels = [partial(_contour, x=[table[name] for name in names], y=y, titles=titles, label=label)]
    else:
        labels = [label, *([""] * len(names))]
        places = zip(names, titles, labels, strict=False)
        over = partial(_over, y=y, alone=len(names) == 1)
        panels = [partial(over, x=table[name], name=title, label=ylabel) for name, title, ylabel in places]
    return [*panels, partial(_distribution, y=y[np.isfinite(y)], name=label)]


def _spread(table: StudyTable, names: list[str], y: Any) -> bool:
    """Whether the cases with a result span an area."""
    good = np.isfinite(y)
    points = np.column_stack([(table[name] - table[name].min()) / np.ptp(table[name]) for name in names])[
        good
    ]
    return len(points) >= ENOUGH and np.linalg.matrix_rank(points - points[0], tol=1e-6) == 2


def _axes(counts: list[int], figure: Any) -> Any:
    """A row of axes for each response; a single response in rows of four at most."""
    columns = max(counts) if len(counts) > 1 else min(counts[0], 4)
    rows = len(counts) if len(counts) > 1 else -(-counts[0] // columns)
    width = INCHES.wide_panel if columns == 2 else INCHES.panel
    figure.set_size_inches(max(width * columns, 3.6), INCHES.panel_height * rows)
    every = figure.subplots(rows, columns, squeeze=False)
    wanted = counts if len(counts) > 1 else [*[columns] * (rows - 1), counts[0] - columns * (rows - 1)]
    for row, count in zip(every, wanted, strict=True):
        for ax in row[count:]:
            ax.remove()
    return np.concatenate([row[:count] for row, count in zip(every, wanted, strict=True)])


def _contour(ax: Any, x: list[Any], y: Any, titles: list[str], label: str) -> None:
    """A response over two parameters: filled levels between the cases, each with a mark."""
    good = np.isfinite(y)
    first, second = (values[good] for values in x)
    if np.ptp(y[good]) > NOISE * abs(y[good]).max():
        filled = ax.tricontourf(first, second, y[good], levels=LEVELS, cmap="viridis")
        ax.figure.colorbar(filled, ax=ax)
    mark = {"markersize": 3, "markerfacecolor": "white", "markeredgecolor": "black", "markeredgewidth": 0.5}
    ax.plot(first, second, "o", clip_on=False, **mark)
    if not good.all():  # an empty curve without clipping has no size that a layout knows
        ax.plot(x[0][~good], x[1][~good], "x", markersize=6, color=ORANGE, clip_on=False)
    ax.set(xlabel=titles[0], ylabel=titles[1])
    ax.set_title(label, loc="left", fontsize=10)
    ax.locator_params(axis="x", nbins=5)
    tidied(ax)


def _over(ax: Any, x: Any, y: Any, name: str, label: str, alone: bool) -> None:
    """Every case as a dot; of a parameter with few values, or one that changes alone, the mean over each."""
    good = np.isfinite(y)
    size = 16 if len(x) < 300 else 5
    ax.scatter(x[good], y[good], s=size, color=BLUE, alpha=0.55, linewidths=0)
    values = np.unique(x[good])
    if 1 < len(values) and (alone or len(values) <= min(show.MOST, len(x) - 1)):
        ax.plot(values, [y[good & (x == value)].mean() for value in values], color=ORANGE, linewidth=1.6)
    for value in x[~good]:
        ax.axvline(value, ymax=0.04, color=ORANGE, linewidth=1)
    ax.set(xlabel=name, ylabel=label)
    ax.locator_params(axis="x", nbins=5)
    tidied(ax)


def _distribution(ax: Any, y: Any, name: str) -> None:
    """A histogram, with the mean and one standard deviation to each side."""
    if len(y):
        ax.hist(y, bins=max(5, min(40, round(np.sqrt(len(y))))), color=BLUE, alpha=0.75)
        ax.axvline(y.mean(), color=ORANGE, linewidth=1.6)
        ax.axvspan(y.mean() - y.std(), y.mean() + y.std(), color=ORANGE, alpha=0.15, linewidth=0, zorder=0)
    ax.set(xlabel=name, ylabel="cases")
    ax.yaxis.get_major_locator().set_params(integer=True)
    tidied(ax)
