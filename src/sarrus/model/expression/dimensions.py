"""Units of formulas: the formula is evaluated with units instead of numbers.

A unit is a mapping from SI base units to powers. A number without a unit has none, ``{}``, and fits everywhere, as
do ratios and the values of sin and the like; ``None`` is a number without a declared unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import TypeAlias

from ..errors import ModelError
from ..show import quote
from .tree import Call, Expression, Name, Number
from .units import powers_of, unit_text

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
