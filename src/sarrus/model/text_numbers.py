"""Texts in the place of plain numbers, ``mass="2 kg"``, become numbers in SI units when a model is created."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from .errors import ModelError, restated
from .expression import Expression, parse
from .expression.formula_value import formula_value
from .expression.quantity import quantity
from .expression.tree import lift
from .expression.units import fits, unit_of
from .geometry.orientation import AxisAngle, EulerAngles
from .geometry.points import Frame, Point
from .measure import measures, scalar_fields
from .quantity import is_list

Part = TypeVar("Part")
ANY = ""  # unit of a number that may have any
DIRECTION = "direction"  # of plain numbers or lengths, which may be given by two points
WITHIN = {  # values of a field that have numbers themselves, and their units
    Point: {"coordinates": "m"},
    Frame: {"point": "m", "x": DIRECTION, "z": DIRECTION},
    AxisAngle: {"axis": DIRECTION, "angle": "rad"},
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
    if value is None or isinstance(value, float | int):
        return value
    with restated(field, field=field):
        return _number(value, unit)


@lru_cache
def _plain(kind: Any) -> dict[str, str | None]:
    """The fields of a class that are no laws, and the units of their numbers; None for those that have none."""
    found: dict[str, str | None] = {}
    for field in fields(kind):
        measure = measures(kind).get(field.name)
        if measure and measure.over == "1" and not measure.outputs:
            unit = DIRECTION if measure.direction else measure.unit
            found[field.name] = unit or (ANY if field.name == "parameters" else None)
    return found


def _number(value: Any, unit: str | None) -> Any:
    """A number, or numbers, of what the user gives; the same object if it has no text."""
    if unit == DIRECTION and isinstance(value, str | Expression):
        return formula_value(
            tree := parse(value) if isinstance(value, str) else value, _unit_of_direction(tree)
        )
    if unit == DIRECTION and _is_pair(value):
        value = _between(value)
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
    if isinstance(value, np.ndarray) and value.dtype == object and value.ndim:
        return _number(value.tolist(), unit)
    return formula_value(value, unit or None) if isinstance(value, Expression) and unit is not None else value


def _unit_of_direction(tree: Expression) -> str:
    """The unit of a component of a direction: none, or that of a vector between points."""
    return "m" if fits(unit_of(tree, {}), "m") else "1"


def _is_pair(value: Any) -> bool:
    """Whether a direction is given by two points."""
    return is_list(value) and len(value) == 2 and all(is_list(point) and len(point) == 3 for point in value)


def _between(points: Any) -> list[Expression]:
    """The vector from one point to another.

    Raises
    ------
    ModelError
        If they are equal.
    """
    first, second = ([parse(x) if isinstance(x, str) else lift(x) for x in point] for point in points)
    found = [b - a for a, b in zip(first, second, strict=True)]
    if not any(float(x.value()) for x in found):
        raise ModelError("is through two equal points. Move one of them.")
    return found
