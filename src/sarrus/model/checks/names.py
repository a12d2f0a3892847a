"""Names of parts: their form, and suggestions for unknown names."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TypeVar

from ..errors import ModelError
from ..show import quote, show, suggest

NAME = r"[^\W\d][\w-]*"  # a letter or _, then letters, digits, _ and -
Value = TypeVar("Value")


def matches(pattern: str, text: object) -> bool:
    """Return whether ``text`` is a text of this pattern."""
    return isinstance(text, str) and re.fullmatch(pattern, text) is not None


def check_name(name: object) -> None:
    """Raise a ModelError if ``name`` is not a name that a path like ``rod.mass`` can hold."""
    if not matches(NAME, name):
        message = f"its name must be letters, digits, _ and -, starting with a letter, but is {show(name)}"
        raise ModelError(f"{message}. Rename it.")


def find(name: str, known: Mapping[str, Value], field: str) -> Value:
    """Return ``known[name]`` for a body's name, or raise a ModelError with a suggestion."""
    if name not in known:
        others = [one for one in known if one != "ground" or name[:1] in "gG"]  # "rod" does not mean "ground"
        near = suggest(name, others).replace("Choose from ", "Choose from ground, ")
        raise ModelError(f"there is no body {quote(name)}. {near}", field=field)
    return known[name]
