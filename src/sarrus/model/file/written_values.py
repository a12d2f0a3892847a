"""Values of a part's fields in the form of a model file: the inverse of `fields`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from ..errors import ModelError
from ..expression import Expression, parse
from ..expression.tree import Name
from ..forces.by_formula import has_outputs
from ..geometry.frame import Frame
from ..geometry.point import Point
from ..geometry.solid import Solid
from ..laws.curve import Curve, Formula, Tree
from ..laws.law import Law
from ..laws.text_units import variable_of
from ..measure import Typed, typed
from ..quantity import is_list

GIVE_TEXT = 'Give a formula as a text, as in "50 + 10*x", or a table of pairs [x, y].'


class Spot(list[float]):
    """Global coordinates, for which the name of a point of the file may stand."""


def written(value: Any, hint: Any = None, field: str = "") -> Any:
    """Return a value as mappings, lists, numbers and texts; formulas stay formulas.

    Parameters
    ----------
    value
        What a field has.
    hint
        The field's annotation, which distinguishes laws from lists, and formulas in t from those in x.
    field
        Its name, for messages.

    Raises
    ------
    ModelError
        If a file cannot have it, as a Python function of operations that formulas do not have.
    """
    kind = typed(hint)
    if Curve in kind.members:
        return _law(value, kind, field)
    if Sequence[Law] in kind.members and is_list(value):
        return [_law(part, kind, field) for part in value]
    found = _plain(value)
    return Spot(found) if kind.measure.named and isinstance(found, list) else found


def _plain(value: Any) -> Any:
    if isinstance(value, Solid):
        return value.name
    if isinstance(value, Point):
        place = [float(x) for x in value.coordinates]
        return {
            "body": value.body.name,
            **({"at": place} if value.axes == "body" else {"global": Spot(place)}),
        }
    if isinstance(value, Frame):
        return {**_plain(value.point), **_given({"x": value.x, "z": value.z})}
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    if is_dataclass(value) and not isinstance(value, type | Expression):
        own = {one.name: one.default for one in fields(value)}
        return {
            key: _plain(getattr(value, key)) for key in own if repr(getattr(value, key)) != repr(own[key])
        }
    if is_list(value):
        return [_plain(entry) for entry in value]
    return value if value is None or isinstance(value, str | bool | Expression) else float(value)


def _given(entries: Mapping[str, Any]) -> dict[str, Any]:
    return {key: _plain(value) for key, value in entries.items() if value is not None}


def _law(value: Any, kind: Typed, field: str) -> Any:
    """Return a number, a formula or a table."""
    variable = variable_of(kind.measure.over)
    if isinstance(value, str):
        return parse(value)
    if isinstance(value, Curve):
        if not value.pairs:
            message = f"{field} is a curve of cubics, which a model file cannot contain"
            raise ModelError(f"{message}. Make it of a table, with Curve.table.", field=field)
        return {"table": _plain(value.pairs), **({"periodic": True} if value.periodic else {})}
    if kind.measure.outputs and callable(value) and (kind.measure.over == "1" or has_outputs(value)):
        raise ModelError(
            f"{field} is a Python function of outputs, which a model file cannot contain. Give a formula as a text.",
            field=field,
        )
    if isinstance(value, Formula):
        return value.function.tree if isinstance(value.function, Tree) else _recorded(value, variable, field)
    if callable(value):
        return _recorded(Formula(value), variable, field)
    return {"table": _plain(value)} if is_list(value) else _plain(value)


def _recorded(law: Formula, variable: str, field: str) -> Expression:
    """Return the formula that a Python function does, if it is the same to the last operation."""
    function: Callable[[Any], Any] = law.function
    try:
        tree = function(Name(variable))
        if isinstance(tree, Expression) and Formula(Tree(tree, variable)).numbers() == law.numbers(field):
            return tree
    except (TypeError, ValueError, AttributeError, ArithmeticError):
        pass
    raise ModelError(
        f"{field} is a Python function, which a model file cannot contain. {GIVE_TEXT}", field=field
    )
