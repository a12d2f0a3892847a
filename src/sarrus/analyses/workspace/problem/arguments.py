"""Arguments of workspace analyses: the functions of positions that they name, and results of other analyses."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from .... import elements
from ....model import SarrusError
from ....model.expansion.blueprint import Placement
from ....model.geometry.points import Function
from ....outputs import Level, find_output
from ....outputs.bodies import placed
from ....outputs.measure import placed_of
from ....results.result import Result
from ....system import System

WHERE = "a workspace"


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


def refuse_other(found: Any, kind: type[Result], *, complete: bool = True) -> None:
    """Refuse what is no result of a kind, and one that is not complete where its derivatives are computed.

    Raises
    ------
    TypeError
    SarrusError
    """
    if not isinstance(found, kind):
        raise TypeError(
            f"found must be a {kind.__name__}, got {type(found).__name__}. Pass the result of its analysis."
        )
    if complete and not getattr(found, "success", False):
        raise SarrusError(
            f"{getattr(found, 'name', '')}: what is not complete has no derivatives. See its message."
        )


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
