"""Does a number with a unit fit the number of the model in whose place it is put?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..model import Model, SarrusError, parse_expression
from ..model.expression.dimensions import fits, unit_of
from ..model.expression.units import unit_text
from ..model.measure import measures


def refuse_other_units(model: Model, name: str, given: Any) -> None:
    """Raise a SarrusError for a text among the values of a number, ``5 kN/m``, that is in another unit than it."""
    unit = unit_of_number(model, name)
    for text in _texts(given) if unit else ():
        powers = unit_of(parse_expression(text), {})
        if not fits(powers, unit):
            expected = "a plain number" if unit == "1" else unit
            message = f"{name} expects {expected}, but {text!r} is in {unit_text(powers or {})}"
            raise SarrusError(f"{message}; give it in {expected}, or leave the unit away")


def unit_of_number(model: Model, name: str) -> str:
    """The unit of a number of the model, as its part declares it; none for parameters, and numbers in functions."""
    part, *path = name.split(".")
    if part == "gravity":
        return "m/s^2"
    parts = [one for section in model.sections().values() for one in section if one.name == part]
    kind: Any = type(parts[0]) if parts else Model
    measure = measures(kind).get(path[0]) if parts and path else None
    if measure is None or (measure.over != "1" and len(path) > 1):
        return ""
    return measure.unit


def _texts(given: Any) -> Iterator[str]:
    """The texts of a value, a list of values, or the limits of a range; not the name of a distribution."""
    if isinstance(given, str):
        yield given
    elif isinstance(given, Mapping):
        yield from (value for key, value in given.items() if key != "distribution" and isinstance(value, str))
    elif isinstance(given, list | tuple):
        yield from (value for value in given if isinstance(value, str))
