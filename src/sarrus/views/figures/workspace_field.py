"""Heat maps inside the boundary of a workspace."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...results.maps.workspace_field import Quantity, WorkspaceField
from .style import GREY, plot_axes
from .workspace import draw_curves, path_of

MAPS: dict[str, Any] = {"solutions": "YlGnBu", "turn": "cividis"}
CLIPPED = 98  # percent of the numbers: where inputs lose control, manipulability has no bound
MANY = 10.0  # times the number in the middle: from there on the scale is logarithmic


def plot_workspace_field(found: WorkspaceField, quantity: Quantity | None = None, ax: Any = None) -> Any:
    """Draw one quantity as colours inside the boundary, with barriers.

    Parameters
    ----------
    found : WorkspaceField
    quantity : one of `found.values`; by default "conditioning", else the first
    ax : Matplotlib axes to draw into; by default a new figure's

    Returns
    -------
    Axes

    Raises
    ------
    SarrusError
        If it is not one of the quantities that were computed.
    ImportError
        If Matplotlib is not installed.
    """
    shown = quantity or ("conditioning" if "conditioning" in found.values else next(iter(found.values)))
    if shown not in found.values:
        raise SarrusError(f"{shown} was not computed; there are {', '.join(found.values)}")
    ax = plot_axes(ax, 7.5, 7.0)
    image = _colours(ax, found, shown)
    _scale(ax, image, found, shown)
    draw_curves(ax, found.workspace)
    ax.set_title(f"{found.name}: {found.meaning(shown)}", loc="left", fontsize=10)
    return ax


def _colours(ax: Any, found: WorkspaceField, shown: Quantity) -> Any:
    """The grid, cut off by the boundary; cells that it cuts go on from those beside them."""
    values, whole = _spread(found.values[shown]), shown == "solutions"
    colors = {"cmap": _map(found, shown), "norm": _norm(found.values[shown], whole)}
    shading = "nearest" if whole else "gouraud"
    image = ax.pcolormesh(*_wider(found), values, **colors, shading=shading)
    image.set_clip_path(path_of(found.workspace), transform=ax.transData)
    return image


def _norm(values: Array, whole: bool) -> Any:
    """From numbers to shares of the scale of colours."""
    from matplotlib.colors import LogNorm, Normalize

    if whole:
        return Normalize(-0.5, np.nanmax(values) + 0.5)
    low, middle, high = np.nanpercentile(values, (100 - CLIPPED, 50, CLIPPED))
    if low > 0 and high > MANY * middle:
        return LogNorm(low, high)
    return Normalize(0.0, high)


def _map(found: WorkspaceField, shown: Quantity) -> Any:
    import matplotlib as mpl

    colors = mpl.colormaps[MAPS.get(shown, "viridis")]
    return colors.resampled(int(np.nanmax(found.values[shown])) + 1) if shown == "solutions" else colors


def _spread(values: Array) -> Array:
    """Two more rings around the grid and what is inside, with the means of their neighbours."""
    found = np.pad(values, 2, constant_values=np.nan)
    for _ in range(2):
        beside = np.stack([np.roll(found, shift, axis) for axis in (0, 1) for shift in (1, -1)])
        known = np.isfinite(beside)
        mean = np.where(known, beside, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        found = np.where(np.isfinite(found) | ~known.any(axis=0), found, mean)
    return found


def _wider(found: WorkspaceField) -> tuple[Array, Array]:
    """The grid with two more rings."""
    x, y = (
        a[0] + np.arange(-2, len(a) + 2) * (a[-1] - a[0]) / max(len(a) - 1, 1) for a in (found.x, found.y)
    )
    return x, y


def _scale(ax: Any, image: Any, found: WorkspaceField, shown: Quantity) -> None:
    """A scale of colours at the side; whole numbers stand in the middle of theirs."""
    top = np.nanmax(found.values[shown])
    beyond = shown != "solutions" and top > image.norm.vmax
    bar = ax.figure.colorbar(image, ax=ax, shrink=0.8, extend="max" if beyond else "neither")
    if shown == "solutions":
        bar.ax.set_ylim(0.5, top + 0.5)
        bar.set_ticks(np.arange(1, int(top) + 1))
    bar.outline.set_edgecolor(GREY)
