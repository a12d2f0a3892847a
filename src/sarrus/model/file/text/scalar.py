"""The value of a plain word in a YAML file: the core schema of YAML 1.2, with floats for all numbers."""

from __future__ import annotations

import re

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
