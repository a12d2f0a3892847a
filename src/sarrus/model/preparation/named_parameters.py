"""Parameters that Python code defined by name, such as hardpoints, found in the parts of a model that is created."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeAlias

from ..checks.findings import PAIRS, Path
from ..errors import ModelError
from ..expression import Expression, Number
from ..expression.formula_value import Definitions, FormulaValue, ParameterValue, tables_in
from ..geometry.points import Frame, Point, Solid
from ..laws.curve import Curve, Formula, Tree
from ..laws.formulas import Formulas
from ..laws.surface import Surface
from ..quantity import is_list
from ..show import quote

GRAVITY = "gravity"
Located: TypeAlias = tuple[Path, FormulaValue | Expression]  # a formula with its path in a model file


def formulas_in(sections: Mapping[str, Sequence[Any]], gravity: Any) -> list[Located]:
    """All formulas of the parts of a model and of its gravity, see `formulas_of`."""
    return [*formulas_of(sections), *_within(gravity, (GRAVITY,))]


def with_named_parameters(formulas: Formulas, found: Sequence[Located]) -> Formulas:
    """Return formulas with the parameters in those of a model's parts, and the formulas of numbers in these."""
    new: dict[str, Number] = {}
    for table in _tables(found):
        for name, one in table.items():
            if name not in formulas.definitions:
                new.setdefault(name, one)
    own = {path: x.expression for path, x in found if isinstance(x, FormulaValue) and x.tables}
    if not own and not new:
        return formulas
    return replace(
        formulas,
        parameters={**formulas.parameters, **{name: float(one.number) for name, one in new.items()}},
        expressions={**formulas.expressions, **own},
        definitions={**formulas.definitions, **new},
        hardpoints={**formulas.hardpoints, **_hardpoints(new)},
    )


def refuse_two_values(formulas: Formulas, found: Iterable[Located]) -> None:
    """Refuse formulas of numbers with different values for the same name, or with another than the model's.

    Raises
    ------
    ModelError
    """
    known = dict(formulas.parameters)
    for _, value in found:
        for name, number in _used(value):
            if known.setdefault(name, number) != number:
                message = f"its parts use two values of {quote(name)}, {known[name]:g} and {number:g}"
                raise ModelError(
                    f"{message}. Use one table of hardpoints, and change it with with_parameters."
                )


def _used(value: FormulaValue | Expression) -> Iterator[tuple[str, float]]:
    """The parameters of Python code in a formula with the values of its tables, without numbers that were changed."""
    if isinstance(value, FormulaValue):
        names = value.expression.names()
        yield from ((name, table[name].number) for table in value.tables for name in names if name in table)
        return
    for node in value.nodes():
        if isinstance(node, ParameterValue) and node.number == (own := node.table[node.of].number):
            yield node.of, own


def _tables(found: Iterable[Located]) -> list[Definitions]:
    """The tables in which the parameters of formulas are defined, each once."""
    tables: dict[int, Definitions] = {}
    for _, value in found:
        own = value.tables if isinstance(value, FormulaValue) else tables_in([value])
        tables |= {id(table): table for table in own}
    return [*tables.values()]


def _hardpoints(definitions: Definitions) -> dict[str, str]:
    """The names of the points whose coordinates are defined, each with its unit."""
    return {name.rpartition(".")[0]: one.written.partition(" ")[2] for name, one in definitions.items()}


def formulas_of(sections: Mapping[str, Sequence[Any]]) -> Iterator[Located]:
    """Yield every number of a formula, and every formula, with its path in a model file."""
    for section, parts in sections.items():
        for part in parts:
            if is_dataclass(part.__class__):
                for field in fields(part):
                    yield from _in_field(part, field.name, (section, str(getattr(part, "name", ""))))


def _in_field(part: Any, field: str, path: Path) -> Iterator[Located]:
    stem, _, side = field.rpartition("_")
    paired = stem in PAIRS and hasattr(part, f"{stem}_i") and hasattr(part, f"{stem}_j")
    yield from _within(
        getattr(part, field, None), (*path, PAIRS[stem], "ij".index(side)) if paired else (*path, field)
    )


def _within(value: Any, path: Path) -> Iterator[Located]:
    if isinstance(value, FormulaValue | Expression):
        yield path, value
    elif isinstance(value, float | int | str | Solid | Curve | Surface) or value is None:
        return
    elif isinstance(value, Point):
        yield from _within(value.coordinates, (*path, "at" if value.axes == "body" else "global"))
    elif isinstance(value, Frame):
        yield from _within(value.point, path)
        for axis in ("x", "z"):
            yield from _within(getattr(value, axis), (*path, axis))
    elif isinstance(value, Formula):
        if isinstance(value.function, Tree):
            yield path, value.function.tree
    elif isinstance(value, Mapping):
        for key, entry in value.items():
            yield from _within(entry, (*path, str(key)))
    elif is_list(value):
        for n, entry in enumerate(value):
            yield from _within(entry, (*path, n))
    elif is_dataclass(value) and not isinstance(value, type):
        for one in fields(value):
            yield from _within(getattr(value, one.name), (*path, one.name))
