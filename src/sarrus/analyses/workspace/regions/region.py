"""From traced curves to a region: the plane divided, its cells labelled, and what each curve is."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results.maps.workspace import BoundaryCurve, Component, CurveKind, beyond
from ..problem.rows import Problem
from ..tracing.explore import Branch
from ..tracing.point import Step
from ..tracing.stratum import SAME
from .arc import Arc
from .arrangement import TOUCH, Cells, Division, Owner, connected, divide
from .crossing import Crossing, labels, leftward

CORNER = 0.02  # rad between tangents of pieces that do not go on smoothly

Cause = tuple[
    tuple[tuple[int, int], ...], bool
]  # limits that are active; whether the mechanism is singular, too


class Loop(NamedTuple):
    """A closed part of the boundary: points, where runs of one cause begin, their causes, and the curve."""

    line: Array
    corners: tuple[int, ...]
    causes: tuple[frozenset[Cause], ...]
    pieces: Array


class _Edge(NamedTuple):
    """A piece of the boundary, run through with the region on its left."""

    arc: Arc
    start: int
    end: int
    causes: frozenset[Cause]


class Region:
    """Region that two outputs can reach, without units.

    Attributes
    ----------
    division, cells : of the plane
    can : which cells can be reached
    sides : the cells on the left and on the right of each piece; `reached` the one of them that can be reached
    bounds : which pieces are the boundary
    """

    def __init__(
        self,
        problem: Problem,
        branches: Sequence[Branch],
        crossings: Sequence[Crossing],
        met: Array,
        seed: int,
        search: bool,
    ) -> None:
        self.problem, self.branches, self.crossings, self._met = problem, branches, crossings, met
        arcs = [Arc(np.array([step.quintic() for step in branch.steps()])) for branch in branches]
        self.division: Division = divide(arcs)
        self.cells = Cells(self.division)
        self.can = labels(problem, branches, crossings, self.cells, met, seed, search)
        pieces = range(len(self.division.pieces))
        self.sides = np.array(
            [(self.cells.of[k, 0], self.cells.of[k, 1]) for k in pieces], dtype=int
        ).reshape(-1, 2)
        left, right = self.sides.T
        self.bounds = self.can[left] != self.can[right]
        self.reached = np.where(self.can[left], left, right)

    @property
    def is_consistent(self) -> bool:
        """Whether no curve claims that the unbounded cell can be reached, and areas and known positions agree."""
        areas = np.array([cell.area for cell in self.cells.cells[1:]])
        return not self.can[0] and bool(np.all(areas > -TOUCH)) and not self.positions_outside

    @cached_property
    def positions_outside(self) -> list[Array]:
        """Known admissible positions that lie outside."""
        outputs = self.problem.m + self.problem.outputs
        u = np.array([self.problem.values(q)[outputs] for q in self._met]).reshape(-1, 2)
        return [self._met[k] for k in np.flatnonzero(self.outside(u, SAME))] if len(u) else []

    @property
    def area(self) -> float:
        """The area of all reachable cells."""
        return float(sum(cell.area for cell, can in zip(self.cells.cells, self.can, strict=True) if can))

    @property
    def perimeter(self) -> float:
        """The length of the boundary of the reachable region."""
        return float(sum(self.division.pieces[k].arc.length for k in np.flatnonzero(self.bounds)))

    def area_error(self) -> float:
        """The error of the area by interpolation of the curves of the boundary."""
        owners = {n for k in np.flatnonzero(self.bounds) for n, *_ in self.division.pieces[k].owners}
        return sum(_error(self.branches[n]) for n in owners)

    def components(self) -> list[tuple[float, float, list[Loop]]]:
        """Area, perimeter and loops of the parts that hang together, the largest first."""
        inside = ~self.bounds & self.can[self.reached]
        group = connected(self.sides[inside], len(self.can))
        found = []
        for label in np.unique(group[self.can]):
            area = sum(self.cells.cells[k].area for k in np.flatnonzero(self.can & (group == label)))
            edges = np.flatnonzero(self.bounds & (group[self.reached] == label)).tolist()
            length = sum(self.division.pieces[k].arc.length for k in edges)
            found.append((area, length, self._loops(edges)))
        return sorted(found, key=lambda one: -one[0])

    def _loops(self, edges: list[int]) -> list[Loop]:
        """Boundary pieces joined to closed loops, the region on their left, the longest first."""
        leaving: dict[int, list[_Edge]] = {}
        for k in edges:
            edge = self._edge(k)
            leaving.setdefault(edge.start, []).append(edge)
        loops = []
        while any(leaving.values()):
            loops.append(_loop(leaving, next(n for n, edges in leaving.items() if edges)))
        return sorted(loops, key=lambda loop: len(loop.line), reverse=True)

    def _edge(self, k: int) -> _Edge:
        piece, causes = self.division.pieces[k], self._causes(k)
        if self.can[self.sides[k, 0]]:
            return _Edge(piece.arc, piece.start, piece.end, causes)
        return _Edge(piece.arc.reversed(), piece.end, piece.start, causes)

    def _causes(self, k: int) -> frozenset[Cause]:
        """Return the causes of a piece of the boundary: active limits, and whether it is a singularity."""
        owners = {n for n, *_ in self.division.pieces[k].owners}
        decisive = {n for n in owners if self.crossings[n].side} or owners
        strata = [self.branches[n].stratum for n in decisive]
        return frozenset((stratum.active, stratum.dimension > 1) for stratum in strata)

    def kind_of(self, k: int, owner: int) -> CurveKind:
        """Return the kind of a curve along a piece."""
        if self.crossings[owner].side == 0:
            return "crossable"
        if not self.bounds[k]:
            return "barrier"
        beyond_it = self.sides[k].sum() - self.reached[k]
        return "void" if self.cells.cells[beyond_it].bounded else "outer"

    def outside(self, points: Array, tolerance: float) -> Array:
        """Return the points (k, 2) that are outside by more than a tolerance (k,)."""
        found = ~self.can[self.cells.locate(points)]
        lines = [self.division.pieces[k].arc.fine for k in np.flatnonzero(self.bounds)]
        found[found] = beyond(lines, points[found], tolerance)
        return found

    def curves(self, names: Sequence[str]) -> list[BoundaryCurve]:
        """All parts of all curves with what they are; names are those of the limits."""
        found = []
        for k, piece in enumerate(self.division.pieces):
            for number, owner in enumerate(piece.owners):
                kind = self.kind_of(k, owner[0])
                again = any(self.kind_of(k, other) == kind for other, *_ in piece.owners[:number])
                found.append(self._curve(k, owner, kind, again, names))
        return found

    def _curve(
        self, k: int, owner: Owner, kind: CurveKind, again: bool, names: Sequence[str]
    ) -> BoundaryCurve:
        p, branch, piece = self.problem, self.branches[owner[0]], self.division.pieces[k]
        units, line = p.units[p.outputs], piece.arc.polyline
        inward = (self.crossings[owner[0]].side or 1) * leftward(branch, piece, owner)
        low, high = sorted(owner[1:])
        inner = [point for j, point in enumerate(branch.points) if low - 1e-9 <= j <= high + 1e-9]
        points = inner or [branch.points[round(0.5 * (low + high))]]
        active = tuple(f"{names[i]} {('lowest', 'highest')[end]}" for i, end in branch.stratum.active)
        return BoundaryCurve(
            kind,
            line * units,
            _normals(line, units) * (1.0 if inward > 0 else -1.0),
            np.array([point.x[: p.n] * p.scale for point in points]),
            np.array([point.u * units for point in points]),
            active,
            branch.stratum.dimension > 1,
            Arc(piece.arc.pieces * units).length,
            owner[0],
            again,
        )


def _normals(line: Array, units: Array) -> Array:
    """Unit normals to the left of a polyline, in real units."""
    d = np.gradient(line * units, axis=0)
    left = np.stack([-d[:, 1], d[:, 0]], axis=1)
    return np.asarray(left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-300))


def _loop(leaving: dict[int, list[_Edge]], node: int) -> Loop:
    """Edges walked along from a node until it is met again; runs of one cause without a corner are one."""
    edges: list[_Edge] = []
    while leaving.get(node):
        edges.append(leaving[node].pop())
        node = edges[-1].end
    lines = [edge.arc.polyline for edge in edges]
    places = np.cumsum([0, *(len(line) - 1 for line in lines)]).tolist()
    new = [n for n, edge in enumerate(edges) if not _goes_on(edges[n - 1], edge)]
    line = np.concatenate([*(line[:-1] for line in lines), lines[0][:1]])
    pieces = np.concatenate([edge.arc.pieces for edge in edges])
    return Loop(line, tuple(places[n] for n in new), tuple(edges[n].causes for n in new or [0]), pieces)


def _goes_on(before: _Edge, after: _Edge) -> bool:
    a, b = before.arc.slope(before.arc.end), after.arc.slope(0.0)
    sizes = float(np.linalg.norm(a) * np.linalg.norm(b))
    return before.causes == after.causes and (sizes == 0 or float(a @ b) > np.cos(CORNER) * sizes)


def _error(branch: Branch) -> float:
    """The area between a branch and its interpolation: what every other point less changes, by Richardson's rule.

    A step of length h makes an error of h⁷ in area; a curve of one step is compared with a cubic.
    """
    points, total = branch.points, 0.0
    last = len(points) - 3
    for k in {*range(0, last, 2), last} if last >= 0 else ():
        halves = [Step(points[n], points[n + 1]) for n in (k, k + 1)]
        fine = sum(step.length**7 for step in halves)
        if all(step.length for step in halves):  # a start that is a corner has none
            change = _area(*halves) - _area(Step(points[k], points[k + 2]))
            total += abs(change) * fine / (sum(step.length for step in halves) ** 7 - fine)
    if last < 0:
        step = Step(points[0], points[1])
        cubic = step.cubic(step.a.u, step.a.u_s, step.b.u, step.b.u_s)
        total = abs(_area(step) - Arc(np.pad(cubic, ((0, 2), (0, 0)))[None]).area) / (2**6 - 1)
    return total


def _area(*steps: Step) -> float:
    return Arc(np.array([step.quintic() for step in steps])).area


def measured(length: float, units: Array) -> float:
    """A length in the plane of the outputs in real units; nan where these differ, so that it has none."""
    return length * float(units[0]) if units[0] == units[1] else np.nan


def component_of(part: tuple[float, float, list[Loop]], units: Array, known: bool) -> Component:
    """A component in real units; its measures are nan unless the map is complete."""
    area, perimeter, loops = part
    return Component(
        area * float(units.prod()) if known else np.nan,
        measured(perimeter, units) if known else np.nan,
        tuple(loop.line * units for loop in loops),
        tuple(loop.pieces * units for loop in loops),
    )
