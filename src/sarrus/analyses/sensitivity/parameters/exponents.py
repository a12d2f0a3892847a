"""Parameters of a model file that are exponents in formulas: as whole ones are products, exponents are constants."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from ....model import Model
from ....model.expression import Call, Expression, Number
from ....model.quantity import is_list


def parameters_in_exponents(model: Model) -> dict[str, str]:
    """Return the parameters of the file that are exponents, with a part in whose formula each is."""
    return {
        exponent.of: part.name
        for parts in model.sections().values()
        for part in parts
        for tree in _trees(part)
        for node in tree.nodes()
        if isinstance(node, Call) and node.function.name == "**"
        for exponent in node.args[1:]
        if isinstance(exponent, Number) and exponent.of
    }


def _trees(value: Any) -> Iterator[Expression]:
    """Yield all formulas of a part."""
    if isinstance(value, Expression):
        yield value
        return
    entries = list[Any]()
    if is_dataclass(value) and not isinstance(value, type):
        entries = [getattr(value, field.name) for field in fields(value)]
    elif isinstance(value, Mapping):
        entries = [*value.values()]
    elif is_list(value):
        entries = [*value]
    for entry in entries:
        yield from _trees(entry)
