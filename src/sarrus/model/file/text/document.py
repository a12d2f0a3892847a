"""A model file as plain data, with the line of every entry."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

from ...checks.findings import Origin, Path, part_name
from ...errors import ModelError

DEEPEST = 64  # levels of nesting


class Document(NamedTuple):
    """The data of a file (mappings, lists, texts, floats, booleans, None), lines, and names of mirrored parts."""

    data: Any
    origin: Origin
    mirrored: frozenset[str] = frozenset()


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


NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
INFINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
WORDS: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}


def resolve(word: str) -> str | float | bool | None:
    """Return the value of a plain scalar: ``1e-3`` and ``010`` are numbers, ``on`` and ``1_000`` are text."""
    if word in WORDS:
        return WORDS[word]
    if NUMBER.fullmatch(word):
        return float(word)
    if INFINITE.fullmatch(word):
        return float(word.replace(".", ""))
    return word
