"""A number with a unit, given as a text: ``"30 deg"``, ``"1 um"``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ..errors import ModelError
from ..show import quote
from .parser import parse, parse_expression
from .tree import Expression, Name
from .units import fits, unit_of


class Quantity(NamedTuple):
    """A number in SI units, and the powers of the units of its text."""

    value: float
    powers: Mapping[str, float]


def quantity(text: str, unit: str | None) -> float:
    """The value of a text in SI units; `unit` is its kind, None for any.

    Raises
    ------
    ModelError
        If it is no number, or in a unit of another kind.
    """
    tree = parse(text)
    return quantity_of(tree if isinstance(tree, Name) else parse_expression(text), unit, text).value


def quantity_of(tree: Expression, unit: str | None, text: str = "") -> Quantity:
    """The value of a formula of numbers, and its unit; see `quantity`."""
    shown = quote(text or str(tree))
    if tree.names():
        kind = f" in {unit}, or with its unit" if unit and unit != "1" else ""
        raise ModelError(f"must be a number, got {shown}. Give a number{kind}.")
    powers = unit_of(tree, {})
    if unit is not None and not fits(powers, unit):
        wanted = "a plain number" if unit == "1" else f"in {unit}, or another unit of that kind"
        raise ModelError(f"must be {wanted}, got {shown}. Convert it.")
    return Quantity(float(tree.value({})), powers or {})
