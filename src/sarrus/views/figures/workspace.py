"""Workspaces as pictures: what can be reached, boundary, barriers with arrows, the mechanism, and heat maps inside."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...analyses.workspace.regions.mapping import map_of
from ...model import SarrusError
from ...model.expansion.blueprint import blueprint
from ...model.show import quote, suggest
from ...outputs.output import labelled
from ...results.maps.workspace import BoundaryCurve, Component, CurveKind, Workspace, inside, places
from ...results.maps.workspace_field import Quantity, WorkspaceField
from ..looks.anchors import fields
from ..looks.part import place_of
from .style import BLUE, DECADE, GREY, ORANGE, plot_axes
from .workspace_report import area_unit

FILL, VOID = "#dbe7f3", "#8a4fa3"
STYLES: dict[CurveKind, dict[str, Any]] = {
    "crossable": {"color": GREY, "linewidth": 0.7, "alpha": 0.7},
    "barrier": {"color": ORANGE, "linewidth": 1.3},
    "void": {"color": VOID, "linewidth": 2.2},
    "outer": {"color": BLUE, "linewidth": 2.2},
}
DESCRIPTIONS = {
    "outer": "boundary",
    "void": "boundary of a void",
    "barrier": "barrier (arrows: the side that motion keeps to)",
    "crossable": "singular, but can be crossed",
}
ALL: tuple[CurveKind, ...] = get_args(CurveKind)
BOUNDING: tuple[CurveKind, ...] = ("outer", "void", "barrier")
ARROWS = 36  # of the size of the picture between two of them


def plot_workspace(
    found: Workspace,
    ax: Any = None,
    *,
    kinds: Sequence[CurveKind] = ALL,
    at: ArrayLike | None = None,
    ghosts: int = 3,
    arrows: bool = True,
) -> Any:
    """Draw what can be reached, its boundary, barriers with arrows to their open side, and some positions.

    Parameters
    ----------
    found : Workspace
    ax : Matplotlib axes to draw into; by default a new figure's
    kinds : of curves that are drawn, e.g. ``["outer", "void", "barrier"]`` or barriers alone
    at : (k, 2) places at which the mechanism is drawn, found by inverse kinematics
    ghosts : without these, how many positions of the mechanism on the boundary are drawn
    arrows : whether barriers show the side to which motion keeps

    Returns
    -------
    Axes

    Raises
    ------
    SarrusError
        If a place cannot be reached, or a kind is unknown.
    ImportError
        If Matplotlib is not installed.
    """
    unknown = [kind for kind in kinds if kind not in STYLES]
    if unknown:
        raise SarrusError(f"there are no curves of kind {quote(unknown[0])}. {suggest(unknown[0], STYLES)}")
    ax = plot_axes(ax, 7.5, 7.0)
    _fill(ax, found)
    draw_curves(ax, found, kinds, arrows)
    _number(ax, found)
    for q in _chosen(found, ghosts) if at is None else _placed(found, at):
        draw_ghost(ax, found, q)
    text = (
        f"{found.area:.6g} {area_unit(found)} can be reached"
        if found.success
        else f"map not complete ({found.status})"
    )
    ax.set_title(f"{found.name}: {text}", loc="left", fontsize=10)
    return ax


def draw_curves(
    ax: Any, found: Workspace, kinds: Sequence[CurveKind] = BOUNDING, arrows: bool = True
) -> None:
    """The curves of some kinds with a legend, barriers with arrows; axes with names, units and one scale."""
    for kind, style in STYLES.items():
        mine = [curve for curve in found.of_kind(kind) if kind in kinds and not curve.again]
        for n, curve in enumerate(mine):
            ax.plot(*curve.u.T, **style, label=DESCRIPTIONS[kind] if n == 0 else None, solid_capstyle="round")
    if arrows and "barrier" in kinds:
        _arrows(ax, found)
    x, y = map(labelled, found.outputs, found.units)
    ax.set(xlabel=x, ylabel=y)
    if found.units[0] == found.units[1]:
        ax.set_aspect("equal", adjustable="datalim")
    if ax.get_legend_handles_labels()[0]:
        ax.legend(frameon=False, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=2)


def path_of(found: Workspace) -> Any:
    """Return the reachable region as a path with holes."""
    from matplotlib.path import Path

    return Path.make_compound_path(*(Path(loop) for part in found.components for loop in part.loops))


def _fill(ax: Any, found: Workspace) -> None:
    from matplotlib.patches import PathPatch

    if found.components:
        ax.add_patch(PathPatch(path_of(found), facecolor=FILL, edgecolor="none"))


def _number(ax: Any, found: Workspace) -> None:
    """The numbers of parts that do not hang together, in their widest places."""
    if len(found.components) > 1:
        for n, part in enumerate(found.components, 1):
            style = {"ha": "center", "va": "center", "fontsize": 11, "color": BLUE, "weight": "bold"}
            ax.text(*_widest(part), f"{n}", **style)


def _widest(part: Component) -> Array:
    """A point of a part that is far from its boundary."""
    corners = np.concatenate(part.loops)
    low, high = corners.min(axis=0), corners.max(axis=0)
    shares = (np.arange(25) + 0.5) / 25
    points = low + (high - low) * np.stack(np.meshgrid(shares, shares), axis=-1).reshape(-1, 2)
    points = points[inside(list(part.loops), points)]
    away = [np.linalg.norm(corners - point, axis=1).min() for point in points]
    return np.asarray(points[int(np.argmax(away))]) if away else corners.mean(axis=0)


def _placed(found: Workspace, at: ArrayLike) -> Iterator[Array]:
    """Positions with the outputs at given places."""
    for place in places(at):
        q = map_of(found).position_at(place)
        if q is None:
            text = ", ".join(f"{number:g}" for number in place)
            raise SarrusError(
                f"{found.name}: no position was found with the outputs at {text}. Choose another place."
            )
        yield q


def _arrows(ax: Any, found: Workspace) -> None:
    """Short arrows to the open side of barriers inside, at equal distances."""
    all_points = np.concatenate([curve.u for curve in found.curves]) if found.curves else np.zeros((1, 2))
    size = float(np.ptp(all_points, axis=0).max()) or 1.0
    for curve in found.of_kind("barrier"):
        if curve.again:
            continue
        for k in _evenly(curve, size / ARROWS * 2):
            tip = curve.u[k] + curve.inward[k] * size / ARROWS * 0.6
            style = {"arrowstyle": "-|>", "color": ORANGE, "linewidth": 0.8, "mutation_scale": 6}
            ax.annotate("", xy=tip, xytext=curve.u[k], arrowprops=style)


def _evenly(curve: BoundaryCurve, distance: float) -> list[int]:
    """Points of a curve at equal distances, at least the middle."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve.u, axis=0), axis=1))])
    count = max(1, int(along[-1] / distance))
    return [int(np.searchsorted(along, s)) for s in (np.arange(count) + 0.5) / count * along[-1]]


def _chosen(found: Workspace, count: int) -> list[Array]:
    """Positions in the middle of the longest boundary curves."""
    longest = sorted(found.boundary, key=lambda curve: -curve.length)[:count]
    return [curve.q[len(curve.q) // 2] for curve in longest]


GHOST = "#4b5058"


def draw_ghost(ax: Any, found: Workspace, q: Array) -> None:
    """The mechanism at a position, where the outputs are coordinates of a point, which is marked."""
    axes = ["xyz".find(name[-1]) for name in found.outputs]
    if found.map is None or min(axes) < 0 or set(found.units) != {"m"}:
        return
    style = {"color": GHOST, "alpha": 0.55, "marker": "o", "markersize": 2.5}
    for ends, width in _lines(map_of(found).problem, q):
        ax.plot(*ends[:, axes].T, **style, linewidth=width)
    ax.plot(*_outputs(found, q), marker="o", markersize=5, color=GHOST)


def _outputs(found: Workspace, q: Array) -> Array:
    p = map_of(found).problem
    return np.asarray(p.values(q / p.scale)[p.m + p.outputs] * p.units[p.outputs])


def _lines(problem: Any, q: Array) -> Iterator[tuple[Array, float]]:
    """Bodies as lines between the points at which they are held, and lengths between their ends, with their widths."""
    points: dict[int, list[Array]] = {}
    for placed in blueprint(problem.system.model).placed:
        if placed.element.rows:
            for body, place in _places(placed, q):
                points.setdefault(body, []).append(place)
    for measure in problem.table:
        ends = [place for _, place in _places(measure.placed, q)]
        if measure.kind == "square":
            for body, place in zip(measure.placed.bodies, ends, strict=False):
                points.setdefault(body, []).append(place)
            yield np.array(ends), 0.8
        elif ends:
            points.setdefault(measure.placed.bodies[-1], []).append(ends[-1])
    for body, held in points.items():
        if body:
            different = [p for n, p in enumerate(held) if all(np.linalg.norm(p - o) > 1e-9 for o in held[:n])]
            yield from ((np.array(pair), 1.6) for pair in combinations(different, 2))


def _places(placed: Any, q: Array) -> Iterator[tuple[int, Array]]:
    """The bodies and places of an element's points s_i and s_j, if it has any."""
    known = fields(placed)
    names = [name for name in ("s_i", "s_j") if name in known]
    for name, body in zip(names, placed.bodies, strict=False):
        yield body, place_of(q, body, np.array(known[name], dtype=float))


MAPS: dict[str, Any] = {"solutions": "YlGnBu", "turn": "cividis"}
CLIPPED = 98  # percent of the numbers: where inputs lose control, manipulability has no bound


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
        raise SarrusError(f"{shown} was not computed. Choose from {', '.join(found.values)}.")
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
    """Return the normalization of the scale of colours."""
    from matplotlib.colors import LogNorm, Normalize

    if whole:
        return Normalize(-0.5, np.nanmax(values) + 0.5)
    low, middle, high = np.nanpercentile(values, (100 - CLIPPED, 50, CLIPPED))
    if low > 0 and high > DECADE * middle:
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
