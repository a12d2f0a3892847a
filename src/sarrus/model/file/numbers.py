"""Texts that represent numbers in a model file: conversion of units, formulas and names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import isfinite
from typing import Any, NamedTuple

from ..bodies.body import Body
from ..checks.findings import KINDS
from ..errors import ModelError
from ..expression import Expression, Name, Number, parse
from ..expression.formula_value import FormulaValue
from ..expression.units import Powers, powers_of, unit_of
from ..forces.by_formula import known_powers
from ..hardpoints import written_number
from ..laws.text_units import check_function_unit, check_unit, variable_of
from ..measure import In, measures
from ..model import registered_kinds
from ..show import quote, show, suggest
from ..signals import output_words
from .scope import full_name
from .text.document import NUMBER

MOST_HINTS = 50  # names that are suggested for one file: each is sought among all
LONGEST_CHAIN = 60  # names that need one another
AXES = {"x": 0, "y": 1, "z": 2, "xx": 0, "yy": 1, "zz": 2}
FOLLOWED = {
    "first_order_lag": "",
    "state_variable": "",
    "transfer_function": ".output",
    "pid": ".output",
    "input": "",
}
FORMS = "Write it as in 1.5e-3, 20 mm or 2*${l}."


class Home(NamedTuple):
    """A part that a path leads into, and the rest of the path."""

    section: str
    entry: object
    steps: list[str]


class Echo(ModelError):
    """An error that is also reported at another place: a formula uses a name whose own formula is wrong."""


class Numbers:
    """All that the formulas of one file need; values are worked out when they are first asked for.

    Attributes
    ----------
    trees, values, units
        Of every name that was asked for, each after those that it needs.
    """

    def __init__(self, data: Any) -> None:
        self.data: dict[str, Any] = data if isinstance(data, dict) else {}
        self.trees: dict[str, Expression] = {}
        self.values: dict[str, float] = {}
        self.units: dict[str, Powers] = {}
        self.open: list[str] = []
        self.hints = 0

    def number(self, text: str, unit: str) -> FormulaValue:
        """Return the number that a text gives, in the SI unit ``unit``, with its formula."""
        tree = self.tree(text)
        check_unit(tree, text, unit, self.units)
        result = FormulaValue(_finite(tree.value(self.values), text))
        result.expression = tree
        return result

    def function(self, text: str, unit: str, over: str) -> Expression:
        """Return the formula of a function of one variable, with numbers for all other names; or that of an input."""
        if self._is_input(text.strip()):
            return Name(text.strip())
        tree = self.tree(text, variable_of(over))
        check_function_unit(tree, text, In(unit, over), self.units)
        return self.with_values(tree)

    def of_states(self, text: str, unit: str) -> Expression | None:
        """Return a formula that names a force, which is perhaps a state, as one of outputs; nothing for others."""
        forces, tree = self._section("forces"), parse(text)
        full = {name: full_name(text, name) for name in tree.names() if name != "t"}
        own = [
            name for name in full.values() if name.partition(".")[0] in forces and not self._is_number(name)
        ]
        if not own:
            known = self._followed()
            unknown = next((name for name in full.values() if known and not any(self._homes(name))), None)
            if unknown:
                raise self._unknown_name(unknown, ("t", *known))
            return None
        formula = self.of_outputs(text, "t")
        self._check_motion(tree.replaced({name: Name(long) for name, long in full.items()}), text, unit, own)
        return formula

    def _check_motion(self, tree: Expression, text: str, unit: str, outputs: Iterable[str]) -> None:
        """Refuse a motion in another unit; numbers without units may have any that outputs beside them need."""
        kind, declared = In(unit, "s"), self._followed()
        units = {name: known_powers(declared.get(name, "")) for name in outputs}
        try:
            check_function_unit(tree, text, kind, {**self.units, **units})
        except ModelError:
            plain: dict[str, Powers] = {name: None if one is None else {} for name, one in units.items()}
            unit_of(tree, {"t": {"s": 1}, **self.units, **units}, loose=True)
            check_function_unit(tree, text, kind, {**self.units, **plain})

    def _followed(self) -> dict[str, str]:
        """The states and outputs that motions may use most, with their units."""
        forces = {name: entry for name, entry in self._section("forces").items() if isinstance(entry, dict)}
        return {
            f"{name}{FOLLOWED[kind]}": str(entry.get("unit") or "")
            for name, entry in forces.items()
            if (kind := str(entry.get("type"))) in FOLLOWED
        }

    def of_outputs(self, text: str, *own: str) -> Expression:
        """Return a formula of outputs, with numbers for the names of parameters; x, v and t are its own by default."""
        tree, own = parse(text), own or ("x", "v", "t")
        full = {name: full_name(text, name) for name in tree.names() if name not in own}
        for name in full.values():
            if self._is_number(name):
                self._need(name, text)
        return self.with_values(tree.replaced({name: Name(long) for name, long in full.items()}))

    def _is_number(self, name: str) -> bool:
        """Whether a name is a parameter, or a number of a part that is no output as well."""
        if name in self._parameter_names():
            return True
        homes = [home for home in self._homes(name) if home.steps and home.steps[0] not in output_words()]
        values = [self._walk(home.entry, home.steps) for home in homes]
        return any(isinstance(one, int | float | str) and not self._is_part(one) for one in values)

    def _is_part(self, value: Any) -> bool:
        """Whether a field has the name of a joint or a force, as ``output: axle`` of a transmission has."""
        parts = {**self._section("joints"), **self._section("forces")}
        return isinstance(value, str) and value in parts and value not in self._parameter_names()

    def _is_input(self, name: str) -> bool:
        """Whether a name is that of an input."""
        entry = self._section("forces").get(name)
        return isinstance(entry, dict) and entry.get("type") == "input"

    def with_values(self, tree: Expression) -> Expression:
        """Return a formula with numbers for the names that have values."""
        known = [name for name in tree.names() if name in self.values]
        return tree.replaced({name: Number(self.values[name], of=name) for name in known})

    def point(self, text: str) -> Any:
        """Return the entries of a named point as they are written."""
        name, points, hardpoints = full_name(text, text), self._section("points"), self._section("hardpoints")
        if name in hardpoints:
            return [f"{name}.{axis}" for axis in "xyz"]
        if name not in points:
            given = f"has the unknown point {quote(text)}"
            raise ModelError(f"{given}. {self._hint(name, lambda: [*hardpoints, *points], 'hardpoints')}")
        return points[name]

    def axis(self, first: str, second: str) -> list[str]:
        """Return the components of the vector from one named point to another, as formulas.

        Raises
        ------
        ModelError
            For unknown points, and for equal ones.
        """
        for name in (first, second):
            self.point(name)
        names = [[f"{full_name(name, name)}.{axis}" for name in (first, second)] for axis in "xyz"]
        for name in (one for pair in names for one in pair):
            self._need(name, name)
        if all(self.values[a] == self.values[b] for a, b in names):
            raise ModelError(
                f"is through {quote(first)} and {quote(second)}, which are equal. Move one of them."
            )
        return [f"{b} - {a}" for a, b in names]

    def tree(self, text: str, *variables: str) -> Expression:
        """Return the formula of a text under the full names, all of which have values then."""
        if NUMBER.fullmatch(text):
            raise ModelError(f"must be a number, but is {quote(text)}. Write it without quotes.")
        tree = parse(text)
        full = {name: Name(full_name(text, name)) for name in tree.names() if name not in variables}
        for name in full.values():
            self._need(name.name, text, variables)
        return tree.replaced(full)

    def parameters(self) -> dict[str, float]:
        """Return every parameter with its value; those of a group as ``group.name``."""
        names = self._parameter_names()
        for name in names:
            self._need(name, name)
        return {name: self.values[name] for name in names}

    def unit_of(self, hardpoint: str) -> str:
        """Return the unit in which the coordinates of a hardpoint are given; that of most, if they have several."""
        trees = (self.trees[f"{hardpoint}.{axis}"] for axis in "xyz")
        units = [written_number(tree)[1] for tree in trees]
        return max(units, key=units.count) or "m"

    def _need(self, name: str, text: str, variables: tuple[str, ...] = ()) -> None:
        """Work out the value of a name; the variables of its formula are offered where it is unknown."""
        if name in self.values:
            return
        if name in self.open:
            circle = " needs ".join(quote(one) for one in (*self.open[self.open.index(name) :], name))
            raise ModelError(f"holds formulas that go in a circle, {circle}. Give one of them a number.")
        if len(self.open) >= LONGEST_CHAIN:
            raise ModelError(f"needs a chain of more than {LONGEST_CHAIN} names. Give one of them a number.")
        raw, unit = self._definition(name, text, variables)
        self.open.append(name)
        try:
            self._define(name, raw, unit)
        except ModelError as error:
            raise Echo(error.message) from None
        finally:
            self.open.pop()

    def _define(self, name: str, raw: Any, unit: str | None) -> None:
        if isinstance(raw, str):
            computed = self.number(raw, unit or "")
            tree, value = computed.expression, float(computed)
        else:
            value = _finite(raw, name)
            tree = Number(value)
        powers = powers_of(unit) if unit else (unit_of(tree, self.units) or None)
        self.trees[name], self.values[name], self.units[name] = tree, value, powers

    def _definition(self, name: str, text: str, variables: tuple[str, ...]) -> tuple[Any, str | None]:
        """Return the value of a name in the file, and the unit of its field."""
        places = [(self._walk(home.entry, home.steps), home) for home in self._homes(name)]
        for raw, home in places:
            if isinstance(raw, (int, float, str)) and not isinstance(raw, bool):
                return raw, self._declared(home)
        for raw, home in places:
            if raw is not None:
                message = f"uses {quote(name)}, which is {show(raw)} and no number"
                wrong = Echo if home.section == "parameters" else ModelError
                raise wrong(f"{message}. Name one of its numbers, as in {name}.x.")
        raise self._unknown(name, text, variables)

    def _homes(self, name: str) -> Iterator[Home]:
        """Yield every part that a path may lead into: parameters and points come before the others."""
        part, *steps = name.split(".")
        for section in reversed(KINDS):
            if part in self._section(section):
                yield Home(section, self._section(section)[part], steps)

    def _walk(self, value: Any, steps: list[str]) -> Any:
        """Return what a path leads to, or None."""
        for step in steps:
            if isinstance(value, str):
                value = self._place(full_name(value, value))
            if isinstance(value, dict):
                value = value.get(step)
            else:
                place = AXES.get(step, -1)
                value = value[place] if isinstance(value, list) and 0 <= place < len(value) else None
        return value

    def _place(self, name: str) -> Any:
        """Return the entries of a hardpoint or a point; None for an unknown name."""
        return self._section("hardpoints").get(name, self._section("points").get(name))

    def _declared(self, home: Home) -> str | None:
        if home.section in ("parameters", "points", "hardpoints"):
            return None if home.section == "parameters" else "m"
        name = str(home.entry.get("type")) if isinstance(home.entry, dict) else ""
        kind = Body if home.section == "bodies" else registered_kinds().get(home.section, {}).get(name)
        measure = measures(kind).get(home.steps[0]) if kind and home.steps else None
        return measure.unit if measure else None

    def _unknown(self, name: str, text: str, variables: tuple[str, ...]) -> ModelError:
        error = self._unknown_name(name, variables)
        if text.strip() == name and "." not in name and "Did you mean" not in error.message:
            return ModelError(f"must be a number, but is {quote(text)}. {FORMS}")
        return error

    def _unknown_name(self, name: str, variables: tuple[str, ...]) -> ModelError:
        hint = self._hint(
            name, lambda: [*variables, *self._parameter_names(), *self._part_numbers()], "parameters"
        )
        return ModelError(f"uses the unknown name {quote(name)}. {hint}")

    def _hint(self, name: str, known: Callable[[], Iterable[str]], section: str) -> str:
        """Return which name may be meant, for the first unknown ones of a file."""
        self.hints += 1
        names = [*known()] if self.hints <= MOST_HINTS else []
        return suggest(name, names) if names else f"Define it under {section}."

    def _section(self, section: str) -> dict[str, Any]:
        found = self.data.get(section)
        return found if isinstance(found, dict) else {}

    def _parameter_names(self) -> list[str]:
        groups = self._section("parameters").items()
        inner = ([f"{k}.{name}" for name in v] if isinstance(v, dict) else [k] for k, v in groups)
        points = (f"{name}.{axis}" for name in self._section("hardpoints") for axis in "xyz")
        return [*(name for names in inner for name in names), *points]

    def _part_numbers(self) -> list[str]:
        points = [f"{name}.{axis}" for name in self._section("points") for axis in "xyz"]
        parts = [
            f"{name}.{key}"
            for section in ("bodies", "joints", "drivers", "forces")
            for name, entry in self._section(section).items()
            if isinstance(entry, dict)
            for key, value in entry.items()
            if isinstance(value, float)
        ]
        return points + parts


def _finite(value: Any, text: str) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = float("inf")
    if not isfinite(number):
        raise ModelError(f"must be a finite number, but {quote(text)} is {show(number)}. Change its numbers.")
    return number
