"""Arguments of workspace analyses that cannot be meant are refused by name."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from numbers import Integral, Real
from typing import Any, NamedTuple

from .... import elements
from ....model import ModelError, SarrusError
from ....model.expansion.blueprint import Placement
from ....model.expression.quantity import quantity
from ....model.geometry.points import Function
from ....outputs import Level, find_output
from ....outputs.bodies import placed
from ....outputs.measure import placed_of
from ....results.result import Result
from ....system import System

LEAST = {
    "seed": 0,
    "repeats": 1,
    "samples": 0,
    "rays": 0,
    "most": 1,
    "starts": 0,
    "cells": 1,
}  # of whole numbers


def functions(output: Any) -> tuple[Any, ...]:
    """Outputs as a tuple; a single name or function is one output.

    Raises
    ------
    TypeError
        If they are neither names nor functions.
    """
    if isinstance(output, str | Function):
        return (output,)
    if not isinstance(output, Iterable):
        raise TypeError(f"output must be names or functions, got {output!r}. Pass e.g. ('tool.x', 'tool.y').")
    return tuple(output)


def refuse_incomplete(found: Any, kind: type[Result]) -> None:
    """Refuse what is no result of a kind, or one that is not complete: its numbers have no derivatives.

    Raises
    ------
    TypeError
    SarrusError
    """
    refuse_other(found, kind)
    if not getattr(found, "success", False):
        raise SarrusError(
            f"{getattr(found, 'name', '')}: what is not complete has no derivatives. See its message."
        )


def refuse_other(found: Any, kind: type[Result]) -> None:
    """Refuse what is no result of a kind.

    Raises
    ------
    TypeError
    """
    if not isinstance(found, kind):
        raise TypeError(
            f"found must be a {kind.__name__}, got {type(found).__name__}. Pass the result of its analysis."
        )


def refuse_counts(**counts: Any) -> None:
    """Refuse whole numbers that are none, or too small, and step lengths that are not positive.

    Raises
    ------
    SarrusError
    """
    if "longest" in counts:
        longest = counts.pop("longest")
        if not isinstance(longest, Real) or not 0 < float(longest) < math.inf:
            raise SarrusError(
                f"longest must be a positive number, got {longest!r}. Leave it out for the default."
            )
    for name, value in counts.items():
        least = LEAST[name]
        if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < least:
            raise SarrusError(
                f"{name} must be a whole number, at least {least}, got {value!r}. Pass such an int."
            )


def pair_of(name: str, given: Any, unit: str) -> tuple[float, float]:
    """The limits of a function, infinite where there is none; texts have units, ``"30 deg"``.

    Raises
    ------
    SarrusError
        If they are no two numbers, or None.
    """
    message = f"limits: those of {name} must be a pair (lowest, highest) of numbers or None, got {given!r}"
    ends = list(given) if isinstance(given, Iterable) and not isinstance(given, str) else []
    try:
        ends = [quantity(one, unit) if isinstance(one, str) else one for one in ends]
    except ModelError as wrong:
        raise SarrusError(f"{message}. One {wrong.message}") from None
    if len(ends) != 2 or not all(one is None or isinstance(one, Real) for one in ends):
        raise SarrusError(f"{message}. Pass e.g. (-1.0, 1.0) or ('-30 deg', '30 deg').")
    low, high = (
        inf if one is None else float(one) for one, inf in zip(ends, (-math.inf, math.inf), strict=True)
    )
    if math.isnan(low) or math.isnan(high) or low == math.inf or high == -math.inf:
        raise SarrusError(f"{message}. Pass e.g. (-1.0, 1.0).")
    return low, high


def value_of(name: str, given: Any) -> float:
    """The value that a function keeps.

    Raises
    ------
    SarrusError
        If it is no finite number.
    """
    if not isinstance(given, Real) or not math.isfinite(given):
        raise SarrusError(f"fixed: {name} must keep a finite number, got {given!r}. Pass a value.")
    return float(given)


def refuse_twice(kind: str, places: Sequence[int], names: Sequence[str]) -> None:
    """Refuse one function under two names.

    Raises
    ------
    SarrusError
    """
    twice = next((names[k] for n, k in enumerate(places) if k in places[:n]), None)
    if twice is not None:
        raise SarrusError(f"{kind}: {twice} is given twice. Name it once.")


WHERE = "a workspace"


class Measure(NamedTuple):
    """A named function of the coordinates: the element that measures it, and what kind of number that is."""

    name: str
    placed: Placement
    kind: str  # "length", "angle" or "square" (of a length)
    given: str = ""
    asked: str = ""  # the name by which it was asked for

    @property
    def title(self) -> str:
        """Its name in results: as it was asked for."""
        return self.asked or self.name

    @property
    def measured(self) -> tuple[Any, ...]:
        """Return what is measured, independent of its name."""
        return self.placed.element, self.placed.bodies, repr(self.placed.values)

    @property
    def unit(self) -> str:
        """Unit of the value that the user sees."""
        return self.given or ("rad" if self.kind == "angle" else "m")

    def value(self, wanted: float) -> float:
        """Return the value of the element for a requested value."""
        return wanted * abs(wanted) if self.kind == "square" else wanted  # of no lowest length, -∞

    def slope(self, wanted: float) -> float:
        """The derivative of `value`."""
        return 2 * wanted if self.kind == "square" else 1.0

    def shown(self, found: Any) -> Any:
        """The value that the user sees for a value of the element."""
        return abs(found) ** 0.5 if self.kind == "square" else found


def measures(system: System, things: Iterable[Any]) -> list[Measure]:
    """The measures of names and functions, in their order.

    Raises
    ------
    SarrusError
        If the system has no such thing.
    """
    return [_measure(system, thing) for thing in things]


def _measure(system: System, thing: Any) -> Measure:
    if isinstance(thing, tuple) and len(thing) == 1:  # point["x"]
        thing = thing[0]
    if isinstance(thing, Function):
        measuring = placed(system, thing)
        return Measure(thing.label, measuring, _kind(measuring))
    if not isinstance(thing, str):
        message = "Give a name like 'pin.angle' or 'tool.x', or a function like tool.point(1, 0, 0)['x']"
        raise SarrusError(f"output: {thing!r} is no function of a position. {message}.")
    output = find_output(system, thing, Level.POSITION, WHERE)
    measuring = placed_of(system, output, WHERE)
    return Measure(output.name, measuring, _kind(measuring), output.unit, thing)


def _kind(placed: Placement) -> str:
    if placed.element is elements.Distance:
        return "square"
    return "angle" if "Memory" in placed.element.fields.values() else "length"
