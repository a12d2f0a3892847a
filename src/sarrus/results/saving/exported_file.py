"""Files that results are exported to: where one cannot be written, the error names it, and the earlier one stays."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from errno import ENOENT
from functools import wraps
from inspect import signature
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from ...model.checks.arguments import CHECKS
from ...model.checks.calls import wrong_call
from ...model.file.replaced_file import replacing
from .checked_file import NotSavedError

P = ParamSpec("P")
R = TypeVar("R")


@contextmanager
def exporting(path: Any) -> Iterator[Any]:
    """Yield where to write a file in this block, see `replacing`; streams, which have no name, are left alone.

    Raises
    ------
    NotSavedError
        If its folder does not exist, the file cannot be opened, the disk is full or a limit is reached.
    TypeError
        For a path that is none.
    """
    if hasattr(path, "write"):
        yield path
        return
    CHECKS["path"]("path", path)
    place = Path(path)
    if not os.path.isdir(place.parent):
        raise NotSavedError(place, OSError(ENOENT, os.strerror(ENOENT)))
    draft = path
    try:
        with replacing(place) as draft:
            yield draft
    except Exception as wrong:
        failure = _system_error(wrong)
        # a full disk is an error that names no file
        named = {None, os.fspath(path), os.path.realpath(path), os.fspath(draft)}
        if (
            failure is None
            or not failure.errno
            or (failure.filename and os.fspath(failure.filename)) not in named
        ):
            raise
        raise NotSavedError(place, failure) from None


def _system_error(wrong: BaseException | None) -> OSError | None:
    """The error of the operating system, also where a library failed as it cleaned up after it."""
    while wrong is not None and not isinstance(wrong, OSError):
        wrong = wrong.__context__
    return wrong


def exports(write: Callable[P, R]) -> Callable[P, R]:
    """Decorate a method that writes a file, its first argument ``path``; see `exporting`."""

    own = signature(write)

    @wraps(write)
    def exported(*args: P.args, **kwargs: P.kwargs) -> R:
        if message := wrong_call(write.__name__, own, args, kwargs):
            raise TypeError(message)
        given = own.bind(*args, **kwargs)
        with exporting(given.arguments["path"]) as given.arguments["path"]:
            return write(*given.args, **given.kwargs)

    return exported


def header_cell(label: str) -> str:
    """Return a label that spreadsheets take as text, not as a formula, and that is on one line."""
    plain = "".join(c if c.isprintable() else repr(c)[1:-1] for c in label)
    return f"'{plain}" if plain.startswith(("=", "+", "-", "@")) else plain


def write_table(path: Any, header: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """Write a table with a line for each row, numbers with all digits, separated by commas."""
    import csv

    with exporting(path) as draft, Path(draft).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(map(header_cell, header))
        writer.writerows(rows)
