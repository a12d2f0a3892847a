"""The sections ``left`` and ``right`` of a model file: parts of one side, whose mirror images are on the other."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ..checks.findings import Findings, Origin, Path
from ..expression.functions import CONSTANTS, PLAIN
from ..expression.units import COMMON
from ..mirror_image import SIDES, Image
from ..show import quote, show, suggest
from ..states.input import OWN
from .text.document import Document, refusal

SECTIONS = ("bodies", "joints", "drivers", "forces")
TEXTS = ("type", "unit", "axes", "file", "color")  # keys whose texts are no names and no formulas


def with_sides(document: Document) -> Document:
    """Return a document with the parts of its sides among the others, as ``arm_left``, without their mirror images.

    Raises
    ------
    ModelError
        If a side has no mapping of sections, or a name is taken.
    """
    for side in SIDES:
        if isinstance(document.data, dict) and side in document.data:
            document = _with_side(document, side)
    return document


def _with_side(document: Document, side: str) -> Document:
    data, origin = dict(document.data), document.origin
    sections = _sections(document, side, data.pop(side))
    names = {name for entries in sections.values() for name in entries}
    lines = dict(origin.lines)
    for section, entries in sections.items():
        own = dict(data.get(section) or {})
        for name, entry in entries.items():
            for one in SIDES:
                if f"{name}_{one}" in own:
                    message = f"has the part {quote(name)}, but there is {quote(f'{name}_{one}')}. Rename one of them."
                    raise refusal(message, origin.file, origin.line((side, section, name)), (section, name))
                lines |= _moved(origin.lines, (side, section, name), (section, f"{name}_{one}"))
            own[f"{name}_{side}"] = _renamed(entry, names, side)
        data[section] = own
    mirrored = document.mirrored | {f"{name}_{side}" for name in names}
    return Document(data, Origin(origin.file, lines, origin.files), mirrored)


def _sections(document: Document, side: str, given: Any) -> dict[str, dict[str, Any]]:
    """The sections of a side, each a mapping of parts."""
    file, line = document.origin.file, document.origin.line
    if not isinstance(given, dict):
        raise refusal(
            f"{side} must be a mapping, but is {show(given)}. Give bodies, joints and forces.",
            file,
            line((side,)),
        )
    for section, entries in given.items():
        if section not in SECTIONS:
            raise refusal(
                f"{side} has no key {quote(section)}. {suggest(section, SECTIONS)}",
                file,
                line((side, section)),
            )
        if not isinstance(entries, dict):
            message = f"{side}: {section} must be a mapping. Give keys and values, as in key: value."
            raise refusal(message, file, line((side, section)))
    _check_names(document, side, given)
    return given


def _check_names(document: Document, side: str, given: Mapping[str, Any]) -> None:
    """Refuse names of parts that mean something else in the texts of a side, which could not be distinguished."""
    names = {name for entries in given.values() for name in entries}
    for section, entries in given.items():
        for name, entry in entries.items():
            own = entry.get("parameters") if isinstance(entry, dict) else None
            taken = [one for one in own if one in names] if isinstance(own, dict) else []
            message = f"its parameter {quote(taken[0])} has the name of a part" if taken else ""
            if meaning := _meaning(document, name, given):
                message = f"the name {quote(name)} of a part is also that of a {meaning}"
            if message:
                origin = document.origin
                line = origin.line((side, section, name))
                raise refusal(f"{message}. Rename the part.", origin.file, line, (section, name))


def _meaning(document: Document, name: str, given: Any) -> str:
    """What else a name stands for in the texts of a side."""
    if name in (*OWN, *CONSTANTS, *PLAIN):
        return "variable or function of formulas"
    sections = {"hardpoints": "hardpoint", "parameters": "parameter", "points": "point"}
    for section, word in sections.items():
        table = document.data.get(section)
        if isinstance(table, dict) and name in table:
            return word
    quantity = rf"\d\s*(?:[A-Za-z°][\w^-]*[\s/*]+)*{re.escape(name)}(?![\w.-])"
    used = name in COMMON and any(re.search(quantity, text) for text in _texts(given))
    return "unit, which the side uses" if used else ""


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for one in value.values() if isinstance(value, dict) else value:
            yield from _texts(one)


def _moved(lines: Mapping[Path, int], old: Path, new: Path) -> dict[Path, int]:
    return {(*new, *path[3:]): line for path, line in lines.items() if path[:3] == old}


def _renamed(value: Any, names: Iterable[str], side: str) -> Any:
    """Return an entry in which names of the parts of a side have its suffix."""
    if isinstance(value, dict):
        new = {key: one if key in TEXTS else _renamed(one, names, side) for key, one in value.items()}
        joints = new.get("joints")
        if isinstance(joints, dict):  # those of a tendon, by name
            new["joints"] = {_renamed(key, names, side): one for key, one in joints.items()}
        return new
    if isinstance(value, list):
        return [_renamed(one, names, side) for one in value]
    if not isinstance(value, str):
        return value
    known = "|".join(map(re.escape, sorted(names, key=len, reverse=True)))
    return re.sub(rf"(?<![\w.-])({known})(?![\w-])", rf"\1_{side}", value)


def images(image: Image, parts: Sequence[Any], section: str, findings: Findings) -> list[Any]:
    """Return the mirror images of those parts of a section that are on a side; keep errors."""
    own = [part for part in parts if part.name in image.names]
    found: list[Any] = []
    for part in own:
        with findings.about(section, part.name):
            found.append(image(part))
    return found
