"""A number, or a function of one variable in one of the ways that a person may give it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

from .curve import Curve, Formula, curve_of
from .quantity import is_list, number

Law: TypeAlias = float | Curve | Formula | Callable[[Any], Any] | Sequence[Sequence[float]]


class Scaled(NamedTuple):
    """A factor, which is a design number, and the curve that it scales."""

    factor: float
    curve: Curve | Formula


def varies(value: Any) -> bool:
    """Return whether a law is more than a number."""
    return isinstance(value, Curve | Formula) or callable(value) or is_list(value)


def scaled(value: Any, field: str) -> Scaled:
    """Return a law as a factor and a curve: a number scales the curve 1, and a function is scaled by 1.

    Raises
    ------
    ModelError
        If it is neither a finite number nor a table, a curve or a function that can be recorded.
    """
    if not varies(value):
        return Scaled(number(value, field), Curve.constant(1.0))
    curve = curve_of(value, field)
    if isinstance(curve, Formula):
        curve.numbers(field)
    return Scaled(1.0, curve)
