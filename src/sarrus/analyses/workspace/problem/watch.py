"""Progress and time limit of workspace analyses: inner loops report to the monitor of the analysis that runs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal, NamedTuple

import numpy as np

from ...progress import PAUSE, Monitor, Progress, TimeLimit, monitor

POINTS, STARTS, SLICES, CELLS = " points", " starts", " slices", " cells"  # what analyses count


class Stop(NamedTuple):
    """Why an analysis ended early: the status of its result and the reason."""

    status: Literal["time limit", "stopped"]
    reason: str


class Watch:
    """The monitor of an analysis with the value reached so far, and what is counted."""

    def __init__(self, report: Monitor, unit: str) -> None:
        self.report, self.unit, self._reached, self._last = report, unit, 0.0, 0.0

    def reach(self, value: float) -> None:
        """Report a value."""
        self._reached, self._last = value, time.perf_counter()
        self.report(value)

    def check(self) -> None:
        """Report the last value again, if it was not just done: so the time limit is seen between two values."""
        if time.perf_counter() - self._last > PAUSE:
            self.reach(self._reached)


_running: ContextVar[Watch | None] = ContextVar("watch", default=None)


@contextmanager
def watched(
    progress: bool | Progress | None,
    total: float = np.inf,
    *,
    done: str,
    unit: str,
    time_limit: float | None = None,
) -> Iterator[None]:
    """Watch an analysis; the arguments are those of `monitor`. One inside another is watched by the outer one."""
    if _running.get() is not None and progress is None and time_limit is None:
        yield
        return
    with monitor(progress, total, done=done, unit=unit, time_limit=time_limit) as report:
        token = _running.set(Watch(report, unit))
        try:
            yield
        finally:
            _running.reset(token)


def reached(value: float, unit: str) -> None:
    """Report how far the analysis that runs has come, if that is what it counts.

    Raises
    ------
    TimeLimit
        If its time limit has passed.
    """
    if (watch := _running.get()) is not None and watch.unit == unit:
        watch.reach(value)
    else:
        check()


def expected(total: float, unit: str) -> None:
    """Report how many there will be, as far as it is known by now, if that is what the analysis counts."""
    if (watch := _running.get()) is not None and watch.unit == unit:
        watch.report.expect(total)


def check() -> None:
    """Raise `TimeLimit` if the time limit of the analysis that runs has passed."""
    if (watch := _running.get()) is not None:
        watch.check()


def stopped(work: Callable[[], object]) -> Stop | None:
    """Do some work; why it ended early, if it did."""
    try:
        work()
    except TimeLimit as limit:
        return Stop("time limit", str(limit))
    except KeyboardInterrupt:
        return Stop("stopped", "it was stopped by the user")
    return None
