"""Units of parameters and of derivatives: ``m²/N`` for metres over newtons per metre.

A unit is a text, as in ``N s/m``; ``1`` for plain numbers, and empty where it is not known.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from ..model import Frame, Model, ModelError, Point
from ..model.expression import Call, Expression, parse
from ..model.expression.units import ALIKE, ASCII, RAISED, SAME, in_ascii, unit_of
from ..model.measure import In, measures_of
from ..system import System
from ..system.cached import once

NEWTON, JOULE = {"kg": 1.0, "m": 1.0, "s": -2.0}, {"N": 1.0, "m": 1.0}
MOST = 3  # power of the newton in a unit
TABLE = re.compile(r"\b\d+\.[xy]$")
INVERSE = ("asin", "acos", "atan", "atan2")  # functions whose values are angles
STATES = {"start.q": ("m", "1"), "start.v": ("m/s", "1/s")}  # of displacements, and of Euler parameters


def product(*factors: tuple[str, float]) -> str:
    """The unit of a product of powers of units, in its shortest form; empty where one of them is not known."""
    powers = ((_powers(unit), power) for unit, power in factors)
    return _shortest(_times(*powers)) if all(unit for unit, _ in factors) else ""


def quotient(unit: str, *below: str) -> str:
    """The unit of a derivative."""
    return product((unit, 1), *((one, -1) for one in below))


def size_in_tables(unit: str, table_unit: str) -> float:
    """The size of the unit in which a table shows a number, in SI units; 1 if it is the number's own or not given."""
    return 1.0 if table_unit in ("", unit) else float(parse(f"1 {table_unit}").value())


def refuse_other_units(tree: Expression, units: dict[str, str]) -> None:
    """Refuse a formula that adds or compares names in different units; plain numbers may have any unit.

    Raises
    ------
    ModelError
    """
    unit_of(tree, {name: in_base(unit) if unit else None for name, unit in units.items()}, loose=True)


def unit_of_tree(tree: Expression, units: dict[str, str]) -> str:
    """The unit of a formula of names with units, as one of them has it if it can; empty where it is not known."""
    bases = {name: in_base(unit) if unit else None for name, unit in units.items()}
    try:
        found = unit_of(tree, bases)
    except ModelError:  # two units added, which files refuse: no unit is right
        return ""
    if found is None or _is_angle(tree):
        return "" if found is None else "rad"
    alike = (units[name] for name, base in bases.items() if base == found)
    return next(alike, "") or _shortest(found)


def _is_angle(tree: Any) -> bool:
    """Whether a formula is an inverse function, or a sum or the like of these."""
    name = tree.function.name if isinstance(tree, Call) else ""
    return name in INVERSE or (name in (*ALIKE, *SAME) and all(map(_is_angle, tree.args)))


@once
def units_of(system: System, names: tuple[str, ...]) -> tuple[str, ...]:
    """The units of parameters by name."""
    return units_of_parameters(system.model, names)


def unit_of_parameter(model: Model, name: str) -> str:
    """The unit of a parameter of the model, as its part declares it; empty for constants of formulas."""
    return units_of_parameters(model, [name])[0]


def units_of_parameters(model: Model, names: Sequence[str]) -> tuple[str, ...]:
    """The units of several parameters."""
    parts = {one.name: one for section in model.sections().values() for one in section}
    own: dict[str, str] = {}

    def unit(name: str) -> str:
        if name in own:
            return own[name]
        part, *path = name.split(".")
        if part == "gravity":
            return "m/s²"
        if path and path[0] in ("orientation", "initial_orientation"):
            return "rad" if path[1:2] and path[1].startswith("angle") else "1"
        if part in model.formulas.points:
            return "m"
        if (state := ".".join([part, *path[:1]])) in STATES and len(path) > 2:
            return STATES[state][path[-1].startswith("e")]
        if part not in parts or not path:
            return ""
        if isinstance(place := getattr(parts[part], path[0], None), Point | Frame):
            return "m" if isinstance(place, Point) or path[1] == "point" else "1"
        measure = measures_of(parts[part]).get(path[0])
        return _written(_in_place(measure, ".".join(path[1:]))) if measure else ""

    for name, tree in model.formulas.definitions.items():
        if name in model.parameters:  # by its formula; a plain number has none
            found = unit_of_tree(tree, {one: unit(one) for one in tree.names()})
            own[name] = found if found != "1" or tree.names() else ""
    return tuple(map(unit, names))


def _in_place(measure: In, place: str) -> str:
    """The unit of a component of a field, of an entry of a table, or of a constant of a formula, which has none."""
    if TABLE.search(place):
        return measure.unit if place.endswith("y") else measure.over
    constant = place[-1:].isdigit() and (measure.over != "1" or measure.outputs)
    return "" if constant else measure.unit


def _powers(unit: str) -> dict[str, float]:
    """The powers of the symbols of a unit."""
    above, _, below = in_ascii(unit).partition("/")
    words = [(word, 1) for word in above.split()] + [(word, -1) for word in below.strip("()").split()]
    pairs = ((word.partition("^"), sign) for word, sign in words if word != "1")
    return _times(*(({name: float(power or 1)}, sign) for (name, _, power), sign in pairs))


def _times(*factors: tuple[dict[str, float], float]) -> dict[str, float]:
    """Powers of a product of powers."""
    found: dict[str, float] = {}
    for powers, exponent in factors:
        for name, power in powers.items():
            found[name] = found.get(name, 0.0) + exponent * power
    return {name: power for name, power in found.items() if power}


def in_base(unit: str) -> dict[str, float]:
    """The powers of a unit without newtons, as formulas have them."""
    powers = _powers(unit)
    powers = _times((powers, 1), ({"J": 1}, -powers.get("J", 0)), (JOULE, powers.get("J", 0)))
    return _times((powers, 1), ({"N": 1}, -powers.get("N", 0)), (NEWTON, powers.get("N", 0)))


def _shortest(powers: dict[str, float]) -> str:
    """The unit with the fewest symbols, of those with newtons or joules in the place of kg m/s².

    No newton or joule is introduced where that leaves more kilograms than before, as kg s/N for s³/m.
    """
    newtons, joules = powers.get("N", 0.0), powers.get("J", 0.0)
    rest = _times((powers, 1), ({"N": 1, "J": 0}, -newtons), ({"J": 1}, -joules), (NEWTON, newtons))
    kilograms = abs(rest.get("kg", 0.0) + joules)

    def with_units(j: float, n: float) -> dict[str, float]:
        left = _times((rest, 1), (JOULE, joules - j), ({"J": 1}, j))
        own = left.pop("N", 0.0)
        return _times((left, 1), (NEWTON, own - n), ({"N": 1}, n))

    pairs = [(j, float(n)) for j in {joules, 0.0} for n in range(-MOST, MOST + 1)]
    choices = [with_units(*pair) for pair in pairs]
    plain = [one for one in choices if abs(one.get("kg", 0.0)) <= kilograms]
    given = [one for pair, one in zip(pairs, choices, strict=True) if pair[1] == newtons]
    best = min(plain + given, key=lambda one: (sum(map(abs, one.values())), abs(one.get("N", 0.0) - newtons)))
    return _text(best)


def _text(powers: dict[str, float]) -> str:
    """A unit of powers of symbols: first newtons, then by the alphabet."""
    order = sorted(powers, key=lambda name: (name not in ("J", "N"), name))
    above = [_symbol(name, powers[name]) for name in order if powers[name] > 0]
    below = [_symbol(name, -powers[name]) for name in order if powers[name] < 0]
    over = " ".join(below) if len(below) < 2 else f"({' '.join(below)})"
    return " ".join(above or ["1"]) + (f"/{over}" if below else "")


def _symbol(name: str, power: float) -> str:
    return name if power == 1 else _written(f"{name}^{power:g}")


def _written(unit: str) -> str:
    """A unit with raised exponents."""
    raised = str.maketrans(ASCII, RAISED)
    return re.sub(r"\^(-?\d+)(?![.\d])", lambda found: found[1].translate(raised), unit)
