"""Workspaces of three outputs: the integral of slices' areas between critical heights."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np

from ....algebra import Array
from ....linalg.threads import one_thread_if_small
from ....model import SarrusError
from ....model.announcement import announce, collecting, reports_warnings
from ....results.maps.workspace import Status
from ....results.maps.workspace_volume import Slice, WorkspaceRange, WorkspaceVolume
from ....system import System
from ...arguments import refuse_for_positions
from ...progress import Progress
from ..problem.arguments import functions
from ..problem.formulation import Limits, formulate, refuse_dependent
from ..problem.random_positions import Samples
from ..problem.rows import Problem
from ..problem.watch import SLICES, Stop, stopped, watched
from ..tracing.curve import LONGEST
from .extremes import search_of, workspace_range
from .quadrature import FIRST, Integral
from .slicing import NEARLY, Job, Slicer, outside_of
from .surface_from_slices import surface

Heights = tuple[float, float]  # lowest and highest
WALK = 5  # positions of a random walk from each assembled one


@reports_warnings
@one_thread_if_small
def workspace_volume(
    system: System,
    output: Iterable[Any],
    *,
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    between: Heights | None = None,
    rtol: float = 1e-4,
    most: int = 600,
    samples: int = 150,
    executor: Executor | None = None,
    seed: int = 0,
    longest: float = LONGEST,
    derivatives: bool = False,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
) -> WorkspaceVolume:
    """Compute the workspace of three outputs from slices at values of the third.

    First, critical heights are computed, at which the third output is stationary. Between them, the area is a function
    of theta, with z = mid - half·cos(theta), that is smooth also if it ends like a square root. It is integrated by
    Clenshaw-Curtis quadrature, with twice as many slices, or in two parts, where half as many miss the most, until the
    error is small enough.

    Parameters
    ----------
    system, limits, fixed, seed, longest : see `sarrus.workspace`
    output : three functions of the position
    between : lowest and highest value of the third output; by default its whole range
    rtol : error of the volume, relative
    most : largest number of slices; the remaining error is reported
    samples : number of random admissible positions, which must be inside; slices also start from them. The error does
        not include parts of the volume in which none of them is
    executor : an executor of `concurrent.futures` that computes the slices; the results are the same
    derivatives : whether to compute data for `volume_gradient`, by more slices
    progress : True for a line on the terminal, or a function that is called with the number of slices so far
    time_limit : seconds of the clock after which it ends with the status "time limit", the slices made so far
        and a coarse volume from them

    Returns
    -------
    WorkspaceVolume

    Raises
    ------
    SarrusError
        If there are not three outputs, rtol is not positive, `between` does not increase, or the mechanism cannot be
        assembled within its limits.
    """
    refuse_for_positions(system, "workspace_volume")
    names = functions(output)
    _refuse(names, rtol, between)
    problem = formulate(system, names, limits=limits, fixed=fixed)
    refuse_dependent(problem)
    volume = _Volume(
        problem, Job(system.model, names, limits, fixed or {}, seed, longest, derivatives), between
    )
    with watched(progress, done="made", unit=SLICES, time_limit=time_limit):
        stop = stopped(lambda: volume.integrate(rtol, most, samples, executor))
    found = volume.result(stop)
    announce(_shortcomings(found, rtol))
    return found


def _refuse(names: tuple[Any, ...], rtol: float, between: Heights | None) -> None:
    if len(names) != 3:
        raise SarrusError(f"output: a volume has three outputs, got {len(names)}. Name three.")
    if not 0 < rtol < np.inf:
        raise SarrusError(f"rtol: must be positive, got {rtol:g}. Pass e.g. 1e-4.")
    rises = between is None or (np.shape(between) == (2,) and -np.inf <= between[0] < between[1] <= np.inf)
    if not rises:
        message = "Give the lower value first, e.g. (0.0, 1.0)"
        raise SarrusError(f"between: must be two values that rise, got {between!r}. {message}.")


def _shortcomings(found: WorkspaceVolume, rtol: float) -> Iterator[str]:
    """Return the messages about a volume that is incomplete or inaccurate."""
    if not found.success:
        given = "is a coarse one" if np.isfinite(found.volume) else "is not given"
        yield f"{found.name}: the map is incomplete and its volume {given}. {found.message}."
    elif found.volume_error > rtol * found.volume:
        message = f"{found.name}: the volume's error is {found.volume_error:.1g}, more than rtol = {rtol:g} asks for"
        yield f"{message}. Allow more slices (most)."


class _Volume:
    """The steps to a volume; what was found when they end early is given, too."""

    def __init__(self, problem: Problem, job: Job, between: Heights | None) -> None:
        self.problem, self.job, self.between = problem, job, between or (-np.inf, np.inf)
        self.reach: WorkspaceRange | None = None
        self.ranges: tuple[Heights, ...] = ()
        self.integral: Integral | None = None
        self.outside = self.tested = 0

    def integrate(self, rtol: float, most: int, samples: int, executor: Executor | None) -> None:
        """The range of heights, slices and their integral, random positions."""
        problem, job = self.problem, self.job
        height = job.output[2]
        with collecting():
            reach = workspace_range(problem.system, height, limits=job.limits, fixed=job.fixed, seed=job.seed)
        (lowest, highest), self.reach = self.between, reach
        cut = [(max(low, lowest), min(high, highest)) for low, high in reach.intervals]
        self.ranges = tuple((low, high) for low, high in cut if low < high)
        if search_of(reach).stop:
            return
        middle = float(np.mean(self.ranges[0])) if self.ranges else 0.0
        span = max((high - low for low, high in self.ranges), default=1.0)
        job = job._replace(output=job.output[:2], fixed={**job.fixed, height: middle}, span=span)
        positions = [q for walk in Samples(problem, job.seed).walks(samples, WALK) for q in walk]
        u = np.array([problem.values(q)[problem.m + problem.outputs] for q in positions]).reshape(-1, 3)
        u *= problem.units[problem.outputs]
        standing = [(one.value, one.q / search_of(reach).problem.scale) for one in reach.critical]
        known = [*zip(u[:, 2].tolist(), positions, strict=True), *standing]
        slicer = Slicer(job.problem(problem.system), job, known, executor)
        expected = sorted({one.value for one in reach.critical})
        first = 4 * FIRST if job.derivatives else FIRST
        self.integral = Integral(slicer, self.ranges, expected, rtol, most, first)
        self.integral.run()
        self.outside, self.tested = positions_outside(u, slicer, self.ranges, self.between), len(u)

    def result(self, stop: Stop | None) -> WorkspaceVolume:
        """Return the result; a coarse volume if it ended early."""
        p, integral = self.problem, self.integral
        stop = stop or (search_of(self.reach).stop if self.reach else None)
        found = sorted(integral.slicer.known.values(), key=lambda one: one.height) if integral else []
        status, message = self._status(found, stop)
        estimated = integral is not None and np.isfinite(integral.error) and (stop or status == "mapped")
        whole = integral if integral and len(integral.rates) and not stop else None
        first, second, third = (p.table[k] for k in p.outputs)
        return WorkspaceVolume(
            p.system.name,
            (first.title, second.title, third.title),
            self.ranges,
            tuple(integral.critical) if integral else (),
            tuple(found),
            integral.value if integral and estimated else np.nan,
            integral.error if integral and estimated else np.nan,
            *surface([one for one in found if one.success], self.ranges),
            status,
            message,
            p.system.model,
            whole.derivatives(self.reach) if whole and self.reach else None,
            (first.unit, second.unit, third.unit),
        )

    def _status(self, found: Sequence[Slice], stop: Stop | None) -> tuple[Status, str]:
        if stop:
            return stop.status, f"{stop.reason[0].upper()}{stop.reason[1:]}; {len(found)} slices were made"
        lost = sum(not one.success for one in found)
        message = f"{lost} of {len(found)} slices are incomplete" if lost else "All slices are complete"
        if not found:
            heights = (
                "between these heights" if np.any(np.isfinite(self.between)) else "over a range of heights"
            )
            message = f"Nothing can be reached {heights}"
        known = self.reach is not None and self.reach.success
        third = self.problem.table[self.problem.outputs[2]].title
        message += "" if known else f", and the range of {third} is not"
        message += f"; {self.outside} of {self.tested} random admissible positions are outside"
        return "mapped" if known and not lost and not self.outside else "incomplete", message


def positions_outside(u: Array, slicer: Slicer, ranges: Sequence[Heights], between: Heights) -> int:
    """Number of admissible positions at heights that seemed out of reach, or outside of slices around and at theirs.

    Parameters
    ----------
    u : (n, 3) outputs
    ranges : of heights that can be reached
    between : lowest and highest value of the third output that is asked for
    """
    near = NEARLY * max((high - low for low, high in ranges), default=1.0)
    outside, doubtful = 0, list[Array]()
    for place in u[(between[0] < u[:, 2]) & (u[:, 2] < between[1])]:
        if not any(low < place[2] < high for low, high in ranges):
            outside += not any(low - near < place[2] < high + near for low, high in ranges)
        elif not any(one.holds(place[:2]) for one in slicer.around(place[2])):
            doubtful.append(place)
    own = slicer.at(place[2] for place in doubtful)
    missed = [outside_of(one.loops, place[None, :2]).any() for one, place in zip(own, doubtful, strict=True)]
    return outside + int(sum(missed))
