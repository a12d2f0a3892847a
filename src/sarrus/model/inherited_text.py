"""Parameters that a class inherits are described in its own docstring, which `help` shows alone."""

from __future__ import annotations

import re
from inspect import cleandoc

TITLE = "\n\nParameters\n----------\n"
SECTION = re.compile(r"\n\n(?=\w[\w ]*\n-{3,}\n)")
ENTRY = re.compile(
    r"^(\w[\w, ]*).*(?:\n[ ]+.*)*", re.MULTILINE
)  # names, and a text behind them or indented below


def described(cls: type) -> str:
    """The docstring of a class whose parameters are followed by those that its base classes describe.

    A parameter is described once, by the first class in the order of inheritance.
    """
    before, entries, after = _parts(cls)
    for base in cls.__mro__[1:]:
        entries |= {names: text for names, text in _parts(base)[1].items() if names not in entries}
    return before + (TITLE + "\n".join(entries.values()) if entries else "") + after


def _parts(cls: type) -> tuple[str, dict[str, str], str]:
    """What comes before the parameters, their entries by names, and the sections behind."""
    first, *sections = SECTION.split(cleandoc(cls.__dict__.get("__doc__") or ""))
    titled = {section.partition("\n")[0]: section for section in sections}
    body = titled.pop("Parameters", "").partition("-\n")[2]
    entries = {entry[1].strip(): entry[0] for entry in ENTRY.finditer(body)}
    return first, entries, "".join(f"\n\n{section}" for section in titled.values())
