"""Division of the plane of the outputs by candidate curves, which are cut at their intersections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ....algebra import Array
from ....results.maps.workspace import DENSE, polygon
from .arc import Arc

TOUCH = 2e-6  # free of units: nearer points are one
SHARPEST = 20.0  # difference of curvatures of touching curves, free of units
NEARLY = 0.1  # of a chord: how near to another one it is where their curves may cross
SLANT = 1e-5  # sine of the angle of curves that cross


# A curve on a piece: number of the branch, and its parameters at the ends of the piece
Owner = tuple[int, float, float]


@dataclass(eq=False)
class Piece:
    """A part of the plane's division: an arc from one node to another, with the curves on it."""

    arc: Arc
    owners: list[Owner]
    start: int = -1
    end: int = -1


@dataclass
class Division:
    """Nodes (count, 2) and the pieces between them."""

    nodes: Array
    pieces: list[Piece] = field(default_factory=list)


def divide(arcs: Sequence[Arc]) -> Division:
    """Divide the plane by curves."""
    pieces = [Piece(arc, [(n, 0.0, arc.end)]) for n, arc in enumerate(arcs) if arc.length > TOUCH]
    pieces = _cut_at_ends(pieces)
    pieces = _once(pieces)
    pieces = _cut(pieces, _crossings(pieces))
    return _joined(_once(pieces))


def _cut(pieces: list[Piece], cuts: Mapping[int, list[float]]) -> list[Piece]:
    """Cut pieces at parameters."""
    found: list[Piece] = []
    for n, piece in enumerate(pieces):
        ends = [0.0, *_apart(piece.arc, sorted(cuts.get(n, []))), piece.arc.end]
        found += [_part(piece, a, b) for a, b in pairwise(ends)] if len(ends) > 2 else [piece]
    return found


def _apart(arc: Arc, places: list[float]) -> list[float]:
    """Places that are no nearer to each other or to the ends than `TOUCH`."""
    chosen = [0.0]
    for at in places:
        near = [
            abs(at - x) < 1.0 and _distance(arc.point(at), arc.point(x)) < TOUCH
            for x in (chosen[-1], arc.end)
        ]
        if not any(near):
            chosen.append(at)
    return chosen[1:]


def _distance(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b))


def _part(piece: Piece, a: float, b: float) -> Piece:
    ends = np.array([a, b]) / piece.arc.end
    owners = [(n, *(low + ends * (high - low)).tolist()) for n, low, high in piece.owners]
    return Piece(piece.arc.part(a, b), owners)


def _ends(pieces: Sequence[Piece]) -> Array:
    """The first and the last point of every piece (2 count, 2)."""
    return np.array([p.arc.point(at) for p in pieces for at in (0.0, p.arc.end)]).reshape(-1, 2)


def _cut_at_ends(pieces: list[Piece]) -> list[Piece]:
    """Cut every curve where another one ends on it."""
    ends = _ends(pieces)
    ends = ends[np.unique(clusters(ends), return_index=True)[1]]
    cuts: dict[int, list[float]] = {}
    for n, piece in enumerate(pieces):
        low, high = piece.arc.box
        near = ends[np.all((ends > low - TOUCH) & (ends < high + TOUCH), axis=1)]
        cuts[n] = [at for p in near for at in _places_on(piece.arc, p)]
    return _cut(pieces, cuts)


def _places_on(arc: Arc, p: Array) -> list[float]:
    """Parameters at which a point lies on a curve."""
    line = arc.polyline
    reach = 2 * float(np.linalg.norm(np.diff(line, axis=0), axis=1).max())
    near = np.flatnonzero(np.linalg.norm(line - p, axis=1) < reach)
    found: list[float] = []
    for group in np.split(near, np.flatnonzero(np.diff(near) > 1) + 1) if len(near) else []:
        k = int(group[np.argmin(np.linalg.norm(line[group] - p, axis=1))])
        at, away = arc._polished(k / DENSE, p)
        if away < TOUCH:
            found.append(at)
    return found


def clusters(points: Array) -> Array:
    """A label for every point; points nearer than `TOUCH` share one."""
    from scipy.spatial import cKDTree  # not with `import sarrus`

    return connected(cKDTree(points).query_pairs(TOUCH, output_type="ndarray"), len(points))


def connected(pairs: Array, count: int) -> Array:
    """A label for each of so many things; those that are connected by pairs (k, 2) share one."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])


def _once(pieces: list[Piece]) -> list[Piece]:
    """Pieces that lie on each other become one, with all their owners."""
    labels = clusters(_ends(pieces)).reshape(-1, 2)
    groups: dict[tuple[int, int], list[Piece]] = {}
    for piece, (a, b) in zip(pieces, labels.tolist(), strict=True):
        group = groups.setdefault((min(a, b), max(a, b)), [])
        middle = piece.arc.point(0.5 * piece.arc.end)
        twin = next((other for other in group if other.arc.nearest(middle)[1] < TOUCH), None)
        if twin is None:
            group.append(piece)
        else:
            _take_over(twin, piece, middle)
    return [piece for group in groups.values() for piece in group]


def _take_over(twin: Piece, piece: Piece, middle: Array) -> None:
    at, _ = twin.arc.nearest(middle)
    same = float(twin.arc.slope(at) @ piece.arc.slope(0.5 * piece.arc.end)) > 0
    twin.owners += piece.owners if same else [(n, high, low) for n, low, high in piece.owners]


def _crossings(pieces: list[Piece]) -> dict[int, list[float]]:
    """Parameters at which pieces cross each other or themselves, from chords that meet or nearly do."""
    import shapely

    if not pieces:
        return {}
    lines = [piece.arc.polyline for piece in pieces]
    owner = np.repeat(np.arange(len(lines)), [len(line) - 1 for line in lines])
    place = np.concatenate([np.arange(len(line) - 1) for line in lines])
    chords = shapely.linestrings(np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines]))
    reach = NEARLY * shapely.length(chords)
    one, other = shapely.STRtree(chords).query(chords, predicate="dwithin", distance=reach)
    apart = (one < other) & ((owner[one] != owner[other]) | (other > one + 1))
    cuts: dict[int, list[float]] = {}
    for i, j in zip(one[apart], other[apart], strict=True):
        n, k = int(owner[i]), int(owner[j])
        found = _polish(pieces[n].arc, pieces[k].arc, (place[i] + 0.5) / DENSE, (place[j] + 0.5) / DENSE)
        if found is not None and not (n == k and abs(found[0] - found[1]) < 1e-6):
            cuts.setdefault(n, []).append(found[0])
            cuts.setdefault(k, []).append(found[1])
    return cuts


def _polish(one: Arc, other: Arc, a: float, b: float) -> tuple[float, float] | None:
    """Newton's method on one(a) = other(b); only true crossings away from the ends."""
    for _ in range(12):
        d, e = one.slope(a), other.slope(b)
        if _sine(d, e) < SLANT:
            return None
        step = np.linalg.solve(np.column_stack([d, -e]), other.point(b) - one.point(a))
        a, b = float(a + np.clip(step[0], -0.5, 0.5)), float(b + np.clip(step[1], -0.5, 0.5))
        if not (-0.2 < a < one.end + 0.2 and -0.2 < b < other.end + 0.2):
            return None
        a, b = min(max(a, 0.0), one.end), min(max(b, 0.0), other.end)
        if abs(step).max() < 1e-13:
            break
    meets = np.linalg.norm(one.point(a) - other.point(b)) <= 1e-10
    return (a, b) if meets and not _touches_at_end(one, other, a, b) else None


def _touches_at_end(one: Arc, other: Arc, a: float, b: float) -> bool:
    """Whether curves only seem to cross, beside a common end at which they touch."""
    p = one.point(a)
    away = min(_distance(arc.point(at), p) for arc in (one, other) for at in (0.0, arc.end))
    return away < 0.01 and _sine(one.slope(a), other.slope(b)) < SHARPEST * away


def _sine(d: Array, e: Array) -> float:
    """The sine of the angle between two directions, without its sign."""
    return abs(float(d[0] * e[1] - d[1] * e[0])) / max(float(np.linalg.norm(d) * np.linalg.norm(e)), 1e-300)


def _joined(pieces: list[Piece]) -> Division:
    """Nodes from the ends of all pieces; a piece that is no longer than a node is part of it."""
    ends = _ends(pieces)
    labels = clusters(ends)
    nodes = ends[np.unique(labels, return_index=True)[1]]
    for piece, (a, b) in zip(pieces, labels.reshape(-1, 2).tolist(), strict=True):
        piece.start, piece.end = a, b
    longer = [piece for piece in pieces if piece.start != piece.end or piece.arc.length > 2 * TOUCH]
    return Division(nodes, longer)


BESIDE = 0.05  # free of units: so far from a node the order of curves around it is looked at

Side = tuple[int, int]  # number of a piece; 0 runs along it, its left is meant; 1 runs against it


@dataclass(eq=False)
class Cell:
    """A connected part of the plane without curves in it; the unbounded one has no outer walk.

    `walks` are its boundaries with the cell on the left: the outer one first, then those of islands in it.
    """

    walks: list[list[Side]] = field(default_factory=list)
    area: float = 0.0
    bounded: bool = True


class Cells:
    """All cells, and which of them is on each side of every piece.

    Attributes
    ----------
    cells : the first one is the unbounded
    of : piece and direction -> number of the cell on its left
    """

    def __init__(self, division: Division) -> None:
        self.division = division
        walks = [(self._area(walk), walk) for walk in self._walks()]
        bounded = sorted(one for one in walks if one[0] > 0)
        self.cells = [Cell(bounded=False), *(Cell([walk], area) for area, walk in bounded)]
        outlines = [self._within([walk]) for _, walk in bounded]
        for area, walk in walks:
            if area <= 0:
                cell = self.cells[self._around(walk, outlines)]
                cell.walks.append(walk)
                cell.area += area
        self.of = {side: k for k, cell in enumerate(self.cells) for walk in cell.walks for side in walk}

    def _walks(self) -> list[list[Side]]:
        """Closed walks with one cell on the left: at the end of a piece, on along the next one clockwise."""
        following: dict[Side, Side] = {}
        for node, sides in self._leaving().items():
            around = self._sorted(node, sides)
            following |= {(n, 1 - way): around[k - 1] for k, (n, way) in enumerate(around)}
        walks: list[list[Side]] = []
        while following:
            side = min(following)
            walks.append([])
            while side in following:
                walks[-1].append(side)
                side = following.pop(side)
        return walks

    def _leaving(self) -> dict[int, list[Side]]:
        """The pieces that begin at each node."""
        leaving: dict[int, list[Side]] = {}
        for n, piece in enumerate(self.division.pieces):
            leaving.setdefault(piece.start, []).append((n, 0))
            leaving.setdefault(piece.end, []).append((n, 1))
        return leaving

    def _sorted(self, node: int, sides: list[Side]) -> list[Side]:
        """Pieces counter-clockwise, by directions so far from the node that tangential curves can be distinguished."""
        pieces, centre = self.division.pieces, self.division.nodes[node]
        radius = min(BESIDE, 0.3 * min(pieces[n].arc.length for n, _ in sides))
        return sorted(sides, key=lambda side: _angle_at(pieces[side[0]], side[1], centre, radius))

    def _area(self, walk: list[Side]) -> float:
        """Return the area by Green's formula along the pieces, and between their ends in the nodes."""
        along = sum((1 - 2 * way) * self.division.pieces[n].arc.area for n, way in walk)
        ends = np.array([self._line(side)[[0, -1]] for side in walk])
        first, last = np.roll(ends[:, 0], -1, axis=0), ends[:, 1]
        return float(along + 0.5 * np.sum(last[:, 0] * first[:, 1] - last[:, 1] * first[:, 0]))

    def _line(self, side: Side) -> Array:
        """The polyline of a piece, run through in a direction."""
        n, way = side
        return self.division.pieces[n].arc.fine[:: 1 - 2 * way]

    def _around(self, walk: list[Side], outlines: Sequence[Any]) -> int:
        """The smallest cell around an island, which may touch it: most of its points are inside."""
        import shapely

        mine = {n for n, _ in walk}
        points = np.concatenate([self.division.pieces[n].arc.polyline for n in sorted(mine)])
        for k, outline in enumerate(outlines, 1):
            apart = mine.isdisjoint(n for n, _ in self.cells[k].walks[0])
            if apart and 2 * np.count_nonzero(shapely.contains_xy(outline, points)) > len(points):
                return k
        return 0

    def locate(self, points: Array) -> Array:
        """The number of the cell of every point (n,)."""
        import shapely

        found = np.zeros(len(points), dtype=int)
        for k, cell in self._polygons.items():
            found[shapely.intersects_xy(cell, points)] = k
        return found

    @cached_property
    def _polygons(self) -> dict[int, Any]:
        """The bounded cells."""
        return {k: self._within(cell.walks) for k, cell in enumerate(self.cells) if cell.bounded}

    def _within(self, walks: list[list[Side]]) -> Any:
        outer, *islands = (np.concatenate([self._line(side) for side in walk]) for walk in walks)
        return polygon(outer, islands)

    def inner_point(self, k: int) -> Array | None:
        """A point well inside a cell; nothing, if it is too narrow."""
        import shapely

        cell = self._polygons[k]
        point = shapely.point_on_surface(cell)
        return shapely.get_coordinates(point)[0] if shapely.contains(cell, point) else None


def _angle_at(piece: Piece, way: int, centre: Array, radius: float) -> float:
    """The direction in which a piece leaves a node, where it is a small distance away."""
    arc = piece.arc
    low, high = (0.0, 0.5 * arc.end) if way == 0 else (arc.end, 0.5 * arc.end)
    for _ in range(40):
        middle = 0.5 * (low + high)
        if np.linalg.norm(arc.point(middle) - centre) < radius:
            low = middle
        else:
            high = middle
    away = arc.point(high) - centre
    return float(np.arctan2(away[1], away[0]))
