"""Workspaces of three outputs by slices: each slice starts from the curves of its neighbour."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Executor
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model import Model, SarrusError
from ...results.workspace_volume import Slice, WorkspaceVolume
from ...system import System
from .extremes import workspace_range
from .formulate import Limits, formulate
from .loft import loft
from .mapping import WorkspaceMap
from .measures import measures
from .newton import Tally
from .problem import Problem
from .seeds import Start, onto
from .settle import allowed
from .stratum import Stratum

FIRST_REPEATS, REPEATS = (
    20,
    5,
)  # starts in a row without news: of the first slice of a chain, of those that follow
RANGE_REPEATS = 10  # of the third output's range
HALVED = 3  # by how much more a trapezoidal sum errs with twice the step, less 1, where areas have kinks
PER_TASK = 6  # slices that are handed to a worker at once


class _Task(NamedTuple):
    """Neighbouring slices for one worker."""

    model: Model
    output: tuple[Any, ...]
    limits: Any
    fixed: Mapping[Any, float]
    heights: tuple[float, ...]
    seed: int


def workspace_volume(
    system: System,
    output: Iterable[Any],
    *,
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    between: tuple[float, float] | None = None,
    slices: int = 32,
    executor: Executor | None = None,
    seed: int = 0,
) -> WorkspaceVolume:
    """Map what three outputs can reach, by slices at values of the third that are denser towards its ends.

    The volume is the integral of the slices' areas over z = mid - half·cos(theta) by the trapezoidal rule; its error is
    estimated from every other slice.

    Parameters
    ----------
    system, limits, fixed, seed : see `sarrus.workspace`
    output : three functions of the position
    between : lowest and highest value of the third output; by default all that it can reach
    slices : how many intervals of theta, an even number
    executor : any executor of `concurrent.futures`, to which parts of the slices are handed

    Returns
    -------
    WorkspaceVolume

    Raises
    ------
    SarrusError
        If there are not three outputs, or the mechanism cannot be assembled within its limits.
    """
    names = tuple(output)
    if len(names) != 3:
        raise SarrusError(f"a volume is of three outputs, not {len(names)}; name as many")
    if slices < 4 or slices % 2:
        raise SarrusError(f"slices must be an even number of at least 4, but is {slices}; choose another")
    reach = workspace_range(system, names[2], limits=limits, fixed=fixed, seed=seed, repeats=RANGE_REPEATS)
    ranges = tuple(_cut(reach.intervals, between))
    found, volume, coarse = list[Slice](), 0.0, 0.0
    for low, high in ranges:
        theta = np.arange(1, slices) * np.pi / slices
        heights = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(theta)
        task = _Task(system.model, names, limits, fixed or {}, tuple(heights.tolist()), seed)
        mine = _mapped(system, task, executor)
        parts = np.array([one.area for one in mine]) * np.sin(theta) * 0.5 * (high - low) * np.pi / slices
        volume, coarse = volume + float(parts.sum()), coarse + 2 * float(parts[1::2].sum())
        found += mine
    vertices, triangles = loft(found)
    lost = sum(not one.success for one in found)
    told = f"{lost} of {len(found)} slices are incomplete" if lost else "All slices are complete"
    status: Any = "incomplete" if lost or not found else "mapped"
    labels: Any = tuple(one.name for one in measures(system, names))
    error = abs(volume - coarse) / HALVED
    return WorkspaceVolume(
        system.name, labels, ranges, tuple(found), volume, error, vertices, triangles, status, told
    )


def _cut(
    intervals: Iterable[tuple[float, float]], between: tuple[float, float] | None
) -> Iterator[tuple[float, float]]:
    for low, high in intervals:
        if between is not None:
            low, high = max(low, between[0]), min(high, between[1])
        if high > low:
            yield low, high


def _mapped(system: System, task: _Task, executor: Executor | None) -> list[Slice]:
    """All slices by rising height; chains go from the middle outwards, where slices become small."""
    middle = len(task.heights) // 2
    halves = (task.heights[middle - 1 :: -1], task.heights[middle:])
    if executor is None:
        found = [list(_chain(system, task._replace(heights=half))) for half in halves]
    else:
        chains = [half[k : k + PER_TASK] for half in halves for k in range(0, len(half), PER_TASK)]
        found = list(executor.map(_work, [task._replace(heights=chain) for chain in chains]))
    return sorted((one for part in found for one in part), key=lambda one: one.height)


def _work(task: _Task) -> list[Slice]:
    """A task in a worker, which makes its own system."""
    return list(_chain(System(task.model), task))


def _chain(system: System, task: _Task) -> Iterator[Slice]:
    """Neighbouring slices, each from the curves of the one before."""
    third = task.output[2]
    fixed = {**task.fixed, third: task.heights[0]}
    problem = formulate(system, task.output[:2], limits=task.limits, fixed=fixed)
    place = [k for k in problem.fixed if k not in problem.locked][-1]
    before: WorkspaceMap | None = None
    for height in task.heights:
        here = problem.held_at(place, height)
        before = _slice(here, before, task.seed)
        yield _as_slice(height, before)


def _slice(problem: Problem, before: WorkspaceMap | None, seed: int) -> WorkspaceMap:
    map_ = WorkspaceMap.of(problem, seed, REPEATS if before and before.branches else FIRST_REPEATS)
    for start in _starts(problem, before):
        map_.explorer.start(*start)
        for _ in map_.explorer:
            pass
    return map_.run()


def _starts(problem: Problem, before: WorkspaceMap | None) -> Iterator[Start]:
    """Points of the neighbour's curves, moved to this slice."""
    for branch in before.branches if before else ():
        x: Array = branch.points[len(branch.points) // 2].x
        moved = onto(Stratum(problem, branch.stratum.key), x, Tally())
        if moved is not None and allowed(problem, moved[: problem.n]) and problem.built(moved[: problem.n]):
            yield Start(branch.stratum.key, moved)


def _as_slice(height: float, map_: WorkspaceMap) -> Slice:
    if not map_.branches:
        return Slice(height, 0.0, 0.0, (), not map_.met)
    found = map_.result()
    parts = tuple(part.loops for part in found.components)
    return Slice(height, found.area, found.area_error, parts, map_.is_closed)
