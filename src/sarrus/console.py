"""Output to the console: only where there is one, and in characters that it has."""

from __future__ import annotations

import codecs
import os
import sys
import unicodedata
from contextlib import suppress
from typing import Any

NAME = "sarrus"  # of the handler of encoding errors
SIGNS = "█ #,· -,− -,⁻ -,± +-,× x,→ ->,√ sqrt,≤ <=,≥ >=,½ 1/2,° deg,λ lambda"
PLAIN = {pair[0]: pair[2:] for pair in SIGNS.split(",")}


def _plain(c: str) -> str:
    """Return a character in ASCII: Phi, m2; others as a question mark."""
    kind, *_, name = unicodedata.name(c, "UNKNOWN ?").split()
    greek = kind == "GREEK" and (name.title() if c.isupper() else name.lower())
    alike = unicodedata.normalize("NFKD", c).encode("ascii", "ignore").decode()
    return PLAIN.get(c) or greek or alike or "?" * (not unicodedata.combining(c))


def _replaced(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_plain, error.object[error.start : error.end])), error.end


codecs.register_error(NAME, _replaced)


def printable(text: str, stream: Any = None) -> str:
    """Return a text with what a stream, by default standard output, cannot encode in ASCII."""
    encoding = getattr(stream or sys.stdout, "encoding", None) or "utf-8"
    return text.encode(encoding, NAME).decode(encoding)


def is_terminal() -> bool:
    """Whether standard error is a terminal. It may be missing, as in services, or closed."""
    with suppress(AttributeError, ValueError):
        return sys.stderr.isatty()
    return False


_line: tuple[int, Any] = (-1, None)  # the last cell of a notebook with a line that is redrawn, and the line


def _redraw(text: str) -> None:
    """Redraw the line of a notebook's cell; an empty one is invisible, also in the saved notebook."""
    global _line
    import IPython

    python: Any = IPython
    cell, content = python.get_ipython().execution_count, {"text/plain": text}
    if cell == _line[0]:
        _line[1].update(content, raw=True)
    elif text:
        _line = cell, python.display.display(content, raw=True, display_id=True)


def report(text: str, end: str = "\n") -> None:
    """Write a text to standard error, if that can be written; in notebooks, which colour it, to standard output.

    A text with a carriage return replaces the line before.
    """
    if type(sys.stderr).__module__.startswith("ipykernel"):
        _redraw(text.rpartition("\r")[2]) if "\r" in text else print(text, end=end, flush=True)
    elif sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(printable(text, sys.stderr), end=end, file=sys.stderr, flush=True)


def prepare_streams() -> None:
    """Discard what a program writes to streams that are closed, and let others replace what they cannot encode."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_WRONLY), "w", encoding="utf-8"))
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=NAME)
