"""Cells of a division of the plane: their boundaries, areas and nesting."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ....algebra import Array
from ....results.maps.outline import polygon
from .arrangement import Division, Piece

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
        self._around = self._orders()
        walks = self._walks()
        areas = [self._area(walk) for walk in walks]
        self.cells = [Cell(bounded=False)]
        outer = [n for n, area in enumerate(areas) if area > 0]
        self.cells += [Cell([walks[n]], areas[n]) for n in outer]
        for n, walk in enumerate(walks):
            if areas[n] <= 0:
                self._put_into(walk, areas[n], [walks[k] for k in outer], [areas[k] for k in outer])
        self.of = {side: k for k, cell in enumerate(self.cells) for walk in cell.walks for side in walk}

    def _orders(self) -> dict[int, list[Side]]:
        """Outgoing pieces around every node, counter-clockwise."""
        leaving: dict[int, list[Side]] = {}
        for n, piece in enumerate(self.division.pieces):
            leaving.setdefault(piece.start, []).append((n, 0))
            leaving.setdefault(piece.end, []).append((n, 1))
        return {node: self._sorted(node, sides) for node, sides in leaving.items()}

    def _sorted(self, node: int, sides: list[Side]) -> list[Side]:
        """Directions at a distance at which tangential curves can be distinguished in spite of the node's size."""
        pieces, centre = self.division.pieces, self.division.nodes[node]
        radius = min(BESIDE, 0.3 * min(pieces[n].arc.length for n, _ in sides))
        return sorted(sides, key=lambda side: _angle_at(pieces[side[0]], side[1], centre, radius))

    def _walks(self) -> list[list[Side]]:
        open_sides = {side for sides in self._around.values() for side in sides}
        walks = []
        for side in sorted(open_sides):
            if side in open_sides:
                walk = self._walk(side)
                open_sides.difference_update(walk)
                walks.append(walk)
        return walks

    def _walk(self, first: Side) -> list[Side]:
        walk, side = [first], self._next(first)
        while side != first:
            walk.append(side)
            side = self._next(side)
        return walk

    def _next(self, side: Side) -> Side:
        """At the end of a piece, the next one clockwise from where it came."""
        n, way = side
        piece = self.division.pieces[n]
        around = self._around[piece.start if way else piece.end]
        back = around.index((n, 1 - way))
        return around[back - 1]

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

    def _put_into(self, walk: list[Side], area: float, outer: list[list[Side]], areas: list[float]) -> None:
        """An island belongs to the smallest cell around it; it may touch that, so that most of its points count."""
        import shapely

        mine = {n for n, _ in walk}
        points = np.concatenate([self.division.pieces[n].arc.polyline for n in sorted(mine)])
        around = [
            (areas[k], k)
            for k, other in enumerate(outer)
            if not mine & {n for n, _ in other}
            and 2 * np.count_nonzero(shapely.contains_xy(self._within([other]), points)) > len(points)
        ]
        cell = self.cells[1 + min(around)[1]] if around else self.cells[0]
        cell.walks.append(walk)
        cell.area += area

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
