"""A model as the plain data of a model file: mappings, lists, numbers and texts, in the layout that `load` reads."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any

from ..bodies.body import Body
from ..checks.findings import Findings, Path
from ..drivers import Driver
from ..errors import ModelError
from ..expression import Expression, Number, parse
from ..expression.tree import Name
from ..forces import Force
from ..forces.by_formula import has_outputs
from ..geometry.points import Frame, Point, Solid
from ..hardpoints import written_number
from ..joints import Joint
from ..laws.curve import Curve, Formula, Tree
from ..laws.law import Law
from ..laws.surface import Surface
from ..laws.text_units import variable_of
from ..measure import TypedField, typed
from ..model import Model, registered_kinds
from ..quantity import is_list
from ..registry import kind_name
from .forms import Slot, refuse_undescribable, slots
from .layout import layout

DIGITS = range(6, 18)  # of a number in the unit of the file
GIVE_TEXT = 'Give a formula as a text, as in "50 + 10*x", or a table of pairs [x, y].'


class Spot(list[float]):
    """Global coordinates, for which the name of a point of the file may stand."""


class Axis(list[float]):
    """A direction, which may be given by two points of the file."""


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
    if kind.measure.direction and isinstance(found, list):
        return Axis(found)
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
        return {
            **_plain(value.point),
            **{key: Axis(x) for key, x in _given({"x": value.x, "z": value.z}).items()},
        }
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


def _law(value: Any, kind: TypedField, field: str) -> Any:
    """Return a number, a formula, a table or a surface."""
    variable = variable_of(kind.measure.over)
    if isinstance(value, str):
        return parse(value)
    if isinstance(value, Surface):
        return {name: getattr(value, name).tolist() for name in ("x", "y", "z")}
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


def plain_data(model: Model, folder: FilePath, *, complete: bool = False) -> dict[str, Any]:
    """Return the data of the file of a model in a folder; ``complete`` with the keys that have their defaults.

    Raises
    ------
    ModelError
        For the first part that a file cannot describe, with its name and a remedy.
    """
    return _Writer(model, folder, complete).whole()


@dataclass
class _Writer:
    """Writes the sections of one model."""

    model: Model
    folder: FilePath
    complete: bool
    findings: Findings = field(init=False)

    def __post_init__(self) -> None:
        self.findings = Findings(self.model.origin)

    def whole(self) -> dict[str, Any]:
        """Return all sections that are not empty, in the order of the layout."""
        sections: dict[str, Any] = {
            "name": self.model.name,
            "gravity": written(self.model.gravity) if self.complete or any(self.model.gravity) else [],
            "parameters": self._parameters(),
            "hardpoints": self._hardpoints(),
            "points": self._points(),
            **{
                name: {part.name: self._part(name, part) for part in parts}
                for name, parts in self.model.sections().items()
            },
            "rates": {name: float(rate) for name, rate in self.model.rates.items()},
            "outputs": dict(self.model.outputs),
        }
        self.findings.raise_first()
        known = (one.alias or name for name, one in layout().model_fields.items())
        texts = {name: self._texts(sections[name], (name,)) for name in known if sections.get(name)}
        return texts

    def _parameters(self) -> dict[str, Any]:
        formulas, parameters = self.model.formulas, dict[str, Any]()
        coordinates = {f"{name}.{axis}" for name in formulas.hardpoints for axis in "xyz"}
        for name, value in formulas.parameters.items():
            if name in coordinates:
                continue
            group, _, inner = name.rpartition(".")
            holder = parameters.setdefault(group, {}) if group else parameters
            holder[inner] = formulas.definitions.get(name, float(value))
        return parameters

    def _hardpoints(self) -> dict[str, Any]:
        """Return the table of hardpoints, each coordinate as it is given."""
        formulas, units = self.model.formulas, [*self.model.formulas.hardpoints.values()]
        unit = max(units, key=units.count) if units else "m"
        return (
            {"unit": unit}
            | {
                name: [self._coordinate(formulas.definitions[f"{name}.{axis}"], unit) for axis in "xyz"]
                for name in formulas.hardpoints
            }
            if units
            else {}
        )

    def _coordinate(self, tree: Expression, unit: str) -> str | float:
        """Return a coordinate as a number in the unit of the table, or a text."""
        number, own = written_number(tree)
        if number:
            return float(number) if own == unit else f"{number} {own}"
        if not isinstance(tree, Number):
            return self._text(tree)
        value = float(tree.number)
        text = in_unit(value, unit)
        return float(text.partition(" ")[0]) if text else f"{value!r} m"

    def _points(self) -> dict[str, Any]:
        trees = self.model.formulas.expressions
        return {
            name: [trees.get(("points", name, n), float(x)) for n, x in enumerate(place)]
            for name, place in self.model.formulas.points.items()
        }

    def _part(self, section: str, part: Body | Joint | Driver | Force) -> dict[str, Any]:
        entry: dict[str, Any] = {}
        with self.findings.about(section, part.name):
            kind: Any = type(part)
            if isinstance(part, Body):
                part, kind = self._drawn(part), Body
            else:
                entry["type"] = self._type(section, kind)
            for slot in slots(kind):
                value = _slot_value(slot, part)
                if self._needed((section, part.name, slot.key), slot, value):
                    entry[slot.key] = value
        return entry

    def _type(self, section: str, kind: type) -> str:
        """Return the type of a joint, driver or force, if files can describe its class."""
        if registered_kinds()[section].get(kind_name(kind)) is not kind:
            raise ModelError(
                f"its class {kind.__name__} is not registered. Define it in a module of its own."
            )
        refuse_undescribable(kind)
        return kind_name(kind)

    def _drawn(self, body: Body) -> Body:
        """Return a body whose mesh is named from the folder of the file, if it is in it or below."""
        if body.shape is None:
            return body
        mesh = os.path.abspath(self.model.folder_of(body.name) / body.shape.file)
        home = os.path.abspath(self.folder)
        file = os.path.relpath(mesh, home) if FilePath(mesh).is_relative_to(home) else mesh
        return replace(body, shape=replace(body.shape, file=FilePath(file).as_posix()))

    def _needed(self, path: Path, slot: Slot, value: Any) -> bool:
        """Whether a key is written: it has no default, another value, a formula, or a formula of the file names it."""
        if value is None or value == {}:
            return False
        if self.complete or slot.default is MISSING or path in self._mentioned:
            return True
        return repr(value) != repr(written(slot.default, slot.hint))

    @cached_property
    def _mentioned(self) -> set[Path]:
        """The keys of parts that have formulas, and those that formulas use."""
        formulas = self.model.formulas
        paths: set[Path] = {path[:3] for path in formulas.expressions}
        for name in formulas.definitions:
            part, *steps = name.split(".")
            paths |= {(section, part, steps[0]) for section in self.model.sections() if steps}
        return paths

    @cached_property
    def _values(self) -> dict[str, Any]:
        return self.model.formulas.values()

    def _texts(self, value: Any, path: Path) -> Any:
        """Return data with texts in the place of formulas, and of numbers that formulas of the file give."""
        if isinstance(value, Expression):
            return self._text(value)
        if isinstance(value, dict):
            return {key: self._texts(entry, (*path, key)) for key, entry in value.items()}
        if isinstance(value, list):
            if isinstance(value, Spot) and (name := self._point_at(value, path)):
                return name
            texts = [self._texts(entry, (*path, n)) for n, entry in enumerate(value)]
            return self._by_hardpoints(texts) if isinstance(value, Spot | Axis) else texts
        tree = self.model.formulas.expressions.get(path)
        if tree is not None and isinstance(value, float) and _bits(tree.value(self._values)) == _bits(value):
            return self._text(tree)
        return value

    def _text(self, tree: Expression) -> str | float:
        """Return a formula's text, with names of parameters for their values; a number without a unit as it is."""
        tree = tree.renamed(self._values)
        if isinstance(tree, Number) and tree.unit in ("", "1") and not tree.written.isidentifier():
            return float(tree.number)
        return str(tree)

    def _by_hardpoints(self, texts: list[Any]) -> Any:
        """Return the hardpoint, or the two through which an axis is, that formulas of coordinates describe."""
        names = [tuple(re.findall(r"[^\W\d]\w*(?=\.[xyz])", str(text))) for text in texts]
        if len(set(names)) != 1 or not names[0] or not set(names[0]) <= self.model.formulas.hardpoints.keys():
            return texts
        if texts == [f"{names[0][0]}.{axis}" for axis in "xyz"]:
            return names[0][0]
        if len(names[0]) == 2 and texts == ["{0}.{2} - {1}.{2}".format(*names[0], axis) for axis in "xyz"]:
            return [*names[0][::-1]]
        return texts

    def _point_at(self, place: Spot, path: Path) -> str:
        """Return the name of the point of the file that has these coordinates, by the same formulas."""
        return next((name for name, own in self._named_points if own == [*self._given(place, path)]), "")

    @cached_property
    def _named_points(self) -> list[tuple[str, list[tuple[str, str]]]]:
        points = self.model.formulas.points.items()
        return [(name, [*self._given([*place], ("points", name))]) for name, place in points]

    def _given(self, place: list[float], path: Path) -> Iterator[tuple[str, str]]:
        """Yield number and formula of each coordinate; no formula of a part that no longer gives the number."""
        for n, x in enumerate(place):
            tree = self.model.formulas.expressions.get((*path, n))
            value = _bits(x if tree is None else tree.value(self._values))
            yield (value, str(tree)) if path[0] == "points" or value == _bits(x) else (_bits(x), "")


def in_unit(value: float, unit: str) -> str:
    """Return a number in SI units in another unit, with the fewest digits that give all of its bits; empty if none."""
    guess = value / float(parse(f"1 {unit}").value())
    texts = (f"{guess:.{digits}g} {unit}" for digits in DIGITS)
    return next((text for text in texts if float(parse(text).value()) == value), "")


def _slot_value(slot: Slot, part: Any) -> Any:
    values = [written(getattr(part, name), slot.hint, name) for name in slot.fields]
    if len(values) == 1:
        return values[0]
    return None if all(value is None for value in values) else values


def _bits(number: Any) -> str:
    return repr(float(number))
