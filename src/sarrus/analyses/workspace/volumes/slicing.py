"""Slices of a workspace of three outputs, each started from its neighbours' curves, here or on an executor."""

from __future__ import annotations

from bisect import bisect, bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import chain, pairwise, repeat
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....model import Model
from ....results.maps.workspace import beyond, inside
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
from .extremes import limit_names
from .shape_derivatives import area_rates

FAR, HALVINGS = 0.2, 3  # free of units: points of curves that move farther are carried in up to 8 parts
NEAREST = 8  # random positions, moved to a slice, from which it begins
NEARLY = 1e-3  # of the size of slices: so far their polylines may be from their curves
PER_TASK = 4  # slices that are handed to a worker at once
# For a slice of which a curve was lost: shorter steps, and shifts as shares of the range
TRIES = ((1.0, 0.0), (0.5, 0.0), (0.5, 1e-5), (0.5, -1e-5))


class Task(NamedTuple):
    """A slice that is to be made: its height, points of its neighbours' curves, random positions near it."""

    height: float
    starts: Starts
    positions: tuple[Array, ...]


class Job(NamedTuple):
    """Description of the slices for a worker: the problem of one of them, with its height as the last fixed value."""

    model: Model
    output: Sequence[Any]
    limits: Limits | None
    fixed: Mapping[Any, float]
    seed: int
    longest: float
    derivatives: bool
    span: float = 1.0

    def problem(self, system: System | None = None) -> Problem:
        """The problem of a slice; a worker makes its own system."""
        return formulate(system or System(self.model), self.output, limits=self.limits, fixed=self.fixed)


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
        problem: Problem,
        job: Job,
        positions: Sequence[tuple[float, Array]],
        executor: Executor | None,
    ) -> None:
        self.problem, self._job, self._positions, self._executor = problem, job, positions, executor
        self.known: dict[float, Slice] = {}
        self._remade = Counter[float]()

    def at(self, heights: Iterable[float]) -> list[Slice]:
        """Slices at some heights, in their order; between those that are known the middle ones are made first."""
        wanted = list(heights)
        new = sorted({*wanted} - self.known.keys())
        while missing := [height for height in new if height not in self.known]:
            self._map(_middles(missing, sorted(self.known)))
        self._map([height for height in new if not self.known[height].success])
        return [self.known[height] for height in wanted]

    def reconcile(self) -> bool:
        """Make slices again that leave out positions of a neighbour's boundary; whether there were any.

        Curves that a whole run of slices missed are so found from its ends. A slice began from the neighbours that were
        known when it was made; that leaves those that were made before a neighbour.
        """
        order = list(self.known)
        good = sorted(height for height, one in self.known.items() if one.success)
        pairs = [sorted(pair, key=order.index) for pair in pairwise(good)]
        wrong = {one for one, other in pairs if self._differ(one, other)}
        for height in wrong:
            self._remade[height] += 1
            one = self.known.pop(height)  # the new one comes last in the order
            self.known[height] = replace(one, success=self._remade[height] <= ROUNDS)
        self._map(sorted(height for height in wrong if self.known[height].success))
        return bool(wrong)

    def _differ(self, height: float, other: float) -> bool:
        """Whether a slice leaves out positions of another one's boundary."""
        problem = self.problem.held_at(_height_of(self.problem), height)
        moved = list(_moved(problem, self.known[other].starts))
        return bool(_left_out(problem, self.known[height].loops, moved))

    def around(self, height: float) -> list[Slice]:
        """The nearest complete slices on both sides."""
        good = sorted(z for z, one in self.known.items() if one.success)
        below, above = bisect_left(good, height), bisect(good, height)
        return [self.known[z] for z in (*good[max(below - 1, 0) : below], *good[above : above + 1])]

    def _map(self, heights: Sequence[float]) -> None:
        """Make slices, or make them again, from those around them that are known and complete."""
        expected(len({*self.known, *heights}), SLICES)
        tasks = [self._task(height) for height in heights]
        parts = [tasks[k : k + PER_TASK] for k in range(0, len(tasks), PER_TASK)]
        if self._executor is None:
            made: Iterable[Slice] = (_slice(self.problem, self._job, task) for task in tasks)
        else:
            made = chain.from_iterable(self._executor.map(_work, repeat(self._job), parts))
        for one in made:
            self.known[one.height] = one
            reached(len(self.known), SLICES)

    def _task(self, height: float) -> Task:
        """A slice from points of the curves around, of itself if it is made again, and the nearest random positions."""
        known = [*self.around(height), *([self.known[height]] if height in self.known else [])]
        near = sorted(self._positions, key=lambda one: abs(one[0] - height))[:NEAREST]
        return Task(height, tuple(start for one in known for start in one.starts), tuple(q for _, q in near))


def _middles(missing: Sequence[float], known: Sequence[float]) -> list[float]:
    """Return the middle of the missing heights between each two known ones."""
    groups: dict[int, list[float]] = {}
    for height in missing:
        groups.setdefault(bisect(known, height), []).append(height)
    return [group[len(group) // 2] for group in groups.values()]


def _work(job: Job, tasks: Sequence[Task]) -> list[Slice]:
    problem = job.problem()
    return [_slice(problem, job, task) for task in tasks]


def _slice(problem: Problem, job: Job, task: Task) -> Slice:
    """A slice; where curves are lost, as close to a critical height, one that is a little higher or lower."""
    place = _height_of(problem)
    for n, (share, shift) in enumerate(TRIES):
        moved = shift * job.span
        here = problem.held_at(place, task.height + moved)
        found = _mapped(here, job.seed + n, job.longest * share, task)
        if found.branches and found.is_closed:
            break
    return _as_slice(task.height, found, abs(moved), job.derivatives)


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
        if not (outside := [*map_.positions_outside(), *_left_out(problem, _loops(map_.region()), moved)]):
            break
        for q in outside:
            map_.look_around(q)
    return map_


def _left_out(problem: Problem, loops: Iterable[Loop], starts: Sequence[Start]) -> list[Array]:
    """Positions on the boundary of neighbours, moved to this slice, that lie outside of its loops."""
    positions = [start.x[: problem.n] for start in starts]
    u = np.array([problem.values(q)[problem.m + problem.outputs] for q in positions]).reshape(-1, 2)
    outside = outside_of(loops, u * problem.units[problem.outputs])
    return [q for q, out in zip(positions, outside, strict=True) if out]


def outside_of(loops: Iterable[Loop], points: Array) -> Array:
    """Which points (k, 2) are outside of loops by more than `NEARLY` of their size (k,)."""
    lines = [loop.points for loop in loops]
    size = max((float(np.ptp(line)) for line in lines), default=0.0)
    return np.asarray(~inside(lines, points) & beyond(lines, points, NEARLY * size))


def _settled(problem: Problem, positions: Sequence[Array]) -> Iterator[Array]:
    """Admissible positions near others that are not in this slice."""
    rows, goal = constrained(problem)
    for q in positions:
        moved = settle(problem, q, rows, goal)
        if moved is not None and _admissible(problem, moved):
            yield moved


def _moved(problem: Problem, starts: Starts) -> Iterator[Start]:
    """Points of neighbours' curves and their corners, moved to this slice."""
    for key, x in starts:
        found = _corner(problem, key, x) if len(x) == problem.n else _on_curve(problem, key, x)
        if found is not None and _admissible(problem, found.x[: problem.n]):
            yield found


def _admissible(problem: Problem, q: Array) -> bool:
    return allowed(problem, q) and problem.built(q)


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
    p, region = map_.problem, map_.region()
    units = p.units[p.outputs]
    error = region.area_error() * float(units.prod()) + moved * region.perimeter * float(units.max())
    areas = region.area * float(units.prod()), error
    starts = [(branch.stratum.key, branch.points[len(branch.points) // 2].x) for branch in map_.branches]
    starts += [(vertex.key, vertex.q) for vertex in map_.explorer.vertices if vertex.kind == "corner"]
    curves = region.curves([p.table[k].name for k in p.limited])
    barriers = tuple(curve.u for curve in curves if curve.kind == "barrier" and not curve.again)
    rates = area_rates(region) if derivatives else (None, 0.0)
    return Slice(height, *areas, tuple(_loops(region)), barriers, map_.is_closed, tuple(starts), *rates)


def _loops(region: Region) -> Iterator[Loop]:
    import shapely  # not with `import sarrus`

    p = region.problem
    for number, (_, _, loops) in enumerate(region.components()):
        for loop in loops:
            causes = tuple(" or ".join(sorted(_cause(p, one) for one in causes)) for causes in loop.causes)
            hole = not shapely.LinearRing(loop.line).is_ccw
            yield Loop(number, hole, loop.line * p.units[p.outputs], loop.corners, causes)


def _cause(problem: Problem, cause: Cause) -> str:
    """Active limits, and whether the mechanism is singular, in words."""
    active, singular = cause
    return ", ".join([*(["singularity"] if singular else []), *limit_names(problem, active)])
