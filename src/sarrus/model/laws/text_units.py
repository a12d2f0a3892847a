"""The unit of a formula in a text must fit the place where it is given: one check for files and for Python."""

from __future__ import annotations

import re
from collections import ChainMap
from collections.abc import Iterator, Mapping
from typing import Any

from ..errors import ModelError, restated
from ..expression import Expression
from ..expression.tree import Number
from ..expression.units import Powers, fits, powers_of, unit_of, unit_text
from ..measure import In, measures_of
from ..quantity import is_list
from ..show import quote
from . import recorded
from .law import of_one_variable, parsed

TONNE = re.compile(r"([\d.]+ ?[A-Za-z][\w/^*]*?)\*t\b")  # "3 m*t": a unit goes on to the next space


class _WrongUnit(ModelError):
    """A formula whose terms fit together, but not its place."""


def variable_of(over: str) -> str:
    """Return the name of a formula's variable: t for time, x for anything else."""
    return "t" if over == "s" else "x"


def check_unit(
    tree: Expression,
    text: str,
    unit: str,
    units: Mapping[str, Powers],
    variables: Mapping[str, Powers] | None = None,
) -> None:
    """Refuse a formula whose value is in another unit than its place expects.

    Parameters
    ----------
    tree, text
        The formula.
    unit
        That of its place; none accepts every unit.
    units, variables
        Those of its names.

    Raises
    ------
    ModelError
    """
    found = unit_of(tree, ChainMap({**(variables or {})}, {**units}))
    if not unit or fits(found, unit):
        return
    expected = "a plain number" if unit == "1" else unit
    message = f"expects {expected}, but {quote(text)} is in {unit_text(found or {})}"
    if variables and (tonne := TONNE.search(text)):
        raise _WrongUnit(
            f"{message}, for t after {quote(tonne[1])} is read as a tonne. Write {quote(tonne[1] + ' * t')}."
        )
    raise _WrongUnit(f"{message}. Give it in {expected}, or omit the unit.")


def check_function_unit(
    tree: Expression, text: str, measure: In, units: Mapping[str, Powers] | None = None
) -> None:
    """Refuse a unit that does not fit, be the variable a number with its unit or, as in sin(2*pi*t), without.

    Raises
    ------
    ModelError
    """
    name, known = variable_of(measure.over), units or {}
    errors = list[ModelError]()
    for variable in (powers_of(measure.over), {}):
        try:
            return check_unit(tree, text, measure.unit, known, {name: variable})
        except ModelError as error:
            errors.append(error)
    raise next((one for one in errors if isinstance(one, _WrongUnit)), errors[0])


def check_texts(part: Any) -> None:
    """Refuse a joint, driver or force whose laws are texts in units that do not fit.

    Raises
    ------
    ModelError
        With the name of the field.
    """
    for field, measure in _laws(part).items():
        for given in _formulas(getattr(part, field, None)):
            variable = variable_of(measure.over)
            if measure.outputs and _names(given, field) - {variable}:
                continue  # checked where the units of the outputs are known
            with of_one_variable(part):
                tree = given if isinstance(given, Expression) else parsed(given, field, variable)
            with restated(field, field=field):
                check_function_unit(tree, str(given), measure)


def _laws(part: Any) -> dict[str, In]:
    """The fields of a part that may hold a formula in a variable, and what they measure."""
    return {field: measure for field, measure in measures_of(part).items() if measure.over != "1"}


def _formulas(value: Any) -> Iterator[str | Expression]:
    """The formulas of a law, or of three; a file has checked those with names, which are numbers by now."""
    for one in value if is_list(value) else (value,):
        if isinstance(one, str) or (isinstance(one, Expression) and not has_parameters(one)):
            yield one


def _names(given: str | Expression, field: str) -> set[str]:
    return set((given if isinstance(given, Expression) else recorded.parsed(given, field)).names())


def has_parameters(tree: Expression) -> bool:
    """Return whether a formula has values of parameters of a file, whose units it does not know."""
    return any(isinstance(node, Number) and node.of for node in tree.nodes())
