"""Times at which a model's laws are not smooth: where its tables over time have their points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....model import Curve
from ....system import System
from ....system.cached import once
from .features import features
from .laws_of_time import fields_of_time


def breakpoints(system: System, begin: float, until: float) -> tuple[Array, Array, Array]:
    """Rising times of the points of all tables over time; those where second derivatives jump, and where values do.

    A table is a cubic spline, twice continuously differentiable at its inner points, and straight beyond its ends, or
    periodic. Cubics that a user gives may be any.
    """
    curves = _curves_of_time(system)
    every = [
        x for curve in curves for x in curve.knots_within(begin, until)[1:-1]
    ]  # the outer pieces are straight
    single = [curve for curve in curves if len(curve.knots) > 3 and not curve.periodic]
    ends = [x for curve in single for x in (curve.knots[1], curve.knots[-2])]
    jumps = [x for curve in curves for x in _jumps(curve)]
    return np.unique(np.array(every)), np.unique(np.array(ends)), np.unique(np.array(jumps))


def _jumps(curve: Curve) -> Iterator[float]:
    """The points at which the values of two cubics differ by more than round-off."""
    x, after = np.array(curve.knots), np.array([cubic[3] for cubic in curve.cubics])
    ends = [np.polyval(cubic, width) for cubic, width in zip(curve.cubics, np.diff(x), strict=True)]
    yield from x[1:-1][abs(after[1:] - ends[:-1]) > ROUND_OFF * abs(after).max()].tolist()


ROUND_OFF = 1e-9  # [-] of the greatest value of a table, which its points miss by less
ROUND = 1e-12  # [-] of the end time, below which two times to stop at are the same
ASIDE = 1e-14  # [-] of the end time: so far before a jump steps end, and behind it they begin


class Stops(NamedTuple):
    """Times at which steps end.

    Attributes
    ----------
    all : of all of them
    kinks : those after which a method starts anew
    longest : step between them
    quick : where a law varies faster than steps whose length is given can see
    aside : how far kinks are before the times of jumps, so that all stages of a step are on one side
    behind : how long after the start the first step begins, behind a jump there
    """

    all: Array
    kinks: Array
    longest: float
    quick: Array
    aside: float
    behind: float


def stops_of(
    system: System, given: Array, until: float, begin: float = 0.0, *, step: float | None = None
) -> Stops:
    """Times at which steps end; where a step is given, at corners only."""
    if given.ndim != 1 or not np.all(np.isfinite(given)):
        raise ValueError("breakpoints must be finite numbers. Give a list of times in s.")
    every, ends, own = breakpoints(system, begin, until)
    corners, soft, longest = features(system, begin, until)
    aside = ASIDE * max(abs(begin), abs(until))
    jumps = np.concatenate([given, corners, own]) - aside
    stops, kinks = (np.concatenate([jumps, times]) for times in (every, ends))
    quick = np.zeros(0)
    if step is not None:
        longest, quick = np.inf, _nearer(_apart(soft, begin, until), corners, step)
    else:
        stops = np.concatenate([stops, soft])
    late = jumps + aside - begin
    behind = max((x + 2 * aside for x in late[abs(late) <= ROUND * max(abs(begin), abs(until))]), default=0.0)
    return Stops(_apart(stops, begin, until), _apart(kinks, begin, until), longest, quick, aside, behind)


def _nearer(times: Array, corners: Array, step: float) -> Array:
    """Return the times that are nearer than half a step to others or to corners."""
    every = np.unique(np.concatenate([times, corners]))
    gaps = np.diff(every, prepend=-np.inf, append=np.inf)
    near = np.minimum(gaps[:-1], gaps[1:]) < 0.5 * step
    return every[near & np.isin(every, times)]


def _apart(times: Array, begin: float, until: float) -> Array:
    """The times inside of the run, without those that differ from the one before by round-off alone."""
    least = ROUND * max(abs(begin), abs(until))
    times = np.unique(times)
    inside = times[(times > begin + least) & (times < until - least)]
    return inside[np.diff(inside, prepend=-np.inf) > least]


@once
def _curves_of_time(system: System) -> list[Curve]:
    laws = (
        values[n]
        for p in system.populations
        for values in p.values
        for n in (fields_of_time(p.variant) if p.count else ())
    )
    return [one for one in laws if isinstance(one, Curve) and (len(one.cubics) > 1 or one.periodic)]
