"""Units: names, SI values, and the units of formulas.

The names are looked up by Pint, which is imported when the first unit is met.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from typing import Any, NamedTuple

from ..errors import ModelError
from ..show import quote, suggest

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
