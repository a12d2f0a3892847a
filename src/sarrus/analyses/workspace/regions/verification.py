"""Tests of a map that do not use its curves; curves that they find missing are traced."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....linalg.threads import one_thread_if_small
from ....model.announcement import announce, reports_warnings
from ....results.maps.workspace import Verification, Workspace
from ....system import System
from ...progress import Progress
from ..problem.arguments import refuse_counts
from ..problem.formulation import formulate
from ..problem.random_positions import Samples
from ..problem.rows import Problem
from ..problem.settle import reach
from ..problem.watch import POINTS, stopped, watched
from ..tracing.starts import Ray, Start, can_change, changes_along
from .mapping import Asked, WorkspaceMap, map_of
from .region import Region

TOLERANCE = 1e-6  # free of units: farther outside, a position is outside
DEPTH = 1e-3  # of places just inside the boundary, free of units
INNER = 50  # such places along the whole boundary
WALK = 25  # positions of a random walk from each assembled one
ROUNDS = 4
DIRECTIONS = 6
SPREAD = 1009  # between the seeds of rounds
PART = 200  # random positions that are drawn by one worker


class Part(NamedTuple):
    """Random positions and rays that belong together."""

    seed: int
    samples: int
    rays: int


class Drawn(NamedTuple):
    """Admissible positions, the ends of rays, and where random walks crossed singular curves."""

    positions: list[Array]
    ends: list[Start]
    crossings: list[Start]


@reports_warnings
@one_thread_if_small
def checked_workspace(
    found: Workspace,
    samples: int = 2000,
    rays: int = 40,
    *,
    executor: Executor | None = None,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    strict: bool = False,
) -> Workspace:
    """Test a workspace by random positions, rays and inverse kinematics, and trace missing curves.

    Random admissible positions, from assemblies and random walks, must be inside; random rays must end on known curves;
    with two degrees of freedom, random walks must cross known singular curves only; points just inside the boundary
    must be reachable by inverse kinematics. A failed test leads to missing curves; they are traced, and all tests are
    repeated.

    Parameters
    ----------
    found : Workspace
    samples, rays : number of each; there are as many crossings as rays
    executor : any executor of `concurrent.futures`, on which they are drawn; the numbers are the same
    progress : True for a line on the terminal, or a function that is called with the number of points traced so far
    time_limit : seconds of the clock after which it ends with the status "time limit" and what was found
    strict : raise the first warning as a `StrictError`
    """
    map_ = map_of(found)
    refuse_counts(samples=samples, rays=rays)
    with watched(progress, done="traced", unit=POINTS, time_limit=time_limit):
        tests = tested(map_, samples, rays, executor)
    return reported(map_, tests)


def tested(map_: WorkspaceMap, samples: int, rays: int, executor: Executor | None) -> Verification | None:
    """Test a map and trace what was missed; the last tests that were finished."""
    tests: list[Verification] = []

    def work() -> None:
        known = len(map_.branches)
        for number in range(1, ROUNDS + 1):
            before = len(map_.branches)
            drawn = _drawn(map_, list(_parts(map_.seed + number, samples, rays)), executor)
            last = _round(map_, drawn)
            tests.append(replace(last, rounds=number, found_late=len(map_.branches) - known))
            if len(map_.branches) == before or map_.explorer.endless:
                break

    map_.stop = stopped(work)
    return tests[-1] if tests else None


def reported(map_: WorkspaceMap, tests: Verification | None = None) -> Workspace:
    """The result of a map; a warning is given if it is not complete."""
    found = map_.result(tests)
    announce([] if found.success else [f"{found.message}."])
    return found


def _round(map_: WorkspaceMap, drawn: Drawn) -> Verification:
    p, (positions, ends, crossings) = map_.problem, drawn
    outputs, region = p.m + p.outputs, map_.region()
    u = np.array([p.values(q)[outputs] for q in positions]).reshape(-1, 2)
    outside = np.flatnonzero(region.outside(u, TOLERANCE)) if len(u) else np.zeros(0, dtype=int)
    for n in outside[:20]:
        look_around(map_, positions[n])
    known, crossed = _known(map_, ends), _known(map_, crossings)
    inner, reached = _inner(map_, map_.region())
    return Verification(
        len(u),
        len(outside),
        len(ends),
        known,
        len(crossings),
        crossed,
        inner,
        reached,
        1,
        0,
        TOLERANCE * p.size,
    )


def _parts(seed: int, samples: int, rays: int) -> Iterator[Part]:
    """So many random positions and rays in parts that do not depend on how many workers there are."""
    count = max(1, -(-samples // PART))
    for k in range(count):
        share = [(k + 1) * whole // count - k * whole // count for whole in (samples, rays)]
        yield Part(SPREAD * seed + k, *share)


def _drawn(map_: WorkspaceMap, parts: Sequence[Part], executor: Executor | None) -> Drawn:
    if executor is None:
        found = [_draw(map_.problem, part) for part in parts]
    else:
        found = list(executor.map(_work, [map_.asked] * len(parts), parts))
    return Drawn(
        [q for one in found for q in one.positions],
        [end for one in found for end in one.ends],
        [start for one in found for start in one.crossings],
    )


def _work(asked: Asked, part: Part) -> Drawn:
    """A part in a worker, which makes its own system."""
    model, output, limits, fixed = asked
    return _draw(formulate(System(model), output, limits=limits, fixed=fixed), part)


def _draw(problem: Problem, part: Part) -> Drawn:
    """Random admissible positions, assembled and walked to, ends of rays in random directions, and crossings."""
    samples, random = Samples(problem, part.seed), np.random.default_rng(part.seed)
    positions: list[Array] = []
    crossings: list[Start] = []
    changing = can_change(problem)
    while len(positions) < part.samples and (q := next(samples, None)) is not None:
        walk = [q, *samples.walks(q, min(WALK, part.samples - len(positions) - 1))]
        positions += walk
        if changing:
            crossings += islice(changes_along(problem, walk), part.rays - len(crossings))
    ends = [_ray(problem, next(samples, None), random) for _ in range(part.rays)]
    return Drawn(positions, [end for end in ends if end is not None], crossings)


def _ray(problem: Problem, q: Array | None, random: np.random.Generator) -> Start | None:
    angle = random.uniform(0.0, 2 * np.pi)
    return None if q is None else Ray(problem, q, np.array([np.cos(angle), np.sin(angle)])).end()


def look_around(map_: WorkspaceMap, q: Array) -> None:
    """Rays from a position outside; if they find nothing new, its cell can be reached."""
    starts = [map_.ray(q) for _ in range(DIRECTIONS)]
    led = [map_.explorer.start(*start) for start in starts if start is not None]
    if "new" not in led:
        map_.met.append(q)
    for _ in map_.explorer:
        pass


def _known(map_: WorkspaceMap, ends: Sequence[Start]) -> int:
    """Return the number of ends of rays, or crossings, on known curves; the others are starts."""
    known = 0
    for end in ends:
        known += map_.explorer.start(*end) == "known"
        for _ in map_.explorer:
            pass
    return known


def _inner(map_: WorkspaceMap, region: Region) -> tuple[int, int]:
    """Places a little inside of the boundary, and how many are reached from positions that were met."""
    tried = reached = 0
    for k, at in _evenly(region):
        piece = region.division.pieces[k]
        slope = piece.arc.slope(at)
        if not slope.any():
            continue
        left = np.array([-slope[1], slope[0]]) / np.linalg.norm(slope)
        target = piece.arc.point(at) + DEPTH * left * (1 if region.can[region.sides[k, 0]] else -1)
        if region.can[region.cells.locate(target[None])[0]]:
            tried += 1
            reached += _is_reached(map_, target, _starts(map_, region, k))
    return tried, reached


def _is_reached(map_: WorkspaceMap, target: Array, near: Array) -> bool:
    """Whether inverse kinematics leads to a place from the nearest of some positions, or from any that was met.

    Around a void much smaller than the mechanism, all near positions are singular, and steps from them lead nowhere.
    """
    return any(
        reach(map_.problem, target, starts, tries, map_.random) is not None
        for starts, tries in ((near, 8), (np.array(map_.met), len(map_.met)))
    )


def _evenly(region: Region) -> Iterator[tuple[int, float]]:
    """Pieces of the boundary and parameters of their arcs: the middle of every piece, and more along long ones."""
    edges = np.flatnonzero(region.bounds).tolist()
    lengths = [region.division.pieces[k].arc.length for k in edges]
    whole = sum(lengths) or 1.0
    for k, length in zip(edges, lengths, strict=True):
        count = max(1, round(INNER * length / whole))
        for n in range(count):
            yield k, (n + 0.5) / count * region.division.pieces[k].arc.end


def _starts(map_: WorkspaceMap, region: Region, k: int) -> Array:
    """Positions to begin with: those of the piece's own curves, then those that were met."""
    n = map_.problem.n
    own = []
    for owner, _, low, high in region.division.pieces[k].owners:
        points = region.branches[owner].points
        own += [points[j].x[:n] for j in range(len(points)) if min(low, high) - 1 <= j <= max(low, high) + 1]
    return np.array([*own, *map_.met[:20]])
