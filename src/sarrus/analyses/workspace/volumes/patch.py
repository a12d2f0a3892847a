"""A surface under construction, and its closure by level triangles between open edges."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from ....algebra import Array

CLOSED = "level"  # the cause of a triangle that closes the surface at one height

Edge = tuple[int, int]


class Sheet:
    """Vertices and triangles; `level` of a vertex is the index of its critical height."""

    def __init__(self) -> None:
        self.vertices: list[tuple[float, float, float]] = []
        self.levels: list[int] = []
        self.triangles: list[tuple[int, int, int]] = []
        self.of: list[int] = []
        self.causes: list[str] = [CLOSED]
        self.level = 0

    def point(self, p: Array, height: float) -> int:
        """A new vertex."""
        self.vertices.append((float(p[0]), float(p[1]), height))
        self.levels.append(self.level)
        return len(self.vertices) - 1

    def at_level(self, numbers: Sequence[int]) -> None:
        """Vertices belong to one critical height."""
        for number in numbers:
            self.levels[number] = self.level

    def add(self, a: int, b: int, c: int, cause: str = CLOSED) -> None:
        """A triangle, if its corners are different."""
        if len({a, b, c}) == 3:
            if cause not in self.causes:
                self.causes.append(cause)
            self.triangles.append((a, b, c))
            self.of.append(self.causes.index(cause))

    def plane(self, numbers: Sequence[int]) -> Array:
        """The first two coordinates of vertices (k, 2)."""
        return np.array([self.vertices[n][:2] for n in numbers]).reshape(-1, 2)

    def open_edges(self) -> Counter[Edge]:
        """Edges that triangles are still missing at, in the direction that these need."""
        found: Counter[Edge] = Counter()
        for a, b, c in self.triangles:
            found.update(((b, a), (c, b), (a, c)))
        return Counter({(a, b): n - found[b, a] for (a, b), n in found.items() if n > found[b, a]})


def fill(sheet: Sheet) -> None:
    """Close what is open: by Delaunay triangles inside of the open edges, then by fans."""
    by_level: dict[int, list[Edge]] = {}
    for edge, count in sheet.open_edges().items():
        by_level.setdefault(sheet.levels[edge[0]], []).extend([edge] * count)
    for edges in by_level.values():
        _level(sheet, edges)
    for cycle in _cycles(sheet.open_edges()):
        _fan(sheet, cycle)


def _level(sheet: Sheet, edges: Sequence[Edge]) -> None:
    """Triangles where open edges go around, upwards or downwards."""
    from scipy.spatial import Delaunay, QhullError  # only surfaces pay for its import

    numbers = sorted({n for edge in edges for n in edge})
    points = sheet.plane(numbers)
    try:
        triangles = Delaunay(points).simplices
    except (QhullError, ValueError):
        return
    corners = points[triangles]
    around = _winding(sheet, edges, corners.mean(axis=1))
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    for (a, b, c), winding, area in zip(triangles.tolist(), around, areas, strict=True):
        if winding:
            b, c = (b, c) if (area > 0) == (winding > 0) else (c, b)
            sheet.add(numbers[a], numbers[b], numbers[c])


def _winding(sheet: Sheet, edges: Sequence[Edge], points: Array) -> Array:
    """Return the winding numbers of edges about points (k,)."""
    a, b = sheet.plane([e[0] for e in edges]), sheet.plane([e[1] for e in edges])
    y = points[:, 1][:, None]
    crosses = (b[:, 1] > y).astype(int) - (a[:, 1] > y).astype(int)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    return np.asarray((crosses * ((crosses != 0) & (x > points[:, 0][:, None]))).sum(axis=1))


def _cycles(edges: Counter[Edge]) -> list[list[int]]:
    """Closed walks along open edges that meet no vertex twice."""
    leaving: dict[int, list[int]] = {}
    for (a, b), count in edges.items():
        leaving.setdefault(a, []).extend([b] * count)
    found = []
    while any(leaving.values()):
        walk = [next(a for a, others in leaving.items() if others)]
        while leaving.get(walk[-1]):
            there = leaving[walk[-1]].pop()
            if there in walk:
                k = walk.index(there)
                found.append(walk[k:])
                walk = walk[: k + 1]
            else:
                walk.append(there)
    return found


def _fan(sheet: Sheet, cycle: Sequence[int]) -> None:
    if len(cycle) == 3:
        sheet.add(cycle[0], cycle[1], cycle[2])
        return
    middle = np.mean([sheet.vertices[n] for n in cycle], axis=0)
    number = sheet.point(middle[:2], float(middle[2]))
    for a, b in zip(cycle, [*cycle[1:], cycle[0]], strict=True):
        sheet.add(a, b, number)
