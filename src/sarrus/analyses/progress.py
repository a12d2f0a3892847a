"""Progress reports and time limits of analyses that can take long: one monitor for all of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

import numpy as np

from .._jit.linking.compilation import showing
from ..activity import activity
from ..console import is_terminal, report
from ..model.checks.arguments import CHECKS

WIDTH = 28
PAUSE = 0.1  # s between two drawings

Progress: TypeAlias = Callable[[float], None]


class TimeLimit(Exception):
    """The time limit of an analysis has passed. The analysis returns what it has computed."""


class Bar:
    """A progress bar on standard error while that is a terminal; else one line at the end.

    Parameters
    ----------
    total : the value at which the analysis is finished; infinite where it is not known
    done : participle, ``simulated 2 of 10 s in 3 s``
    unit : of `total`, with a space before it

    Attributes
    ----------
    total, reached : as known so far
    """

    def __init__(self, total: float, done: str = "simulated", unit: str = " s") -> None:
        self.total, self._verb, self._unit = total, done, unit
        self._began, self._shown, self.reached = time.perf_counter(), 0.0, 0.0
        self._live = is_terminal()

    def __call__(self, reached: float) -> None:
        """The value reached, of `total`."""
        self.reached = reached
        now = time.perf_counter()
        if self._live and now - self._shown > PAUSE:
            self._shown = now
            report(f"\r\033[K  {self.line(now - self._began)}", end="")

    def line(self, taken: float) -> str:
        """The bar after `taken` seconds."""
        if not np.isfinite(self.total):
            return f"{self._verb} {self._amount()}, {duration(taken)}"
        share = min(self.reached / self.total, 1.0) if self.total > 0 else 1.0
        full = int(WIDTH * share)
        left = f"{duration(taken * (1 - share) / share)} to go" if share > 0 else duration(taken)
        return f"{'█' * full}{'·' * (WIDTH - full)} {self._verb} {self._amount()}, {left}"

    def _amount(self) -> str:
        of = f" of {self.total:g}" if np.isfinite(self.total) else ""
        return f"{self.reached:.4g}{of}{self._unit}"

    def close(self) -> None:
        """Print the last line."""
        start = "\r\033[K" if self._live else ""
        taken = duration(time.perf_counter() - self._began)
        report(f"{start}  {self._verb} {self._amount()} in {taken}")


def duration(seconds: float) -> str:
    """A duration for people: 0.21 s, 12 s, 3 min 5 s, 2 h 10 min."""
    if seconds < 60:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


class Monitor:
    """Receives the value that an analysis has reached; see `monitor`."""

    def __init__(self, bar: Bar, show: Progress | None, time_limit: float | None) -> None:
        self._bar, self._show, self._limit = bar, show, time_limit
        self._began = time.perf_counter()

    def __call__(self, reached: float) -> None:
        """The value reached.

        Raises
        ------
        TimeLimit
            If the time limit has passed.
        """
        self._bar.reached = reached
        if self._show:
            self._show(reached)
        if self._limit is not None and time.perf_counter() - self._began > self._limit:
            raise TimeLimit(f"the time limit of {duration(self._limit)} has passed")

    def expect(self, total: float) -> None:
        """The value at which the analysis is finished, as far as it is known by now."""
        self._bar.total = total


def refuse_time_limit(time_limit: float | None, name: str = "time_limit") -> None:
    """Refuse a time limit that is not a positive number of seconds, as every function that takes one does.

    Raises
    ------
    TypeError
        For another kind than a number.
    ValueError
    """
    if time_limit is not None:
        CHECKS["time_limit"](name, time_limit)


@contextmanager
def monitor(
    progress: bool | Progress | None,
    total: float = np.inf,
    *,
    done: str = "simulated",
    unit: str = " s",
    time_limit: float | None = None,
) -> Iterator[Monitor]:
    """Give what an analysis calls with the value reached, again and again.

    It draws a bar (``progress=True``; by default on a terminal and in a notebook, after a second, see
    `sarrus.activity`) or calls the user's function, and raises `TimeLimit` once `time_limit` seconds
    have passed since the monitor was made. The analysis catches that, as it catches KeyboardInterrupt, and returns what
    it has with the status "time limit". Compilation of kernels within it is shown on a terminal, with ``progress=True``
    also in a file or pipe, and with ``progress=False`` nowhere.

    Parameters
    ----------
    progress : True for a bar on standard error also if that is no terminal, False for silence, a function of the value
        reached, or None
    total, done, unit : as for `Bar`
    time_limit : seconds of the clock, or None

    Raises
    ------
    TypeError
        If `progress` is neither a bool nor a function, or `time_limit` no number.
    ValueError
        If `time_limit` is not positive.
    """
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise TypeError(
            f"progress must be True, or a function of the value reached, but is {progress!r}. "
            "Pass progress=True for a bar."
        )
    refuse_time_limit(time_limit)
    bar = Bar(total, done, unit)
    show = bar if progress is True else progress if callable(progress) else None
    try:
        with showing(progress if isinstance(progress, bool) else None), activity(None if show else bar.line):
            yield Monitor(bar, show, time_limit)
    finally:
        if progress is True:
            bar.close()
