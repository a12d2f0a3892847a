"""Laws: a number, or a function of one variable, given as a formula, a table, a curve or a Python function."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias

from ..errors import ModelError
from ..expression import Expression, parse, parse_expression
from ..expression.tree import Name, Number
from ..quantity import is_list, number, plain
from ..show import quote, show
from ..tape import Tracer
from .curve import Curve, Formula, Tree, curve_of
from .jumps import TIME
from .recorded import arguments, has_all_outputs

Law: TypeAlias = float | Curve | Formula | Expression | str | Callable[[Any], Any] | Sequence[Sequence[float]]
ONE_NUMBER = "Give one finite number."
OF_OUTPUTS = "For a motion that depends on outputs other than states, use sr.Torque or sr.Force."
FORMS = 'a function of t, lambda t: ..., or of states, lambda o: o["lag"] + o.t'


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


def scaled(value: Any, field: str, variable: str = "x", remedy: str = ONE_NUMBER) -> ScaledCurve:
    """Return a law as a factor and a curve: a number scales the curve 1, and a function is scaled by 1.

    Parameters
    ----------
    value : what the user gives
    field : its name
    variable : what its formulas are in: t for the time, x for all else
    remedy : for what is no law

    Raises
    ------
    ModelError
        If it is neither a finite number nor a formula, a table, a curve or a function that can be recorded.
    """
    if isinstance(value, str):
        value = parsed(value, field, variable)
    if isinstance(value, Expression):
        value = _in_one_variable(value, field, variable)
    if not varies(value):
        return ScaledCurve(number(value, field, remedy), Curve.constant(1.0))
    curve = curve_of(value, field)
    if isinstance(curve, Formula):
        curve.numbers(field)  # refused here, where the name of the part is known
    return ScaledCurve(1.0, curve)


def _in_one_variable(tree: Expression, field: str, variable: str) -> float | Formula:
    """Return the function of a formula; its value where it has no names, which may be a traced number."""
    others = [name for name in tree.names() if name != variable]
    if others:
        message = f"{field} depends on {quote(others[0])}. Use only {variable} in it."
        raise ModelError(f"{message} {OF_OUTPUTS}" if variable == TIME else message, field=field)
    return Formula(Tree(tree, variable)) if tree.names() else plain(_constant(tree))


def _constant(tree: Expression) -> Any:
    """The value of a formula without names: a traced number if one of its numbers is."""
    traced: dict[str, Any] = {}

    def mark(n: int, one: Number) -> Any:
        value: Any = one.number
        if not isinstance(value, Tracer):
            return one
        traced[f"#{n + 1}"] = value
        return Name(f"#{n + 1}")

    return tree.exchanged(mark).value(traced)


def motion_of(value: Law, field: str, states: bool = True) -> ScaledCurve:
    """Return the law of a motion f(t); a message on it names states if drivers may follow these.

    Raises
    ------
    ModelError
        If it is no number, formula in t, table or function, or cannot be differentiated.
    """
    try:
        return scaled(value, field, TIME, "Give a number, a formula in t, a table or a function.")
    except ModelError:
        if states and callable(value) and len(wanted := arguments(value, {TIME})) > 1:
            message = f"{field} must be {FORMS}, but is one of {', '.join(wanted)}"
            raise ModelError(f"{message}. Use one argument.", field=field) from None
        if callable(value) and has_all_outputs(value, {TIME}):
            raise ModelError(f"{field} is a function of outputs. {OF_OUTPUTS}", field=field) from None
        raise


def parsed(text: str, field: str, variable: str) -> Expression:
    """Return the formula in a variable that a text gives."""
    try:
        tree = parse_expression(text, variables=(variable,))
    except ModelError as error:
        message = f"{field} {error.message}"
        if variable == TIME and "unknown name" in message:  # of an output or a state, perhaps
            message += f" {OF_OUTPUTS}"
        raise ModelError(message, field=field) from None
    units = [node.written for node in tree.nodes() if isinstance(node, Number) and node.unit]
    taken = next((unit for unit in units if variable in re.split(r"[^A-Za-z]+", unit)), None)
    if taken is not None:
        message = f"{field} {quote(text)}: {variable} counts as a unit, the tonne, in {quote(taken)}"
        raise ModelError(f"{message}. Write a space on each side of the sign before {variable}.", field=field)
    return tree


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
