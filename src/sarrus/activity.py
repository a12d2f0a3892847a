"""Activity: what takes longer than a second has a line on a terminal or in a notebook; elsewhere the log has it.

The line is the bar of an analysis, or a text such as ``checking derivatives, 3 s``. An activity within another one has
none. ``progress=False``, `showing(False)` and ``SARRUS_PROGRESS=0`` silence it. While kernels are compiled, their line
is shown in its place.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Event, Thread, current_thread, main_thread
from typing import TypeAlias

from ._jit.linking import compilation
from ._jit.linking.compilation import PATIENCE, PAUSE, REPORTS

LOGGER = logging.getLogger("sarrus.progress")
Line: TypeAlias = Callable[[float], str]  # of the seconds since the activity began
_within: ContextVar[bool] = ContextVar("within", default=False)


@contextmanager
def activity(line: Line | None) -> Iterator[None]:
    """Show a line while the context lasts longer than a second; None where something else shows it."""
    outer, token = _within.get(), _within.set(True)
    over, watching = Event(), None
    if line is not None and not outer and _wanted():
        watching = Thread(target=_watch, args=(line, over), daemon=True)
        watching.start()
    try:
        yield
    finally:
        _within.reset(token)
        over.set()
        if watching is not None:
            watching.join()


def for_seconds(text: str) -> Line:
    """A line of a text and the seconds since it began."""
    return lambda taken: f"{text}, {taken:.0f} s"


def _wanted() -> bool:
    """Whether somebody can see the line; threads work for an activity of the main one."""
    if current_thread() is not main_thread():
        return False
    return compilation.is_shown() and (compilation.redrawable() or LOGGER.isEnabledFor(logging.INFO))


def _watch(line: Line, over: Event) -> None:
    began, pause, drawn, reported = time.perf_counter(), PATIENCE, False, -REPORTS
    live = compilation.redrawable()
    while not over.wait(pause):
        pause, taken = PAUSE, time.perf_counter() - began
        if compilation.compiling():
            continue
        if live:
            compilation.draw(f"  {line(taken)}")
            drawn = True
        elif taken - reported > REPORTS:
            reported = taken
            LOGGER.info(line(taken).lstrip("█· "))
    if drawn:
        compilation.draw("")
