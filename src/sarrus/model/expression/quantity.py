"""A number with a unit, given as a text: ``"30 deg"``, ``"1 um"``."""

from __future__ import annotations

from ..errors import ModelError
from ..show import quote
from .dimensions import fits, unit_of
from .parser import parse_expression


def quantity(text: str, unit: str | None) -> float:
    """The value of a text in SI units; `unit` is its kind, None for any.

    Raises
    ------
    ModelError
        If it is no number, or in a unit of another kind.
    """
    tree = parse_expression(text)
    if unit is not None and not fits(unit_of(tree, {}), unit):
        raise ModelError(f"must be in {unit}, or another unit of that kind, got {quote(text)}. Convert it.")
    return float(tree.value({}))
