"""The table of hardpoints of a model file: its unit, its names, and its form."""

from __future__ import annotations

from typing import Any

from pydantic import AfterValidator, WithJsonSchema

from ..checks.findings import part_name
from ..errors import ModelError
from ..expression.units import look_up, powers_of
from ..hardpoints import check_hardpoint_name
from ..show import quote, show
from .stated import invalid, list_of, mapping_of, marked, number_in
from .text.document import Document, refusal

SECTION, UNIT = "hardpoints", "unit"
METRE = powers_of("m")
OTHERS = {
    "parameters": "parameter",
    "points": "point",
}  # sections whose names formulas use, and what each has


def with_unit(document: Document) -> Document:
    """Return a document in which coordinates of hardpoints without a unit have that of their table.

    Raises
    ------
    ModelError
        If the unit is no length.
    """
    table = document.data.get(SECTION) if isinstance(document.data, dict) else None
    if not isinstance(table, dict) or UNIT not in table:
        return document
    unit = table[UNIT]
    if not _is_length(unit):
        file, path = document.origin.file, (SECTION, UNIT)
        message = f"the unit of hardpoints must be one of length, got {show(unit)}. Give mm, m or in."
        raise refusal(message, file, document.origin.line(path))
    points = {name: _in_unit(place, unit) for name, place in table.items() if name != UNIT}
    return document._replace(data={**document.data, SECTION: points})


def refuse_second_meaning(document: Document) -> None:
    """Refuse a hardpoint with the name of a parameter or of another point, which formulas could not distinguish.

    Raises
    ------
    ModelError
    """
    sections = {word: document.data.get(section) or {} for section, word in OTHERS.items()}
    for name in document.data.get(SECTION) or {}:
        other = next((word for word, names in sections.items() if name in names), "")
        if other:
            origin, path = document.origin, (SECTION, name)
            message = f"the name {quote(name)} is also that of a {other}. Rename one of them."
            raise ModelError(message, part=part_name(path), where=origin.where(path))


def _is_length(unit: Any) -> bool:
    try:
        return isinstance(unit, str) and dict(look_up(unit).powers) == METRE
    except ModelError:
        return False


def _in_unit(place: Any, unit: str) -> Any:
    if not isinstance(place, list):
        return place
    return [f"{x!r} {unit}" if isinstance(x, float) else x for x in place]


def _check_names(given: dict[str, Any]) -> dict[str, Any]:
    for name in given:
        try:
            check_hardpoint_name(name)
        except ModelError as error:
            raise invalid(error.message, name) from None
    return given


def _check_place(place: list[float]) -> list[float]:
    if len(place) != 3:
        raise invalid(f"must be three coordinates, got {len(place)}. Give [x, y, z].")
    return place


_coordinates: dict[str, Any] = {
    "type": "array",
    "items": {"type": ["number", "string"]},
    "minItems": 3,
    "maxItems": 3,
}
_schema: dict[str, Any] = {
    "type": "object",
    "properties": {UNIT: {"type": "string", "description": "Of coordinates without a unit; default: m."}},
    "additionalProperties": _coordinates,
}
Form: Any = marked(
    mapping_of(marked(list_of(number_in("m")), AfterValidator(_check_place))),
    AfterValidator(_check_names),
    WithJsonSchema(_schema),
)
