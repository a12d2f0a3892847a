"""Texts in the place of plain numbers, ``mass="2 kg"``, become numbers in SI units when a model is created."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from typing import Any, TypeVar

from .errors import restated
from .expression import Expression
from .expression.quantity import quantity, quantity_of
from .geometry.orientation import AxisAngle, EulerAngles
from .geometry.points import Frame, Point
from .measure import measures, scalar_fields

Part = TypeVar("Part")
ANY = ""  # unit of a number that may have any
WITHIN = {  # values of a field that have numbers themselves, and their units
    Point: {"coordinates": "m"},
    Frame: {"point": "m", "x": "1", "z": "1"},
    AxisAngle: {"axis": "1", "angle": "rad"},
    EulerAngles: {"angles": "rad"},
}


def with_numbers_of_texts(part: Part) -> Part:
    """Return a part of a model whose plain numbers are no texts; the same object if it has none.

    Raises
    ------
    ModelError
        For a text that is no number, or in another unit than its field.
    """
    changed: dict[str, Any] = {}
    kind: Any = part.__class__
    plain = _plain(kind) if is_dataclass(part.__class__) else {}
    for name, unit in plain.items():
        value = getattr(part, name, None)
        if isinstance(value, str) and name not in scalar_fields(kind):
            continue  # an axis "y", which is refused as no three numbers
        if (number := numbers_of(value, unit, name)) is not value:
            changed[name] = number
    return replace(part, **changed) if changed else part  # type: ignore[type-var]


def numbers_of(value: Any, unit: str | None, field: str) -> Any:
    """Return the numbers of a field; the same object if it has no text.

    Raises
    ------
    ModelError
        As `with_numbers_of_texts`.
    """
    with restated(field, field=field):
        return _number(value, unit)


@lru_cache
def _plain(kind: Any) -> dict[str, str | None]:
    """The fields of a class that are no laws, and the units of their numbers; None for those that have none."""
    found: dict[str, str | None] = {}
    for field in fields(kind):
        measure = measures(kind).get(field.name)
        if measure and measure.over == "1" and not measure.outputs:
            found[field.name] = measure.unit or (ANY if field.name == "parameters" else None)
    return found


def _number(value: Any, unit: str | None) -> Any:
    """A number, or numbers, of what the user gives; the same object if it has no text."""
    if type(value) in WITHIN:
        inner = {name: _number(getattr(value, name), own) for name, own in WITHIN[type(value)].items()}
        changed = {name: one for name, one in inner.items() if one is not getattr(value, name)}
        return replace(value, **changed) if changed else value
    if isinstance(value, list | tuple):
        numbers = [_number(one, unit) for one in value]
        return tuple(numbers) if any(a is not b for a, b in zip(numbers, value, strict=True)) else value
    if isinstance(value, Mapping):
        entries = {name: _number(one, unit) for name, one in value.items()}
        return entries if any(entries[name] is not one for name, one in value.items()) else value
    if isinstance(value, str):
        return value if unit is None else quantity(value, unit or None)
    return (
        quantity_of(value, unit or None).value
        if isinstance(value, Expression) and unit is not None
        else value
    )
