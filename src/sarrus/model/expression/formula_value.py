"""Numbers that formulas gave, which remember the formula: so that they follow the parameters of a model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from .parser import parse
from .quantity import quantity_of
from .tree import Expression, Name, Number

Definitions: TypeAlias = Mapping[str, Number]  # parameters by name, each with the unit in which it was given


class FormulaValue(float):
    """A number that a formula gave.

    Attributes
    ----------
    expression
        The formula, with names of parameters.
    tables
        The tables in which Python code defined these parameters; none for those of a model file.
    """

    expression: Expression
    tables: tuple[Definitions, ...] = ()

    def __reduce__(self) -> Any:
        return _formula_value, (float(self), self.expression, self.tables)


@dataclass(frozen=True, eq=False)
class ParameterValue(Number):
    """The value of the parameter ``of`` in a formula, with the table in which it is defined."""

    table: Definitions = field(default_factory=dict, repr=False)


def formula_value(tree: Expression, unit: str | None) -> float:
    """Return the number that a formula without names gives; it remembers the parameters of which it is made.

    Raises
    ------
    ModelError
        If the formula has names, or another unit; see `quantity_of`.
    """
    value, tables = quantity_of(tree, unit).value, tables_in([tree])
    if not tables:
        return value
    named = tree.rebuilt(lambda node: Name(node.of) if isinstance(node, ParameterValue) else None)
    return _formula_value(value, named, tables)


def negative(value: Any) -> Any:
    """Return a number with the other sign, also if a formula gave it; of a text the formula."""
    if isinstance(value, FormulaValue):
        return _formula_value(-float(value) if value else 0.0, -value.expression, value.tables)
    if isinstance(value, str):
        return -parse(value)
    return -value if isinstance(value, Expression) or value else value


def tables_in(trees: Iterable[Expression]) -> tuple[Definitions, ...]:
    """Return the tables in which the parameters of formulas are defined, each once."""
    nodes = (node for tree in trees for node in tree.nodes())
    return tuple({id(node.table): node.table for node in nodes if isinstance(node, ParameterValue)}.values())


def _formula_value(value: float, tree: Expression, tables: tuple[Definitions, ...] = ()) -> FormulaValue:
    found = FormulaValue(value)
    found.expression, found.tables = tree, tables
    return found
