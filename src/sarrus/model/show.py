"""Short representations of wrong values in error messages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from itertools import islice
from typing import Any

LONGEST = 40  # characters of a quoted value
MOST = 12  # names in a list of choices
MOST_SOUGHT = 1000  # names that a misspelt one is compared with


def show(value: Any) -> str:
    """Return a short description of ``value`` for a message."""
    if value is None:
        return "empty"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return quote(value)
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, (list, tuple)):
        return "an empty list" if not value else "a list"
    return _one_line(str(value))


def quote(text: str) -> str:
    """Return ``text`` in double quotes, shortened, with control characters escaped."""
    return f'"{_one_line(str(text))}"'


def suggest(wrong: str, right: Iterable[str], most: int = MOST) -> str:
    """Return the question ``Did you mean "…"?`` for a misspelt name, or the list of the right ones, up to ``most``."""
    wrong, names = str(wrong), [str(name) for name in right]
    near = _but_for_case(wrong, names) or get_close_matches(wrong, _alike(wrong, names), n=1)
    if near:
        return f"Did you mean {quote(near[0])}?"
    if not names:
        return "Remove it."
    listed = ", ".join(_one_line(name) for name in names[:most])
    return f"Choose from {listed}" + (", …" if len(names) > most else ".")


def _but_for_case(wrong: str, names: list[str]) -> list[str]:
    return [name for name in names if str(name).casefold() == wrong.casefold()]


def _alike(wrong: str, names: list[str]) -> list[str]:
    """Return the names themselves, or of very many those that begin alike and are about as long."""
    if len(names) <= MOST_SOUGHT:
        return names
    near = (name for name in names if name[:1] == wrong[:1] and abs(len(name) - len(wrong)) < 3)
    return list(islice(near, MOST_SOUGHT))


def _one_line(text: str) -> str:
    plain = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text[: LONGEST + 1])
    return plain if len(plain) <= LONGEST else plain[: LONGEST - 1] + "…"


FORMS = re.compile(r"\[(?:([^|\]]*)\|)?([^|\]]*)\]")


def counted(message: str, n: int) -> str:
    """Return a message on n things: ``"{n} joint[s] [is|are] locked"`` has letters of the plural and both forms."""
    return FORMS.sub(lambda forms: (forms[1] or "") if n == 1 else forms[2], message).replace("{n}", str(n))
