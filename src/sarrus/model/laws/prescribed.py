"""A prescribed motion f(t): a number, a formula in t, a table or a Python function."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

from ..errors import ModelError
from ..expression import Expression, parse_expression
from ..expression.tree import Number
from ..quantity import number
from ..show import quote
from .curve import Curve, Formula, Tree, curve_of
from .recorded import arguments, has_all_outputs

Motion: TypeAlias = (
    float | Curve | Formula | Expression | str | Sequence[Sequence[float]] | Callable[[Any], Any]
)
VARIABLE = "t"
OF_OUTPUTS = "For a motion that depends on outputs other than states, use sr.Torque or sr.Force."
FORMS = 'a function of t, lambda t: ..., or of states, lambda o: o["lag"] + o.t'


class Law(NamedTuple):
    """A factor and the function of time that it scales."""

    scale: float
    curve: Curve | Formula


def motion_of(value: Motion, field: str, states: bool = True) -> Law:
    """Return the law of what a user gives for a motion; a message on it names states if drivers may follow these.

    Raises
    ------
    ModelError
        If it is no number, formula in t, table or function, or cannot be differentiated.
    """
    given: Any = parsed(value, field) if isinstance(value, str) else value
    if isinstance(given, Expression):
        return formula(given, field)
    if isinstance(given, (Curve, Formula)) or callable(given) or isinstance(given, Sequence):
        try:
            return _checked(curve_of(given, field), field)
        except ModelError:
            if states and callable(value) and len(wanted := arguments(value, {VARIABLE})) > 1:
                message = f"{field} must be {FORMS}, but is one of {', '.join(wanted)}"
                raise ModelError(f"{message}. Use one argument.", field=field) from None
            if callable(value) and has_all_outputs(value, {VARIABLE}):
                raise ModelError(f"{field} is a function of outputs. {OF_OUTPUTS}", field=field) from None
            raise
    return Law(
        number(given, field, "Give a number, a formula in t, a table or a function."), Curve.constant(1.0)
    )


def parsed(text: str, field: str, variable: str = VARIABLE) -> Expression:
    """Return the formula in a variable that a text gives."""
    try:
        tree = parse_expression(text, variables=(variable,))
    except ModelError as error:
        message = f"{field} {error.message}"
        if variable == VARIABLE and "unknown name" in message:  # of an output or a state, perhaps
            message += f" {OF_OUTPUTS}"
        raise ModelError(message, field=field) from None
    units = [node.written for node in tree.nodes() if isinstance(node, Number) and node.unit]
    taken = next((unit for unit in units if variable in re.split(r"[^A-Za-z]+", unit)), None)
    if taken is not None:
        message = f"{field} {quote(text)}: {variable} counts as a unit, the tonne, in {quote(taken)}"
        raise ModelError(f"{message}. Write a space on each side of the sign before {variable}.", field=field)
    return tree


def formula(tree: Expression, field: str, variable: str = VARIABLE) -> Law:
    """Return the law of a formula in a variable."""
    others = [name for name in tree.names() if name != variable]
    if others:
        message = f"{field} depends on {quote(others[0])}. Use only {variable} in it."
        raise ModelError(f"{message} {OF_OUTPUTS}" if variable == VARIABLE else message, field=field)
    if not tree.names():
        return Law(number(float(tree.value()), field), Curve.constant(1.0))
    return _checked(Formula(Tree(tree, variable)), field)


def _checked(curve: Curve | Formula, field: str) -> Law:
    if isinstance(curve, Formula):
        curve.numbers(field)  # refused here, where the driver's name is known
    return Law(1.0, curve)
