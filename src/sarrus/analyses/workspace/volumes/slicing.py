"""Slices of a workspace of three outputs, each started from its neighbours' curves, here or on an executor."""

from __future__ import annotations

from bisect import bisect
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....model import Model
from ....results.maps.workspace_volume import Loop, Slice, Starts
from ....system import System
from ..problem.formulation import Limits, formulate
from ..problem.rows import Problem
from ..problem.settle import allowed, constrained, settle
from ..problem.watch import SLICES, expected, reached
from ..regions.mapping import REPEATS, ROUNDS, WorkspaceMap
from ..regions.region import Cause, Region
from ..tracing.starts import Start, onto
from ..tracing.stratum import Active, Stratum, apart
from ..tracing.vertex import balanced
from .shape_derivatives import area_rates

FAR, HALVINGS = 0.2, 3  # free of units: points of curves that move farther are carried in up to 8 parts
NEAREST = 8  # random positions, moved to a slice, from which it begins
NEARLY = 1e-3  # of the size of slices: so far their polylines may be from their curves
PER_TASK = 4  # slices that are handed to a worker at once
TRIES = (  # for a slice of which a curve was lost: shorter steps, and shifts as shares of the range
    (1.0, 0.0),
    (0.5, 0.0),
    (0.5, 1e-5),
    (0.5, -1e-5),
)


class Task(NamedTuple):
    """A slice that is to be made: its height, points of its neighbours' curves, random positions near it."""

    height: float
    starts: Starts
    positions: tuple[Array, ...]


class Job(NamedTuple):
    """Description of the slices for a worker: problem, initial height, range."""

    model: Model
    output: tuple[str, ...]
    limits: Limits | None
    fixed: Mapping[str, float]
    seed: int
    longest: float
    middle: float
    span: float
    derivatives: bool


class Slicer:
    """Slices by height; those that are known are stored.

    The numbers do not depend on the executor: every slice starts from the nearest ones that were known when it was
    asked for.

    Attributes
    ----------
    known : by height
    problem : of a slice

    Parameters
    ----------
    positions : random ones with their heights
    """

    def __init__(
        self,
        system: System,
        asked: Job,
        positions: Sequence[tuple[float, Array]],
        executor: Executor | None,
    ) -> None:
        self._asked, self._positions, self._executor = asked, positions, executor
        self.problem = _formulated(system, asked)
        self.known: dict[float, Slice] = {}
        self._remade = Counter[float]()

    def at(self, heights: Iterable[float]) -> list[Slice]:
        """Slices at some heights, in their order; between those that are known the middle ones are made first."""
        wanted = list(heights)
        new = sorted({height for height in wanted if height not in self.known})
        while missing := [height for height in new if height not in self.known]:
            self._map(_middles(missing, sorted(self.known)))
        self._map([height for height in new if not self.known[height].success])
        return [self.known[height] for height in wanted]

    def reconcile(self) -> bool:
        """Make slices again that leave out positions of a neighbour's boundary; whether there were any.

        Curves that a whole run of slices missed are so found from its ends. A slice began from the neighbours that were
        known when it was made; that leaves those that were made before a neighbour.
        """
        order = {height: n for n, height in enumerate(self.known)}
        good = sorted(height for height, one in self.known.items() if one.success)
        pairs = [sorted(pair, key=order.__getitem__) for pair in pairwise(good)]
        wrong = sorted({a for a, b in pairs if self._leaves_out(self.known[a], self.known[b])})
        for height in wrong:
            self._remade[height] += 1
            one = self.known.pop(height)  # the new one comes last in the order
            self.known[height] = replace(one, success=self._remade[height] <= ROUNDS)
        self._map([height for height in wrong if self.known[height].success])
        return bool(wrong)

    def _leaves_out(self, one: Slice, other: Slice) -> bool:
        problem = self.problem.held_at(_height_of(self.problem), one.height)
        outputs, units = problem.m + problem.outputs, problem.units[problem.outputs]
        size = max((float(np.ptp(loop.points)) for both in (one, other) for loop in both.loops), default=0.0)
        return any(
            not one.holds(problem.values(start.x[: problem.n])[outputs] * units, NEARLY * size)
            for start in _moved(problem, other.starts)
        )

    def _map(self, heights: Sequence[float]) -> None:
        """Make slices, or make them again, from those around them that are known and complete."""
        expected(len({*self.known, *heights}), SLICES)
        for one in self._made([Task(z, self._near(z), self._met(z)) for z in heights]):
            self.known[one.height] = one
            reached(len(self.known), SLICES)

    def _made(self, tasks: Sequence[Task]) -> Iterator[Slice]:
        if self._executor is None:
            yield from (_slice(self.problem, self._asked, task) for task in tasks)
            return
        parts = [tasks[k : k + PER_TASK] for k in range(0, len(tasks), PER_TASK)]
        for some in self._executor.map(_work, [self._asked] * len(parts), parts):
            yield from some

    def around(self, height: float) -> list[Slice]:
        """The nearest known slices on both sides."""
        return self._nearest(height, list(self.known))

    def _good_around(self, height: float) -> list[Slice]:
        return self._nearest(height, [h for h, one in self.known.items() if one.success])

    def _nearest(self, height: float, heights: Sequence[float]) -> list[Slice]:
        below = max((h for h in heights if h < height), default=None)
        above = min((h for h in heights if h > height), default=None)
        return [self.known[h] for h in (below, above) if h is not None]

    def _near(self, height: float) -> Starts:
        """Points of the curves of slices around, and of this one, if it is made again."""
        own = [self.known[height]] if height in self.known else []
        return tuple(start for one in [*self._good_around(height), *own] for start in one.starts)

    def _met(self, height: float) -> tuple[Array, ...]:
        """Random positions that are nearest by their heights."""
        order = sorted(self._positions, key=lambda one: abs(one[0] - height))
        return tuple(q for _, q in order[:NEAREST])


def _middles(missing: Sequence[float], known: Sequence[float]) -> list[float]:
    """Return the middle of the missing heights between each two known ones."""
    groups: dict[int, list[float]] = {}
    for height in missing:
        groups.setdefault(bisect(known, height), []).append(height)
    return [group[len(group) // 2] for group in groups.values()]


def _work(asked: Job, tasks: Sequence[Task]) -> list[Slice]:
    """Slices in a worker, which makes its own system."""
    problem = _formulated(System(asked.model), asked)
    return [_slice(problem, asked, task) for task in tasks]


def _formulated(system: System, asked: Job) -> Problem:
    fixed = {**asked.fixed, asked.output[2]: asked.middle}
    return formulate(system, asked.output[:2], limits=asked.limits, fixed=fixed)


def _slice(problem: Problem, asked: Job, task: Task) -> Slice:
    """A slice; where curves are lost, as close to a critical height, one that is a little higher or lower."""
    place = _height_of(problem)
    for n, (share, shift) in enumerate(TRIES):
        moved = shift * asked.span
        here = problem.held_at(place, task.height + moved)
        found = _mapped(here, asked.seed + n, asked.longest * share, task)
        if found.branches and found.is_closed:
            break
    return _as_slice(task.height, found, abs(moved), asked.derivatives)


def _mapped(problem: Problem, seed: int, longest: float, task: Task) -> WorkspaceMap:
    map_ = WorkspaceMap.of(problem, seed, 0 if task.starts else REPEATS, longest)
    moved = list(_moved(problem, task.starts))
    for start in moved:
        map_.explorer.start(*start)
        map_.explorer.run()
    for q in _settled(problem, task.positions):
        map_.begin_at(q)
        map_.explorer.run()
    map_.run()
    for _ in range(ROUNDS):
        if not (outside := [*map_.positions_outside(), *_left_out(map_, moved)]):
            break
        for q in outside:
            map_.look_around(q)
    return map_


def _left_out(map_: WorkspaceMap, starts: Sequence[Start]) -> list[Array]:
    """Positions on the boundary of neighbours, moved to this slice, that lie outside of it."""
    if not starts or not map_.branches:
        return []
    p, region = map_.problem, map_.region()
    u = np.array([p.values(start.x[: p.n])[p.m + p.outputs] for start in starts])
    outside = region.outside(u, NEARLY * float(np.ptp(u, axis=0).max()))
    return [starts[k].x[: p.n] for k in np.flatnonzero(outside).tolist()]


def _settled(problem: Problem, positions: Sequence[Array]) -> Iterator[Array]:
    """Admissible positions near others that are not in this slice."""
    rows, goal = constrained(problem)
    for q in positions:
        moved = settle(problem, q, rows, goal)
        if moved is not None and allowed(problem, moved) and problem.built(moved):
            yield moved


def _moved(problem: Problem, starts: Starts) -> Iterator[Start]:
    """Points of neighbours' curves and their corners, moved to this slice."""
    for key, x in starts:
        found = _corner(problem, key, x) if len(x) == problem.n else _on_curve(problem, key, x)
        if (
            found is not None
            and allowed(problem, found.x[: problem.n])
            and problem.built(found.x[: problem.n])
        ):
            yield found


def _on_curve(problem: Problem, key: Active, x: Array) -> Start | None:
    stratum = Stratum(problem, key)
    row = problem.m + problem.held.tolist().index(_height_of(problem))
    moved = _carried(stratum, x, row, HALVINGS)
    return None if moved is None else Start(key, moved)


def _height_of(problem: Problem) -> int:
    """The place of the function that a slice keeps."""
    return [k for k in problem.fixed if k not in problem.locked][-1]


def _carried(stratum: Stratum, x: Array, row: int, halvings: int) -> Array | None:
    """A point of a curve at the height of another slice, by way of heights in between where it is far."""
    there = onto(stratum, x)
    n, goal = stratum.n, stratum.goal
    if not halvings or (there is not None and apart(there[:n], x[:n]) < FAR):
        return there
    height = float(stratum.problem.values(x[:n])[stratum.rows[row]])
    stratum.goal = goal.copy()
    stratum.goal[row] = 0.5 * (height + goal[row])
    between = _carried(stratum, x, row, halvings - 1)
    stratum.goal = goal
    return there if between is None else _carried(stratum, between, row, halvings - 1)


def _corner(problem: Problem, key: Active, q: Array) -> Start | None:
    """A point at which two curves with a limit each meet, as one of the first."""
    whole = Stratum(problem, key)
    moved = settle(problem, q, whole.rows, whole.goal)
    if moved is None:
        return None
    one = Stratum(problem, key - {min(key)})
    return Start(one.key, balanced(one, moved))


def _as_slice(height: float, map_: WorkspaceMap, moved: float, derivatives: bool) -> Slice:
    if not map_.branches:
        return Slice(height, 0.0, 0.0, (), (), False)
    rates, kinked = area_rates(map_.problem, map_.region()) if derivatives else (None, 0.0)
    p, region = map_.problem, map_.region()
    units = p.units[p.outputs]
    area, perimeter = region.area * float(units.prod()), region.perimeter * float(units.max())
    starts = [(branch.stratum.key, branch.points[len(branch.points) // 2].x) for branch in map_.branches]
    starts += [(vertex.key, vertex.q) for vertex in map_.explorer.vertices if vertex.kind == "corner"]
    curves = region.curves([p.table[k].name for k in p.limited])
    barriers = tuple(curve.u for curve in curves if curve.kind == "barrier" and not curve.again)
    loops = tuple(_loops(region))
    error = region.area_error() * float(units.prod()) + moved * perimeter
    return Slice(height, area, error, loops, barriers, map_.is_closed, tuple(starts), rates, kinked)


def _loops(region: Region) -> Iterator[Loop]:
    units = region.problem.units[region.problem.outputs]
    for number, (_, _, loops) in enumerate(region.components()):
        for loop in loops:
            causes = tuple(_described(region.problem, cause) for cause in loop.causes)
            yield Loop(number, _signed_area(loop.line) < 0, loop.line * units, loop.corners, causes)


def _signed_area(line: Array) -> float:
    x, y = line.T
    return float(x[:-1] @ y[1:] - x[1:] @ y[:-1])


def _described(problem: Problem, causes: frozenset[Cause]) -> str:
    """Causes in words."""
    message = []
    for active, singular in causes:
        names = [
            f"{problem.table[problem.limited[i]].name} {('lowest', 'highest')[end]}" for i, end in active
        ]
        message.append(", ".join([*(["singularity"] if singular else []), *names]))
    return " or ".join(sorted(message))
