"""Plain data to the text of a model file, as people write it: an entry on one line if it fits, else in a block."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from .document import resolve

WIDTH = 100  # columns of a line
VECTOR = 6  # numbers that are on one line whatever its length
WORD = re.compile(r"-?[\w(][\w .*/+^()°·-]*(?<! )")  # a text that needs no quotes, in brackets neither


class Style(NamedTuple):
    """What distinguishes YAML from JSON: text, brackets and separator of blocks, and how texts are written."""

    scalar: Callable[[str | float | None], str]
    brackets: bool


def yaml_text(data: dict[str, Any]) -> str:
    """Return the text of a YAML file."""
    return "".join(f"{line}\n" for line in _lines(data, "", YAML))


def json_text(data: dict[str, Any]) -> str:
    """Return the text of a JSON file."""
    return "{\n" + "\n".join(_lines(data, "  ", JSON)) + "\n}\n"


def scalar_text(value: str | float | None) -> str:
    """Return a number or a text as YAML; a number with all digits that it needs."""
    if not isinstance(value, str):
        return _number(value)
    if WORD.fullmatch(value) and resolve(value) == value:
        return value
    return json.dumps(value, ensure_ascii=False)


def _json_scalar(value: str | float | None) -> str:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else _number(value)


def _number(value: float | None) -> str:
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    return repr(float(value)).removesuffix(".0")


YAML, JSON = Style(scalar_text, brackets=False), Style(_json_scalar, brackets=True)


def _lines(data: dict[str, Any] | list[Any], pad: str, style: Style) -> Iterator[str]:
    """Yield the entries of a mapping or a list, each on a line of its own or in a block."""
    entries = [*data.items()] if isinstance(data, dict) else [(None, value) for value in data]
    for n, (key, value) in enumerate(entries):
        comma = "," if style.brackets and n + 1 < len(entries) else ""
        mark = ("" if style.brackets else "- ") if key is None else f"{style.scalar(key)}: "
        line = f"{pad}{mark}{_flow(value, style)}{comma}"
        section = isinstance(value, dict) and isinstance(data, dict) and _has_parts(value)
        if not _is_block(value) or not (section or len(line) > WIDTH):
            yield line
        elif style.brackets:
            opening, closing = "{}" if isinstance(value, dict) else "[]"
            yield f"{pad}{mark}{opening}"
            yield from _lines(value, pad + "  ", style)
            yield f"{pad}{closing}{comma}"
        elif key is None:
            yield line
        else:
            yield f"{pad}{mark}".rstrip()
            yield from _lines(value, pad + "  ", style)


def _is_block(value: Any) -> bool:
    """Whether a value may be written on several lines: no number or text, and no vector."""
    if isinstance(value, list):
        return len(value) > VECTOR or any(isinstance(entry, dict | list) for entry in value)
    return isinstance(value, dict) and bool(value)


def _has_parts(value: dict[str, Any]) -> bool:
    """Whether it is a section: a mapping of mappings."""
    return all(isinstance(entry, dict) and "body" not in entry for entry in value.values())


def _flow(value: Any, style: Style) -> str:
    if isinstance(value, dict):
        return (
            "{" + ", ".join(f"{style.scalar(key)}: {_flow(one, style)}" for key, one in value.items()) + "}"
        )
    if isinstance(value, list):
        return f"[{', '.join(_flow(one, style) for one in value)}]"
    return style.scalar(value)
