"""Laws: a number, or a function of one variable, given as a formula, a table, a curve or a Python function."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias

from ..errors import ModelError
from ..expression import Expression, parse
from ..quantity import is_list, number
from ..show import show
from .curve import Curve, Formula, curve_of
from .prescribed import formula, parsed

Law: TypeAlias = float | Curve | Formula | Expression | str | Callable[[Any], Any] | Sequence[Sequence[float]]


class ScaledCurve(NamedTuple):
    """A factor, which is a design number, and the curve that it scales."""

    factor: float
    curve: Curve | Formula


def varies(value: Any) -> bool:
    """Return whether a law is more than a number, or than a formula of numbers alone."""
    if isinstance(value, str):
        try:
            value = parse(value)
        except ModelError:
            return True  # `scaled` reports it, with the name of the field
    if isinstance(value, Expression):
        return bool(value.names())
    return isinstance(value, Curve | Formula) or callable(value) or is_list(value)


def scaled(value: Any, field: str, variable: str = "x") -> ScaledCurve:
    """Return a law as a factor and a curve: a number scales the curve 1, and a function is scaled by 1.

    Parameters
    ----------
    value : what the user gives
    field : its name
    variable : what its formulas are in: t for the time, x for all else

    Raises
    ------
    ModelError
        If it is neither a finite number nor a formula, a table, a curve or a function that can be recorded.
    """
    if isinstance(value, str):
        value = parsed(value, field, variable)
    if isinstance(value, Expression):
        return ScaledCurve(*formula(value, field, variable))
    if not varies(value):
        return ScaledCurve(number(value, field), Curve.constant(1.0))
    curve = curve_of(value, field)
    if isinstance(curve, Formula):
        curve.numbers(field)
    return ScaledCurve(1.0, curve)


@contextmanager
def of_one_variable(part: Any) -> Iterator[None]:
    """Errors about laws of a part name the force that takes formulas of several variables, if there is one.

    Raises
    ------
    ModelError
    """
    try:
        yield
    except ModelError as error:
        other = getattr(part, "of_several", "")
        if not other or not error.message.endswith("."):
            raise
        message = f"{error.message.removesuffix('.')}, or use {other}."
        raise ModelError(message, field=error.field) from None


def refuse_negative(factor: float, field: str) -> None:
    """Raise a ModelError for a stiffness or damping that is a negative number.

    Raises
    ------
    ModelError
    """
    if factor < 0:
        raise ModelError(
            f"{field} must not be negative, but is {show(factor)}. For an unstable spring or a driven damper give a "
            f"law, such as lambda x: {show(factor)}.",
            field=field,
        )
