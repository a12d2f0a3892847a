"""Output of the command line on standard error: log levels, and colours on a terminal."""

from __future__ import annotations

import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

COLOURS = {"red": "31", "green": "32", "yellow": "33", "bold": "1"}
LEVELS = {-1: logging.ERROR, 0: logging.INFO, 1: logging.DEBUG}


class _ToStandardError(logging.Handler):
    """Prints each message as a line, wherever standard error points to just then."""

    def emit(self, record: logging.LogRecord) -> None:
        print(self.format(record), file=sys.stderr, flush=True)


def listen(level: int) -> None:
    """Show the log of this package from a level on: -1 errors, 0 what was written and done, 1 everything."""
    logger = logging.getLogger("sarrus")
    logger.setLevel(LEVELS[max(-1, min(level, 1))])
    if not any(isinstance(handler, _ToStandardError) for handler in logger.handlers):
        logger.addHandler(_ToStandardError())
    logger.propagate = False


@contextmanager
def warnings_to(note: Callable[[str], bool]) -> Iterator[None]:
    """Print warnings of analyses on standard error, instead of Python; `note` returns whether one is new."""
    from ..model.errors import SarrusWarning

    with warnings.catch_warnings():
        warnings.simplefilter("always", SarrusWarning)
        others = warnings.showwarning

        def show(message: Any, category: type[Warning], *where: Any, **more: Any) -> None:
            if not issubclass(category, SarrusWarning):
                others(message, category, *where, **more)
            elif note(str(message)):
                print(f"{painted('warning:', 'yellow', sys.stderr)} {message}", file=sys.stderr, flush=True)

        warnings.showwarning = show
        yield


def is_quiet() -> bool:
    """Whether notes and progress bars are unwanted."""
    return not logging.getLogger("sarrus").isEnabledFor(logging.INFO)


def painted(text: str, colour: str, stream: TextIO) -> str:
    """The text in a colour, if the stream is a terminal and NO_COLOR is not set."""
    return f"\033[{COLOURS[colour]}m{text}\033[0m" if _has_colours(stream) else text


def _has_colours(stream: TextIO) -> bool:
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    return bool(os.environ.get("FORCE_COLOR")) or stream.isatty()
