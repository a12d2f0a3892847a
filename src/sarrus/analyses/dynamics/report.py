"""How far a run has come: a line on the terminal, with the simulated time and the time to go."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

WIDTH = 28
PAUSE = 0.1  # s between two drawings


class Bar:
    """Drawn on standard error while it is a terminal; else one line when it is done."""

    def __init__(self, until: float) -> None:
        self._until, self._began, self._shown, self._t = until, time.perf_counter(), 0.0, 0.0
        self._live = sys.stderr.isatty()

    def __call__(self, t: float) -> None:
        """The time reached."""
        self._t = t
        now = time.perf_counter()
        if self._live and now - self._shown > PAUSE:
            self._shown = now
            print(f"\r\033[K  {self.line(now - self._began)}", end="", file=sys.stderr, flush=True)

    def line(self, taken: float) -> str:
        """What is drawn after so many seconds."""
        share = min(self._t / self._until, 1.0)
        full = int(WIDTH * share)
        left = f"{duration(taken * (1 - share) / share)} to go" if share > 0 else ""
        return f"{'█' * full}{'·' * (WIDTH - full)} {self._t:.4g} of {self._until:g} s, {left}"

    def close(self) -> None:
        """Leave one line behind."""
        start = "\r\033[K" if self._live else ""
        taken = duration(time.perf_counter() - self._began)
        print(
            f"{start}  simulated {self._t:.4g} of {self._until:g} s in {taken}", file=sys.stderr, flush=True
        )


def duration(seconds: float) -> str:
    """A duration for people: 0.21 s, 12 s, 3 min 5 s, 2 h 10 min."""
    if seconds < 60:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


@contextmanager
def reporter(
    wanted: bool | Callable[[float], None] | None, until: float
) -> Iterator[Callable[[float], None] | None]:
    """What is called with the time reached: the function given, a bar, or nothing."""
    if wanted is not True:
        yield wanted or None
        return
    bar = Bar(until)
    try:
        yield bar
    finally:
        bar.close()
