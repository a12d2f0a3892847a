"""Units: names, SI values, the units of formulas, and numbers with a unit.

The names are looked up by Pint, which is imported when the first unit is met.

A unit is a mapping from SI base units to powers. A number without a unit has none, ``{}``, and fits everywhere, as
do ratios and the values of sin and the like; ``None`` is a number without a declared unit.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache, reduce
from typing import Any, NamedTuple, TypeAlias

from ..errors import ModelError
from ..show import quote, suggest
from .tree import Call, Expression, Name, Number

COMMON = (
    *("m", "mm", "cm", "km", "in", "ft", "kg", "g", "t", "lb", "s", "ms", "min", "h", "Hz", "rpm"),
    *("N", "kN", "MN", "lbf", "deg", "rad", "J", "W", "kW", "Pa", "MPa", "bar"),
)
SPELT = {"°": "deg", "Nm": "N*m", "Nmm": "N*mm", "kNm": "kN*m"}  # as engineers write them
BASE = {"meter": "m", "kilogram": "kg", "second": "s", "radian": "rad", "ampere": "A", "kelvin": "K"}
RAISED, ASCII = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"
DERIVED = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "1": {},
}


class UnitFactor(NamedTuple):
    """A name in a unit, its power, and its position in the text."""

    name: str
    exponent: int
    start: int = 0


class Unit(NamedTuple):
    """A unit: its value in SI units, and its powers of the SI base units."""

    factor: float
    powers: tuple[tuple[str, int], ...]


def in_si(number: float, factors: Iterable[UnitFactor]) -> tuple[float, str]:
    """Return a number with a unit in SI units, and the SI unit, as in ``kg m s^-2``."""
    powers: dict[str, float] = {}
    for name, exponent, _ in factors:
        unit = look_up(name)
        number = _scaled(number, unit.factor, exponent)
        for base, power in unit.powers:
            powers[base] = powers.get(base, 0) + power * exponent
    return number, unit_text(powers)


def unit_text(powers: dict[str, float]) -> str:
    """Return the text of a unit that is made of powers of SI units, in a fixed order; ``1`` if of none."""
    left = [f"{base}^{power:g}" if power != 1 else base for base, power in sorted(powers.items()) if power]
    return " ".join(left) or "1"


def in_ascii(unit: str) -> str:
    """Return a unit with ``^2`` in the place of raised exponents."""
    return re.sub(f"[{RAISED}]+", lambda found: "^" + found[0].translate(str.maketrans(RAISED, ASCII)), unit)


@cache
def powers_of(symbol: str) -> dict[str, float]:
    """Return the powers of SI base units in a declared unit such as ``N m/rad``, without Pint."""
    powers: dict[str, float] = {}
    above, _, below = in_ascii(symbol).partition("/")
    for words, sign in ((above, 1), (below, -1)):
        for word in words.split():
            name, _, power = word.partition("^")
            for base, own in DERIVED.get(name, {name: 1}).items():
                powers[base] = powers.get(base, 0) + sign * own * float(power or 1)
    return powers


def is_coherent(symbol: str) -> bool:
    """Return whether a declared unit is one of the SI without a factor, as m or Pa, and not mm, deg, or unknown."""
    try:
        names = re.findall(r"[^\W\d_]+|[°%]", in_ascii(symbol))
        return all(name in (*DERIVED, *BASE.values()) or look_up(name).factor == 1 for name in names)
    except ModelError:
        return False


SPACES = " Or put spaces around the sign before it if it is a name, as in 2 m * w."


@cache
def look_up(name: str) -> Unit:
    """Return what a unit's name means.

    Raises
    ------
    ModelError
        If there is no such unit, or it does not start at zero, as a temperature in °C.
    """
    registry = _registry()
    if name not in SPELT and not registry.parse_unit_name(name):
        hint = "" if "Did you mean" in (near := suggest(name, COMMON)) else SPACES
        raise ModelError(f"has the unknown unit {quote(name)}. {near}{hint}")
    one, zero = (registry.Quantity(float(n), SPELT.get(name, name)).to_base_units() for n in (1, 0))
    if zero.magnitude != 0:
        raise ModelError(f"has the unit {quote(name)}, which does not start at zero. Convert it.")
    powers = {BASE.get(base, base): int(power) for base, power in one.unit_items()}
    return Unit(float(one.magnitude), tuple(powers.items()))


@cache
def _registry() -> Any:
    from pint import UnitRegistry

    return UnitRegistry(cache_folder=None)


def _scaled(number: float, factor: float, exponent: int) -> float:
    """Return number · factor^exponent; by a division where that rounds less, so that 9 mm is 0.009."""
    inverse = 1 / factor
    if inverse.is_integer() and not factor.is_integer():
        factor, exponent = inverse, -exponent
    scale = factor ** abs(exponent)
    return number * scale if exponent > 0 else number / scale


Powers: TypeAlias = "dict[str, float] | None"

ALIKE = ("+", "-", "min", "max", "mod", "hypot")
SAME = ("neg", "abs")
PURE = ("sin", "cos", "tan", "exp", "asin", "acos", "atan", "log", "deg", "rad", "tanh", "floor")


def unit_of(expression: Expression, units: Mapping[str, Powers], *, loose: bool = False) -> Powers:
    """Return the unit of a formula's value, given those of its names.

    Parameters
    ----------
    expression, units
        The formula, and the units of its names.
    loose
        Whether numbers without a unit may have any, as the stiffness in ``-100*x - 5*v``, and the functions of plain
        numbers take all: only sums and comparisons of names in different units are refused.

    Raises
    ------
    ModelError
        If it adds or compares different units, or takes the sine or the like of anything but a plain number.
    """
    found: dict[Expression, Powers] = {}
    for node in expression.nodes():
        found[node] = _unit(node, units, found, loose)
    return found[expression]


def fits(powers: Powers, symbol: str) -> bool:
    """Return whether a value with this unit may stand where ``symbol`` is expected; angles count as numbers."""
    return not powers or _without_angle(powers) == _without_angle(powers_of(symbol))


def _unit(
    node: Expression, units: Mapping[str, Powers], found: Mapping[Expression, Powers], loose: bool
) -> Powers:
    if isinstance(node, Number):
        return powers_of(node.unit) if node.unit else None if loose else {}
    if isinstance(node, Name):
        return units.get(node.name)
    assert isinstance(node, Call)
    args = [found[arg] for arg in node.args]
    return {} if loose and node.function.name in PURE else _called(node, args)


def _called(node: Call, args: list[Powers]) -> Powers:
    name = node.function.name
    if name in ALIKE or name == "atan2":
        common = _common(node, args)
        return {} if name == "atan2" else common
    if name in PURE:
        return _pure(node, args[0])
    if name == "sign":
        return {}
    if name == "step" and len(args) == 1:
        return {}
    if name == "step":
        _common(node, [args[0], args[1], args[3]])
        return _common(node, [args[2], args[4]])
    return args[0] if name in SAME else _product(node, args)


def _product(node: Call, args: list[Powers]) -> Powers:
    name, first = node.function.name, args[0]
    if name == "sqrt":
        return None if first is None else _times(first, {}, 1, 0.5)
    if name == "**":
        return _power(node, first)
    second = args[1]
    if first is None or second is None:
        return None
    return _times(first, second, 1 if name == "*" else -1)


def _power(node: Call, base: Powers) -> Powers:
    exponent = node.args[1]
    if not base or exponent.names():
        return None if base or base is None else {}
    return _times(base, {}, 1, float(exponent.value()))


def _times(a: dict[str, float], b: dict[str, float], sign: int, scale: float = 1) -> dict[str, float]:
    powers = {base: scale * (a.get(base, 0) + sign * b.get(base, 0)) for base in {*a, *b}}
    return {base: power for base, power in powers.items() if power}


def _common(node: Call, args: list[Powers]) -> Powers:
    """Return the unit that the arguments have in common; those without one fit."""

    def joined(a: Powers, b: Powers) -> Powers:
        if not a or not b:
            return a or b
        if _without_angle(a) != _without_angle(b):
            message = f"{quote(str(node))} combines {unit_text(a)} and {unit_text(b)}"
            raise ModelError(f"holds a formula in which {message}. Convert one of them.")
        return a

    return reduce(joined, args)


def _pure(node: Call, arg: Powers) -> Powers:
    if arg and _without_angle(arg):
        message = f"{quote(str(node))} takes a plain number or an angle, but is given {unit_text(arg)}"
        raise ModelError(f"holds a formula in which {message}. Divide by a unit.")
    return {}


def _without_angle(powers: dict[str, float]) -> dict[str, float]:
    return {base: power for base, power in powers.items() if power and base != "rad"}
