"""Workspaces of three outputs: the integral of slices' areas between critical heights, where their kind changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Executor
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import SarrusError, reports_warnings
from ...results.workspace_volume import WorkspaceVolume
from ...system import System
from ..misuse import refuse_other_system
from ..threads import one_thread_if_small
from .extremes import workspace_range
from .formulate import Limits, formulate
from .loft import loft
from .measures import measures
from .quadrature import NEAR, Integral
from .sample import Samples
from .slicing import Asked, Slicer
from .trace import LONGEST

NEARLY = 1e-3  # of the size of slices: so far their polylines may be from their curves
WALK = 5  # positions of a random walk from each assembled one
RANGE_REPEATS = 20  # starts in a row without news: of the third output's range


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
    strict: bool = False,
) -> WorkspaceVolume:
    """Map what three outputs can reach, by slices at values of the third.

    Slices change their kind at critical heights: a loop appears, another limit or singularity takes part in the
    boundary. These are found first. In between the area is a smooth function of theta, z = mid - half·cos(theta), also
    where it ends like a root; it is integrated by the rule of Clenshaw and Curtis with twice as many slices each time,
    until the error is small enough.

    Parameters
    ----------
    system, limits, fixed, seed, longest : see `sarrus.workspace`
    output : three functions of the position
    between : lowest and highest value of the third output; by default all that it can reach
    rtol : error of the volume, relative
    most : slices; no more are made, and the error that is left is told
    samples : random admissible positions, which must lie inside
    executor : any executor of `concurrent.futures`, to which slices are handed; the numbers are the same
    derivatives : whether `volume_gradient` will be asked for; slices take a fifth longer
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    WorkspaceVolume

    Raises
    ------
    SarrusError
        If there are not three outputs, rtol is not positive, `between` does not rise, or the mechanism cannot be
        assembled within its limits.
    """
    refuse_other_system(system, "workspace_volume")
    names = tuple(output)
    if len(names) != 3:
        raise SarrusError(f"a volume is of three outputs, not {len(names)}; name as many")
    if not rtol > 0:
        raise SarrusError(f"rtol must be positive, but is {rtol:g}; choose another, such as 1e-4")
    if between is not None and not between[0] < between[1]:
        raise SarrusError(
            f"between must rise, but is {between[0]:g} to {between[1]:g}; give the lower value first"
        )
    reach = workspace_range(system, names[2], limits=limits, fixed=fixed, seed=seed, repeats=RANGE_REPEATS)
    ranges = tuple(_cut(reach.intervals, between))
    middle = 0.5 * (ranges[0][0] + ranges[0][1]) if ranges else 0.0
    span = max((high - low for low, high in ranges), default=1.0)
    asked = Asked(system.model, names, limits, fixed or {}, seed, longest, middle, span, derivatives)
    positions = list(_positions(system, asked, samples))
    standing = [(one.value, one.q / reach.search.problem.scale) for one in reach.critical]
    slicer = Slicer(system, asked, [(z, q) for _, z, q in positions] + standing, executor)
    expected = sorted({one.value for one in reach.critical})
    integral = Integral(slicer, ranges, expected, rtol, most)
    integral.run()
    outside = _outside(slicer, positions, ranges) + _missed(positions, reach.intervals, between, NEAR * span)
    found = sorted(slicer.known.values(), key=lambda one: one.height)
    surface = loft(integral.groups())
    lost = sum(not one.success for one in found)
    status: Any = "incomplete" if lost or outside or not found else "mapped"
    labels: Any = tuple(one.name for one in measures(system, names))
    told = f"{lost} of {len(found)} slices are incomplete" if lost else "All slices are complete"
    if not found:
        told = "Nothing can be reached" + (
            " between these heights" if between else " over a range of heights"
        )
    told += f"; of {len(positions)} random admissible positions {outside or 'none'} lay outside"
    return WorkspaceVolume(
        system.name,
        labels,
        ranges,
        tuple(integral.critical),
        tuple(found),
        integral.value,
        integral.error,
        *surface,
        status,
        told,
        system.model,
        integral.rates(reach) if derivatives and found else None,
    )


def _positions(system: System, asked: Asked, count: int) -> Iterator[tuple[Array, float, Array]]:
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
    """How many positions lie neither in the slices above or below nor in their own, which is made if need be."""
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
    """How many positions that were asked for lie at heights that seemed out of reach."""
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
