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
from ..problem.arguments import functions, measures
from ..problem.formulation import Limits, formulate, refuse_dependent
from ..problem.random_positions import Samples
from ..problem.watch import SLICES, Stop, check, stopped, watched
from ..tracing.curve import LONGEST
from .extremes import search_of, workspace_range
from .quadrature import FIRST, Integral
from .slicing import NEARLY, Job, Slicer
from .surface_from_slices import surface

WALK = 5  # positions of a random walk from each assembled one


@reports_warnings
@one_thread_if_small
def workspace_volume(
    system: System,
    output: Iterable[Any],
    *,
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    between: tuple[float, float] | None = None,
    rtol: float = 1e-4,
    most: int = 600,
    samples: int = 150,
    executor: Executor | None = None,
    seed: int = 0,
    longest: float = LONGEST,
    derivatives: bool = False,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    strict: bool = False,
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
    strict : raise the first warning as a `StrictError`

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
    refuse_dependent(formulate(system, names, limits=limits, fixed=fixed))
    search = _Search(system, names, limits, fixed, between, seed)
    with watched(progress, done="made", unit=SLICES, time_limit=time_limit):
        stop = stopped(lambda: search.run(rtol, most, samples, executor, longest, derivatives))
    found = search.result(stop, derivatives)
    announce(_shortcomings(found, rtol))
    return found


def _refuse(names: tuple[Any, ...], rtol: float, between: tuple[float, float] | None) -> None:
    if len(names) != 3:
        raise SarrusError(f"output: a volume has three outputs, got {len(names)}. Name three.")
    if not 0 < rtol < np.inf:
        raise SarrusError(f"rtol: must be positive, got {rtol:g}. Pass e.g. 1e-4.")
    if between is not None and np.shape(between) != (2,):
        raise SarrusError(f"between must be a pair (lowest, highest), got {between!r}. Pass e.g. (0.0, 1.0).")
    if between is not None and not -np.inf <= between[0] < between[1] <= np.inf:
        raise SarrusError(
            f"between: must rise, got {between[0]:g} to {between[1]:g}. Give the lower value first."
        )


def _shortcomings(found: WorkspaceVolume, rtol: float) -> Iterator[str]:
    """Return the messages about a volume that is incomplete or inaccurate."""
    if not found.success:
        given = "is a coarse one" if np.isfinite(found.volume) else "is not given"
        yield f"{found.name}: the map is incomplete and its volume {given}. {found.message}."
    elif found.volume_error > rtol * found.volume:
        message = f"{found.name}: the volume's error is {found.volume_error:.1g}, more than rtol = {rtol:g} asks for"
        yield f"{message}. Allow more slices (most)."


class _Search:
    """The steps to a volume; what was found when they end early is given, too."""

    def __init__(
        self,
        system: System,
        names: tuple[Any, ...],
        limits: Limits | None,
        fixed: Mapping[Any, float] | None,
        between: tuple[float, float] | None,
        seed: int,
    ) -> None:
        self.system, self.names, self.limits, self.fixed = system, names, limits, fixed
        self.between, self.seed = between, seed
        self.reach: WorkspaceRange | None = None
        self.integral: Integral | None = None
        self.outside = self.tested = 0

    def run(
        self,
        rtol: float,
        most: int,
        samples: int,
        executor: Executor | None,
        longest: float,
        derivatives: bool,
    ) -> None:
        """The range of heights, slices and their integral, random positions."""
        system, names, limits, fixed, seed = self.system, self.names, self.limits, self.fixed, self.seed
        with collecting():
            reach = workspace_range(system, names[2], limits=limits, fixed=fixed, seed=seed)
        self.reach = reach
        check()
        ranges = self.ranges
        middle = 0.5 * (ranges[0][0] + ranges[0][1]) if ranges else 0.0
        span = max((high - low for low, high in ranges), default=1.0)
        asked = Job(system.model, names, limits, fixed or {}, seed, longest, middle, span, derivatives)
        positions = list(_positions(system, asked, samples))
        standing = [(one.value, one.q / search_of(reach).problem.scale) for one in reach.critical]
        slicer = Slicer(system, asked, [(z, q) for _, z, q in positions] + standing, executor)
        expected = sorted({one.value for one in reach.critical})
        first = 4 * FIRST if derivatives else FIRST
        self.integral = Integral(slicer, ranges, expected, rtol, most, first)
        self.integral.run()
        missed = _missed(positions, reach.intervals, self.between, NEARLY * span)
        self.outside, self.tested = _outside(slicer, positions, ranges) + missed, len(positions)

    @property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """The requested ranges of the third output."""
        return tuple(_cut(self.reach.intervals, self.between)) if self.reach else ()

    def result(self, stop: Stop | None, derivatives: bool) -> WorkspaceVolume:
        """Return the result; volume and surface only if it is complete."""
        integral = self.integral
        found = sorted(integral.slicer.known.values(), key=lambda one: one.height) if integral else []
        status, message = self._status(found, stop)
        whole = integral if integral and not stop else None
        value, error = (np.nan, np.nan)
        if integral and (stop or status == "mapped"):
            value, error = integral.value, integral.error
            value = value if np.isfinite(error) else np.nan
        first, second, third = measures(self.system, self.names)
        return WorkspaceVolume(
            self.system.name,
            (first.title, second.title, third.title),
            self.ranges,
            tuple(integral.critical) if integral else (),
            tuple(found),
            value,
            error,
            *surface([one for one in found if one.success], self.ranges),
            status,
            message,
            self.system.model,
            whole.derivatives(self.reach) if whole and self.reach and len(whole.rates) else None,
            (first.unit, second.unit, third.unit),
        )

    def _status(self, found: Sequence[Slice], stop: Stop | None) -> tuple[Status, str]:
        if stop:
            return stop.status, f"{stop.reason[0].upper()}{stop.reason[1:]}; {len(found)} slices were made"
        lost = sum(not one.success for one in found)
        message = f"{lost} of {len(found)} slices are incomplete" if lost else "All slices are complete"
        if not found:
            heights = "between these heights" if self.between else "over a range of heights"
            message = f"Nothing can be reached {heights}"
        known = self.reach is not None and self.reach.success
        message += (
            "" if known else f", and the range of {self.reach.output if self.reach else self.names[2]} is not"
        )
        message += f"; {self.outside} of {self.tested} random admissible positions are outside"
        return "mapped" if known and not lost and not self.outside else "incomplete", message


def _positions(system: System, asked: Job, count: int) -> Iterator[tuple[Array, float, Array]]:
    """Random admissible positions: the first two outputs, the third one, and the scaled coordinates."""
    problem = formulate(system, asked.output, limits=asked.limits, fixed=asked.fixed)
    outputs, units, samples = (
        problem.m + problem.outputs,
        problem.units[problem.outputs],
        Samples(problem, asked.seed),
    )
    while count > 0 and (q := next(samples, None)) is not None:
        for there in (q, *samples.walks(q, min(WALK, count) - 1)):
            u = problem.values(there)[outputs] * units
            yield u[:2], float(u[2]), there
            count -= 1


def _outside(
    slicer: Slicer, positions: Iterable[tuple[Array, float, Array]], ranges: Iterable[tuple[float, float]]
) -> int:
    """Return the number of positions outside of the slices above, below and at their height."""
    doubtful = [
        (u, z)
        for u, z, _ in positions
        if any(low < z < high for low, high in ranges) and not any(one.holds(u) for one in slicer.around(z))
    ]
    own = slicer.at(z for _, z in doubtful)
    size = max((float(np.ptp(loop.points)) for one in own for loop in one.loops), default=0.0)
    return sum(not one.holds(u, NEARLY * size) for (u, _), one in zip(doubtful, own, strict=True))


def _missed(
    positions: Iterable[tuple[Array, float, Array]],
    intervals: Iterable[tuple[float, float]],
    between: tuple[float, float] | None,
    near: float,
) -> int:
    """Return the number of positions at heights that seemed out of reach."""
    lowest, highest = between or (-np.inf, np.inf)
    can = [(low - near, high + near) for low, high in intervals]
    heights = [z for _, z, _ in positions if lowest < z < highest]
    return sum(not any(low < z < high for low, high in can) for z in heights)


def _cut(
    intervals: Iterable[tuple[float, float]], between: tuple[float, float] | None
) -> Iterator[tuple[float, float]]:
    for low, high in intervals:
        if between is not None:
            low, high = max(low, between[0]), min(high, between[1])
        if high > low:
            yield low, high
