"""The workspace of a system, in one call."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...results.maps.workspace import Verification, Workspace
from ...system import System
from ..arguments import refuse_for_positions
from ..progress import Progress
from .problem.formulation import Limits, formulate
from .problem.random_positions import Samples
from .problem.rows import Problem
from .problem.watch import POINTS, stopped, watched
from .regions.mapping import REPEATS, ROUNDS, Asked, WorkspaceMap, map_of
from .tracing.curve import LONGEST
from .tracing.starts import Ray, Start, can_change, changes_along
from .tracing.stratum import SAME


@reports_warnings
@one_thread_if_small
def workspace(
    system: System,
    output: Iterable[Any],
    *,
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    verify: bool = True,
    samples: int = 1000,
    rays: int = 30,
    seed: int = 0,
    repeats: int = REPEATS,
    longest: float = LONGEST,
    executor: Executor | None = None,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
) -> Workspace:
    """Compute the workspace of two outputs: boundary, voids, barriers and crossable curves.

    Candidates for the boundary are positions at which the gradients of the outputs depend on those of the constraints
    and of the limits that are reached: Φ_qᵀ lam + ... + Uᵀ c = 0. They are traced as curves by pseudo-arclength
    continuation with exact derivatives up to the third, from random starts and from rays. Second-order terms on both
    sides of a curve determine its kind; see the guide to workspaces.

    Parameters
    ----------
    system : System
        Drivers are ignored; redundant equations are allowed.
    output : two functions of the position
        Names (``"slider.x"``, ``"pin.angle"``, ``"platform.rotation_z"``) or functions of the model
        (``tool.point(1, 0, 0)["x", "y"]``, `sarrus.Rotation`).
    limits : function -> (lowest, highest) [m] or [rad], None for no limit
        Joint coordinates by name, and also `sarrus.Length` of legs that are not modelled. ``"model"`` takes those of
        a robot description.
    fixed : function -> constant value, such as an orientation, also as a text, "30 deg"
    verify : whether the map is tested by random positions and rays
    samples, rays : number of positions and rays in these tests
    seed : of all random numbers
    repeats : number of consecutive starts without a new curve after which the map is complete
    longest : longest step along curves, without units; smaller values give more points
    executor : any executor of `concurrent.futures`, on which positions and rays of the tests are drawn
    progress : True for a line on the terminal, or a function that is called with the number of points traced so far
    time_limit : seconds of the clock after which it ends with the status "time limit" and what was found

    Returns
    -------
    Workspace
        Printed, it is a summary with the reliability of the result.

    Raises
    ------
    SarrusError
        If a name is unknown or the mechanism cannot be assembled within its limits.
    """
    refuse_for_positions(system, "workspace")
    found = WorkspaceMap(
        system, output, limits=limits, fixed=fixed, seed=seed, repeats=repeats, longest=longest
    )
    with watched(progress, done="traced", unit=POINTS, time_limit=time_limit):
        found.tried()
        sound = found.stop is None and not found.explorer.endless
        tests = tested(found, samples, rays, executor) if verify and sound else None
    return reported(found, tests)


PART = 200  # random positions that are drawn by one worker


class Part(NamedTuple):
    """Random positions and rays that belong together, with the numbers that seed them."""

    seed: tuple[int, int]
    samples: int
    rays: int


class Draw(NamedTuple):
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
) -> Workspace:
    """Test a workspace by random positions and rays, and trace missing curves.

    Random admissible positions, from assemblies and random walks, must be inside; random rays must end on known curves;
    with two degrees of freedom, random walks must cross known singular curves only. A failed test leads to missing
    curves; they are traced, and all tests are repeated.

    Parameters
    ----------
    found : Workspace
    samples, rays : number of each; there are as many crossings as rays
    executor : any executor of `concurrent.futures`, on which they are drawn; the numbers are the same
    progress : True for a line on the terminal, or a function that is called with the number of points traced so far
    time_limit : seconds of the clock after which it ends with the status "time limit" and what was found
    """
    map_ = map_of(found)
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


def _round(map_: WorkspaceMap, drawn: Draw) -> Verification:
    p, (positions, ends, crossings) = map_.problem, drawn
    outputs, region = p.m + p.outputs, map_.region()
    u = np.array([p.values(q)[outputs] for q in positions]).reshape(-1, 2)
    outside = np.flatnonzero(region.outside(u, SAME)) if len(u) else np.zeros(0, dtype=int)
    for n in outside[:20]:
        map_.look_around(positions[n])
    known, crossed = _known(map_, ends), _known(map_, crossings)
    return Verification(len(u), len(outside), len(ends), known, len(crossings), crossed, 1, 0, SAME * p.size)


def _parts(seed: int, samples: int, rays: int) -> Iterator[Part]:
    """So many random positions and rays in parts that do not depend on how many workers there are."""
    count = max(1, -(-samples // PART))
    for k in range(count):
        share = [(k + 1) * whole // count - k * whole // count for whole in (samples, rays)]
        yield Part((seed, k), *share)


def _drawn(map_: WorkspaceMap, parts: Sequence[Part], executor: Executor | None) -> Draw:
    if executor is None:
        found = [_draw(map_.problem, part) for part in parts]
    else:
        found = list(executor.map(_work, [map_.asked] * len(parts), parts))
    return Draw(
        [q for one in found for q in one.positions],
        [end for one in found for end in one.ends],
        [start for one in found for start in one.crossings],
    )


def _work(asked: Asked, part: Part) -> Draw:
    """A part in a worker, which makes its own system."""
    model, output, limits, fixed = asked
    return _draw(formulate(System(model), output, limits=limits, fixed=fixed), part)


def _draw(problem: Problem, part: Part) -> Draw:
    """Random admissible positions, assembled and walked to, ends of rays in random directions, and crossings."""
    samples, random = Samples(problem, part.seed), np.random.default_rng(part.seed)
    positions: list[Array] = []
    crossings: list[Start] = []
    changing = can_change(problem)
    for walk in samples.walks(part.samples):
        positions += walk
        if changing:
            crossings += islice(changes_along(problem, walk), part.rays - len(crossings))
    ends = [_ray(problem, next(samples, None), random) for _ in range(part.rays)]
    return Draw(positions, [end for end in ends if end is not None], crossings)


def _ray(problem: Problem, q: Array | None, random: np.random.Generator) -> Start | None:
    angle = random.uniform(0.0, 2 * np.pi)
    return None if q is None else Ray(problem, q, np.array([np.cos(angle), np.sin(angle)])).end()


def _known(map_: WorkspaceMap, ends: Sequence[Start]) -> int:
    """Return the number of ends of rays, or crossings, on known curves; the others are starts."""
    known = 0
    for end in ends:
        known += map_.explorer.start(*end) == "known"
        map_.explorer.run()
    return known
