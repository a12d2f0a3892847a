"""A mechanism as thin lines at a position, in the plane of two outputs."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ..algebra import Array
from ..model import blueprint
from ..model.coordinates import WIDTH
from ..model.geometry.rotation import matrix
from ..results.maps.workspace import Workspace

GHOST = "#4b5058"


class _Line(NamedTuple):
    """Between two points in space; of a body, or a length without one."""

    ends: Array
    body: bool


def draw_ghost(ax: Any, found: Workspace, q: Array) -> None:
    """The mechanism at a position, where the outputs are coordinates of a point, which is marked."""
    axes = ["xyz".find(name[-1]) for name in found.outputs]
    if found.map is None or min(axes) < 0 or set(found.units) != {"m"}:
        return
    style = {"color": GHOST, "alpha": 0.55, "marker": "o", "markersize": 2.5}
    for line in _lines(found.map.problem, q):
        ax.plot(*line.ends[:, axes].T, **style, linewidth=1.6 if line.body else 0.8)
    ax.plot(*_outputs(found, q), marker="o", markersize=5, color=GHOST)


def _outputs(found: Workspace, q: Array) -> Array:
    p = found.map.problem
    return np.asarray(p.values(q / p.scale)[p.m + p.outputs] * p.units[p.outputs])


def _lines(problem: Any, q: Array) -> Iterator[_Line]:
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
            yield _Line(np.array(ends), False)
        elif ends:
            points.setdefault(measure.placed.bodies[-1], []).append(ends[-1])
    for body, places in points.items():
        if body:
            different = [
                p for n, p in enumerate(places) if all(np.linalg.norm(p - o) > 1e-9 for o in places[:n])
            ]
            yield from (_Line(np.array(pair), True) for pair in combinations(different, 2))


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
