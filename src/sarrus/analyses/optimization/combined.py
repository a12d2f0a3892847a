"""Responses made of other responses by a function of their values, differentiated exactly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...model.arithmetic import Numeric
from ...model.expression import Expression, Name
from ...model.tape import Tape, Traced, value_of
from ...outputs import find_output
from ...outputs.units import unit_of_tree
from ...results import ErrorEstimate
from ...system import System
from ..sensitivity.derivatives import as_responses
from ..sensitivity.responses.responses import Output, Response, distinct_titles
from ..sensitivity.sampling.sampling import NotThere, refuse_outside

Part: TypeAlias = "Response | Output | Combined"


@dataclass(frozen=True, eq=False)
class Combined:
    """A function of the values of some responses, ``Combined(lambda work, time: work / time, [work, time])``.

    Parameters
    ----------
    function : a function of the values of the responses, made of arithmetic and NumPy's functions
    of : the responses
    name : its name in tables
    """

    function: Callable[..., Numeric]
    of: Sequence[Response | Output]
    name: str = ""

    @property
    def title(self) -> str:
        """The name in tables."""
        return self.name or getattr(self.function, "__name__", "").strip("<>") or "combined"

    def unit(self, system: System) -> str:
        """Return the unit of the value, if the function consists of arithmetic on its arguments."""
        if hasattr(self.function, "unit"):
            return str(self.function.unit(system))
        units = {f"part{n}": one.unit(system) for n, one in enumerate(as_responses(list(self.of)))}
        try:
            found = self.function(*map(Name, units))
        except Exception:  # a user's function, which need not know formulas
            return ""
        return unit_of_tree(found, units) if isinstance(found, Expression) else ""

    def value_and_slopes(self, values: Array) -> tuple[float, Array]:
        """Return the value and its derivatives with respect to the responses."""
        value, slopes, _ = self._derivatives(values, np.zeros(len(values)))
        return value, slopes

    def slopes_along(self, values: Array, change: Array) -> Array:
        """Return the change of these derivatives with the values."""
        return self._derivatives(values, change)[2]

    def _derivatives(self, values: Array, change: Array) -> tuple[float, Array, Array]:
        tape = Tape()
        inputs = [tape.variable(value) for value in np.asarray(values, dtype=float)]
        found = self.function(*inputs)
        if not isinstance(found, Traced):
            return float(value_of(found)), np.zeros(len(values)), np.zeros(len(values))
        dots = tape.along({one.at: float(c) for one, c in zip(inputs, change, strict=True)})
        first, second = tape.gradient_along({found.at: 1.0}, {}, dots)
        slopes, turned = (np.array([float(bars[one.at]) for one in inputs]) for bars in (first, second))
        return float(found.value), slopes, turned


class Outer:
    """The requested responses as functions of the evaluated ones.

    Parameters
    ----------
    given : one or several responses, outputs, or `Combined`
    """

    def __init__(self, given: Part | Sequence[Part]) -> None:
        some = [given] if isinstance(given, str | Response | Combined) or callable(given) else list(given)
        if not some:
            raise ValueError(
                "responses: no response is asked for. Give one or several, such as Final('slider.x')."
            )
        groups = [
            as_responses(list(one.of)) if isinstance(one, Combined) else as_responses(one) for one in some
        ]
        self.parts = [part for group in groups for part in group]
        self._wanted = [
            one if isinstance(one, Combined) else group[0] for one, group in zip(some, groups, strict=True)
        ]
        self.titles = distinct_titles(one.title for one in self._wanted)
        self._functions = [one if isinstance(one, Combined) else None for one in some]
        ends = np.cumsum([len(group) for group in groups])
        self._places = [slice(end - len(group), end) for end, group in zip(ends, groups, strict=True)]

    def times(self) -> list[float]:
        """The given times at which outputs are taken [s]."""
        wanted = (part.times(np.array([np.nan])) for part in self.parts)  # nan: at the end, whenever it is
        every = np.concatenate([np.zeros(0), *(one for one in wanted if one is not None)])
        return [float(t) for t in np.unique(every[np.isfinite(every)])]

    def check(self, system: System, begin: float, end: float) -> None:
        """Refuse responses that no run between two times has, before one is simulated.

        Raises
        ------
        SarrusError
            For names that are no outputs, and times outside.
        """
        for part in self.parts:
            if isinstance(part.of, str):
                find_output(system, part.of, where=part.title)
            times = part.times(np.array([begin, end]))
            try:
                refuse_outside(() if times is None else times, begin, end)
            except NotThere as wrong:
                raise SarrusError(f"{part.title}: {wrong}") from None

    def units(self, system: System) -> tuple[str, ...]:
        """The units of what is asked for."""
        return tuple(one.unit(system) for one in self._wanted)

    def values(self, parts: Array) -> Array:
        """Return the requested responses (r,) from the values of the parts."""
        return self.linear(parts)[0]

    def linear(self, parts: Array) -> tuple[Array, Array]:
        """Return the requested responses (r,) and their derivatives with respect to the parts (r, parts)."""
        values, slopes = np.zeros(len(self._places)), np.zeros((len(self._places), len(parts)))
        for row, (place, function) in enumerate(zip(self._places, self._functions, strict=True)):
            if function is None:
                values[row], slopes[row, place] = parts[place][0], 1.0
            else:
                values[row], slopes[row, place] = function.value_and_slopes(parts[place])
        return values, slopes

    def errors(self, parts: Sequence[ErrorEstimate]) -> list[ErrorEstimate]:
        """The errors of what is asked for, of those of the parts, to first order."""
        values, slopes = self.linear(np.array([one.value for one in parts]))
        fields = [[one.estimate, one.spread, one.round_off, one.vibrations] for one in parts]
        estimates, spreads, *sizes = np.array(fields).T
        sizes = [np.sqrt(slopes**2 @ own**2) for own in sizes]
        columns = values, slopes @ estimates, abs(slopes) @ spreads, *sizes
        rows = zip(self.titles, *columns, strict=True)
        return [ErrorEstimate(title, *map(float, own)) for title, *own in rows]

    def place(self, row: int) -> slice:
        """Return the parts of a row."""
        return self._places[row]

    def is_combined(self, row: int) -> bool:
        """Whether a row is a function of its parts."""
        return self._functions[row] is not None

    def slopes_along(self, row: int, parts: Array, change: Array) -> Array:
        """The change of a combined row's derivatives by its own parts with that of their values."""
        function = self._functions[row]
        assert function is not None
        return function.slopes_along(parts[self._places[row]], change)
