"""A closed surface of triangles through the boundaries of slices.

Between critical heights slices are of one kind: their loops are paired, corner by corner, and joined by bands. Across a
critical height loops lie on each other but for gaps: their points are shared, and the edges that are left over, which
are closed cycles, are filled by level triangles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results.maps.workspace_volume import Loop, Slice
from .patch import Sheet, fill

AROUND = 96  # points of every loop, nearly
LEAST = 3  # of a run between two corners
ON = 1e-3  # of the size: points that neighbouring slices share


class Surface(NamedTuple):
    """Vertices (nv, 3), triangles (nt, 3) seen counter-clockwise from outside, causes, and one for each triangle."""

    vertices: Array
    triangles: Array
    causes: tuple[str, ...]
    of: Array


@dataclass(eq=False)
class Ring:
    """A loop as numbers of vertices, with a parameter that counts its runs, and their causes."""

    numbers: list[int]
    at: list[float]
    causes: tuple[str, ...]

    def closed(self) -> list[tuple[int, float]]:
        """Numbers and parameters, the first once more at the end."""
        return [*zip(self.numbers, self.at, strict=True), (self.numbers[0], float(len(self.causes)))]


class Aligned(NamedTuple):
    """A loop cut at its corners, the runs in the order of the loop that it continues."""

    loop: Loop
    runs: list[Array]
    causes: tuple[str, ...]


def surface(groups: Sequence[Sequence[Sequence[Slice]]]) -> Surface:
    """The surface through slices, which are given for every range of heights, and there between critical heights."""
    sheet = Sheet()
    for runs in groups:
        _join(sheet, [usual for run in runs if (usual := _of_one_kind(run))])
    fill(sheet)
    triangles = np.array(sheet.triangles, dtype=int).reshape(-1, 3)
    vertices = np.array(sheet.vertices).reshape(-1, 3)
    return Surface(vertices, triangles, tuple(sheet.causes), np.array(sheet.of, dtype=int))


def _of_one_kind(run: Sequence[Slice]) -> list[Slice]:
    """Return the slices of the most frequent kind in a run."""
    kinds = [one.kind for one in run]
    usual = max(kinds, key=kinds.count, default=None)
    return [one for one in run if one.kind == usual and one.loops]


def _join(sheet: Sheet, runs: Sequence[Sequence[Slice]]) -> None:
    """Rings of all slices, shared across critical heights, and bands between them."""
    rings = [list(_rings(sheet, run)) for run in runs]
    size = max(
        (float(np.ptp(loop.points, axis=0).max()) for r in runs for one in r for loop in one.loops), default=0
    )
    for below, above in pairwise(rings):
        sheet.level += 1
        _share(sheet, below[-1], above[0], ON * size)
    for level in [rings[0][0], rings[-1][-1]] if rings else []:
        sheet.level += 1
        sheet.at_level([number for ring in level for number in ring.numbers])
    for run in rings:
        for lower, upper in pairwise(run):
            for a, b in zip(lower, upper, strict=True):
                _band(sheet, a, b)


def _rings(sheet: Sheet, run: Sequence[Slice]) -> Iterator[list[Ring]]:
    """The rings of a run's slices, each in the place of the one it continues."""
    loops = [_cut(loop) for loop in run[0].loops]
    slices = [loops]
    for one in run[1:]:
        loops = _continued(loops, one.loops)
        slices.append(loops)
    counts = [_counts(loop.runs) for loop in slices[len(slices) // 2]]
    for one, loops in zip(run, slices, strict=True):
        yield [_ring(sheet, loop, count, one.height) for loop, count in zip(loops, counts, strict=True)]


def _cut(loop: Loop, first: int = 0) -> Aligned:
    """A loop cut at its corners, beginning with one of them."""
    line = loop.points
    if not loop.corners:
        return Aligned(loop, [line], loop.causes)
    order = [*loop.corners[first:], *loop.corners[:first]]
    ends = [*order[1:], order[0]]
    runs = [
        line[a : b + 1] if b > a else np.concatenate([line[a:-1], line[: b + 1]])
        for a, b in zip(order, ends, strict=True)
    ]
    return Aligned(loop, runs, loop.causes[first:] + loop.causes[:first])


def _continued(before: Sequence[Aligned], loops: Sequence[Loop]) -> list[Aligned]:
    """Loops in the places of the loops that they continue: of the same kind, near and alike, each once."""
    costs = sorted(
        (_unlike(old.loop, new), m, n)
        for m, old in enumerate(before)
        for n, new in enumerate(loops)
        if old.loop.kind == new.kind
    )
    place: dict[int, int] = {}
    for _, m, n in costs:
        if m not in place and n not in place.values():
            place[m] = n
    return [_turned(old, loops[place[m]]) for m, old in enumerate(before)]


def _unlike(a: Loop, b: Loop) -> float:
    (low_a, high_a), (low_b, high_b) = ((loop.points.min(axis=0), loop.points.max(axis=0)) for loop in (a, b))
    return float(np.linalg.norm(low_a - low_b) + np.linalg.norm(high_a - high_b))


def _turned(old: Aligned, loop: Loop) -> Aligned:
    """A loop beginning where the old one does."""
    if not loop.corners:
        line = loop.points[:-1]
        k = int(np.argmin(np.linalg.norm(_centred(line) - _centred(old.runs[0][:-1])[0], axis=1)))
        return Aligned(loop, [np.concatenate([line[k:], line[: k + 1]])], loop.causes)
    ways = [_cut(loop, first) for first in range(len(loop.corners))]
    same = [way for way in ways if way.causes == old.causes]
    starts = np.array([run[0] for run in old.runs])
    return min(same, key=lambda way: float(np.linalg.norm(np.array([run[0] for run in way.runs]) - starts)))


def _centred(line: Array) -> Array:
    """Points about the middle of their box."""
    return np.asarray(line - 0.5 * (line.min(axis=0) + line.max(axis=0)))


def _counts(runs: Sequence[Array]) -> list[int]:
    """Return the number of points of each run."""
    lengths = [_along(run)[-1] for run in runs]
    return [max(LEAST, round(AROUND * length / max(sum(lengths), 1e-300))) for length in lengths]


def _along(line: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def _ring(sheet: Sheet, loop: Aligned, counts: Sequence[int], height: float) -> Ring:
    """A loop as new vertices at equal distances in every run."""
    numbers, at = [], []
    for r, (run, count) in enumerate(zip(loop.runs, counts, strict=True)):
        along = _along(run)
        places = np.linspace(0.0, along[-1], count, endpoint=False)
        points = np.stack([np.interp(places, along, column) for column in run.T], axis=1)
        numbers += [sheet.point(p, height) for p in points]
        at += [r + j / count for j in range(count)]
    return Ring(numbers, at, loop.causes)


def _share(sheet: Sheet, below: Sequence[Ring], above: Sequence[Ring], near: float) -> None:
    """Points of rings that lie on the others' become points of these, too."""
    into_below, into_above = _places(sheet, below, above, near), _places(sheet, above, below, near)
    for rings, into in ((below, into_below), (above, into_above)):
        for ring, places in zip(rings, into, strict=True):
            both = sorted([*zip(ring.at, ring.numbers, strict=True), *places])
            ring.at, ring.numbers = [at for at, _ in both], [number for _, number in both]
    for ring in (*below, *above):
        sheet.at_level(ring.numbers)


def _places(
    sheet: Sheet, rings: Sequence[Ring], others: Sequence[Ring], near: float
) -> list[list[tuple[float, int]]]:
    """For each ring the parameters at which vertices of other rings lie on it, with their numbers."""
    found: list[list[tuple[float, int]]] = [[] for _ in rings]
    lines = [
        (sheet.plane([n for n, _ in ring.closed()]), np.array([at for _, at in ring.closed()]))
        for ring in rings
    ]
    for number in (number for ring in others for number in ring.numbers):
        p = sheet.plane([number])[0]
        nearest = [(*_nearest(line, at, p), k) for k, (line, at) in enumerate(lines)]
        away, place, k = min(nearest, default=(np.inf, 0.0, 0))
        if away < near:
            found[k].append((place, number))
    return found


def _nearest(line: Array, at: Array, p: Array) -> tuple[float, float]:
    """Distance of a point from a polyline, and the parameter of the nearest place, inside of a segment."""
    d = np.diff(line, axis=0)
    share = ((p - line[:-1]) * d).sum(axis=1) / np.maximum((d * d).sum(axis=1), 1e-300)
    share = np.clip(share, 1e-9, 1 - 1e-9)
    away = np.linalg.norm(line[:-1] + share[:, None] * d - p, axis=1)
    k = int(np.argmin(away))
    return float(away[k]), float(at[k] + share[k] * (at[k + 1] - at[k]))


def _band(sheet: Sheet, below: Ring, above: Ring) -> None:
    """Triangles between two rings, advancing on the one whose next point comes first."""
    a, b = below.closed(), above.closed()
    i = j = 0
    while i < len(a) - 1 or j < len(b) - 1:
        first = i < len(a) - 1 and (j == len(b) - 1 or a[i + 1][1] <= b[j + 1][1])
        start = a[i][1] if first else b[j][1]
        cause = below.causes[min(int(start), len(below.causes) - 1)]
        if first:
            sheet.add(a[i][0], a[i + 1][0], b[j][0], cause)
            i += 1
        else:
            sheet.add(a[i][0], b[j + 1][0], b[j][0], cause)
            j += 1
