"""Workspaces: pictures as in the literature, and a report in words."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np

from ..algebra import Array
from ..model import blueprint
from ..model.coordinates import WIDTH
from ..model.rotation import matrix
from ..results.input_singularities import InputSingularities
from ..results.workspace import BoundaryCurve, CurveKind, Workspace
from .plots import BLUE, GREY, ORANGE, _tidy, _window_axes

FILL, VOID, GHOST = "#dbe7f3", "#8a4fa3", "#4b5058"
STYLES: dict[CurveKind, dict[str, Any]] = {
    "crossable": {"color": GREY, "linewidth": 0.7, "alpha": 0.7},
    "barrier": {"color": ORANGE, "linewidth": 1.3},
    "void": {"color": VOID, "linewidth": 2.2},
    "outer": {"color": BLUE, "linewidth": 2.2},
}
TOLD = {
    "outer": "boundary",
    "void": "boundary of a void",
    "barrier": "barrier (arrows: the side that motion keeps to)",
    "crossable": "singular, but can be crossed",
}
ARROWS = 36  # of the size of the picture between two of them


def plot_workspace(found: Workspace, ax: Any = None, *, ghosts: int = 3, arrows: bool = True) -> Any:
    """Draw what can be reached, its boundary, barriers with arrows to their open side, and some positions.

    Parameters
    ----------
    found : Workspace
    ax : Matplotlib axes to draw into; by default a new figure's
    ghosts : how many positions of the mechanism on the boundary are drawn
    arrows : whether barriers show the side to which motion keeps

    Returns
    -------
    Axes

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    if ax is None:
        ax = _window_axes()
        ax.figure.set_size_inches(7.5, 7.0)
    _fill(ax, found)
    for kind, style in STYLES.items():
        for n, curve in enumerate(curve for curve in found.of_kind(kind) if not curve.again):
            ax.plot(*curve.u.T, **style, label=TOLD[kind] if n == 0 else None, solid_capstyle="round")
    if arrows:
        _arrows(ax, found)
    for q in _chosen(found, ghosts):
        _ghost(ax, found, q)
    ax.set_xlabel(f"{found.outputs[0]} [{found.units[0]}]")
    ax.set_ylabel(f"{found.outputs[1]} [{found.units[1]}]")
    ax.set_title(
        f"{found.name}: {found.area:.6g} {_area_unit(found)} can be reached", loc="left", fontsize=10
    )
    if found.units[0] == found.units[1]:
        ax.set_aspect("equal", adjustable="datalim")
    ax.legend(frameon=False, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=2)
    return _tidy(ax)


def _fill(ax: Any, found: Workspace) -> None:
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    for part in found.components:
        path = Path.make_compound_path(*(Path(loop) for loop in part.loops))
        ax.add_patch(PathPatch(path, facecolor=FILL, edgecolor="none"))


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


def _ghost(ax: Any, found: Workspace, q: Array) -> None:
    """The mechanism at a position, where the outputs are coordinates of a point."""
    axes = ["xyz".find(name[-1]) for name in found.outputs]
    if found.map is None or min(axes) < 0 or set(found.units) != {"m"}:
        return
    style = {"color": GHOST, "linewidth": 1.0, "alpha": 0.55, "marker": "o", "markersize": 2.5}
    for one, other in _lines(found.map.problem, q):
        ax.plot(*np.array([one[axes], other[axes]]).T, **style)


def _lines(problem: Any, q: Array) -> Iterator[tuple[Array, Array]]:
    """Bodies as lines between the points at which they are held, and lengths between their ends."""
    points: dict[int, list[Array]] = {}
    for placed in blueprint(problem.system.model).placed:
        if placed.element.rows:
            for body, place in _places(placed, q):
                points.setdefault(body, []).append(place)
    for measure in problem.table:
        ends = [place for _, place in _places(measure.placed, q)]
        if measure.kind == "square":
            for body, place in _places(measure.placed, q):
                points.setdefault(body, []).append(place)
            yield ends[0], ends[1]
        elif ends:
            points.setdefault(measure.placed.bodies[-1], []).append(ends[-1])
    for body, places in points.items():
        if body:
            different = [
                p for n, p in enumerate(places) if all(np.linalg.norm(p - o) > 1e-9 for o in places[:n])
            ]
            yield from combinations(different, 2)


def _places(placed: Any, q: Array) -> Iterator[tuple[int, Array]]:
    fields = dict(zip(placed.element.fields, placed.values, strict=False))
    names = [name for name in ("s_i", "s_j") if name in fields]
    if not names:
        return
    for name, body in zip(names, placed.bodies, strict=False):
        s = np.array(fields[name], dtype=float)
        if body:
            own = q[WIDTH * (body - 1) : WIDTH * body]
            s = own[:3] + matrix(own[3:]) @ s
        yield body, s


def plot_input_singularities(found: InputSingularities, ax: Any = None) -> Any:
    """Draw dashed where the inputs lose control, over a workspace if its axes are given.

    Parameters
    ----------
    found : InputSingularities
    ax : Matplotlib axes to draw into; by default a new figure's

    Returns
    -------
    Axes

    Raises
    ------
    ImportError
        If Matplotlib is not installed.
    """
    ax = _window_axes() if ax is None else ax
    for n, curve in enumerate(found.curves):
        label = f"{', '.join(found.inputs)} lose control" if n == 0 else None
        ax.plot(*curve.line.T, color="#c23b4e", linewidth=1.4, linestyle=(0, (4, 2)), label=label)
    if found.curves:
        ax.legend(frameon=False, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=2)
    return _tidy(ax)


def _area_unit(found: Workspace) -> str:
    return "m²" if found.units == ("m", "m") else "rad²" if found.units == ("rad", "rad") else "m rad"


def workspace_report(found: Workspace) -> str:
    """What was found, in words: area, parts, voids, barriers with their causes, tests, work."""
    unit = _area_unit(found)
    lines = [
        f"{found.name}: {' and '.join(found.outputs)} can reach {found.area:.9g} {unit} "
        f"(± {found.area_error:.1g}), perimeter {found.perimeter:.9g}.",
        _parts(found, unit),
        *(_causes(found, kind) for kind in TOLD),
        found.message + ".",
        str(found.verification or "It was not tested by random positions; see verify_workspace."),
    ]
    if found.effort:
        e = found.effort
        lines.append(
            f"Work: {e.points} points of curves, {e.newton_steps} Newton steps, {e.starts} starts, "
            f"{len(found.curves)} parts of curves."
        )
    return "\n".join(line for line in lines if line)


def _parts(found: Workspace, unit: str) -> str:
    count = len(found.components)
    if count == 1:
        return "It hangs together in one part."
    areas = ", ".join(f"{part.area:.6g}" for part in found.components)
    return f"It falls into {count} parts that do not hang together, of {areas} {unit}."


def _causes(found: Workspace, kind: str) -> str:
    """Lengths of the curves of one kind by their causes, the longest first."""
    totals: dict[str, float] = {}
    for curve in found.curves:
        if curve.kind == kind and not curve.again:
            totals[curve.cause] = totals.get(curve.cause, 0.0) + curve.length
    if not totals:
        return ""
    listed = sorted(totals.items(), key=lambda item: -item[1])
    told = ", ".join(f"{cause} ({length:.4g})" for cause, length in listed[:6])
    more = f", and {len(listed) - 6} others" if len(listed) > 6 else ""
    words = {
        "outer": "Boundary",
        "void": "Voids",
        "barrier": "Barriers inside",
        "crossable": "Can be crossed",
    }
    return f"{words[kind]} by cause and length: {told}{more}."
