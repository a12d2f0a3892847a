"""A model file as plain data, with the line of every entry."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...checks.findings import part_name
from ...checks.origin import Origin, Path
from ...errors import ModelError

DEEPEST = 64  # levels of nesting


class Document(NamedTuple):
    """The data of a file (mappings, lists, texts, floats, booleans, None) and where they stand."""

    data: Any
    origin: Origin


def refusal(message: str, file: str, line: int, path: Path = ()) -> ModelError:
    """Return the error for a line of a file, with the part that the line belongs to."""
    return ModelError(message, part=part_name(path), where=f"{file}:{line}")


def refuse_deep(depth: int, file: str, line: int, path: Path) -> None:
    """Raise a ModelError when the nesting is deeper than any model needs."""
    if depth > DEEPEST:
        message = f"is nested deeper than {DEEPEST} levels. Remove brackets or indentation."
        raise refusal(message, file, line, path[:2])


def refuse_repeated(key: str, first: int | None, file: str, line: int, path: Path) -> None:
    """Raise a ModelError when a key has been given before, on the line ``first``."""
    if first is not None:
        message = f'the key "{key}" is given twice, the first time on line {first}. Remove one of them.'
        raise refusal(message, file, line, (*path, key))
