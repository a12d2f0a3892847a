"""Responses made of other responses by a function of their values, or by a formula, differentiated exactly.

In formulas, ``max(slider.x) - min(slider.x)``, names are outputs and parameters. `reductions` are of histories over
time; a history that is not reduced means its final value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from ...algebra import Array
from ...model import ModelError, SarrusError
from ...model.arithmetic import Numeric
from ...model.expression import Call, Expression, Name, parse
from ...model.expression.tree import call
from ...model.tape import Tape, Tracer, value_of
from ...outputs import find_output
from ...outputs.reductions import ERROR, REDUCTIONS, is_reduction
from ...outputs.units import unit_of_tree
from ...results import ErrorEstimate, Gradient
from ...system import System
from .responses.responses import (
    At,
    Final,
    Initial,
    Integral,
    Maximum,
    Minimum,
    Output,
    Response,
    distinct_titles,
)
from .sampling.segments import NoSample, refuse_outside

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
        units = {f"part{n}": one.unit(system) for n, one in enumerate(self.parts())}
        try:
            found = self.function(*map(Name, units))
        except Exception:  # a user's function, which need not know formulas
            return ""
        return unit_of_tree(found, units) if isinstance(found, Expression) else ""

    def parts(self) -> list[Response]:
        """The responses of whose values it is a function."""
        found = [response_of(one) for one in self.of]
        nested = next((one.title for one in found if isinstance(one, Combined)), None)
        if nested is not None:
            raise SarrusError(f"{self.title}: {nested} is made of several responses. Give these as parts.")
        return [one for one in found if isinstance(one, Response)]

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
        if not isinstance(found, Tracer):
            return float(value_of(found)), np.zeros(len(values)), np.zeros(len(values))
        dots = tape.along({one.at: float(c) for one, c in zip(inputs, change, strict=True)})
        first, second = tape.gradient_along({found.at: 1.0}, {}, dots)
        slopes, turned = (np.array([float(bars[one.at]) for one in inputs]) for bars in (first, second))
        return float(found.value), slopes, turned


class Composite:
    """The requested responses as functions of the evaluated ones, of which one that is part of several counts once.

    Parameters
    ----------
    given : one or several responses, outputs, or `Combined`
    """

    def __init__(self, given: Part | Sequence[Part]) -> None:
        some: Any = given if isinstance(given, Sequence) and not isinstance(given, str) else [given]
        self.asked = [response_of(one) for one in some]
        if not self.asked:
            raise ValueError(
                "responses: no response is asked for. Give one or several, such as Final('slider.x')."
            )
        groups = [one.parts() if isinstance(one, Combined) else [one] for one in self.asked]
        distinct = {id(part): part for group in groups for part in group}
        self.parts, place_of = [*distinct.values()], {part: n for n, part in enumerate(distinct)}
        self.titles = distinct_titles(one.title for one in self.asked)
        self._functions = [one if isinstance(one, Combined) else None for one in self.asked]
        self._places = [np.array([place_of[id(part)] for part in group], dtype=int) for group in groups]

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
            except NoSample as wrong:
                raise SarrusError(f"{part.title}: {wrong}") from None

    def units(self, system: System) -> tuple[str, ...]:
        """The units of what is asked for."""
        return tuple(one.unit(system) for one in self.asked)

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
                values[row], of_function = function.value_and_slopes(parts[place])
                np.add.at(slopes[row], place, of_function)
        return values, slopes

    def errors(self, parts: Sequence[ErrorEstimate]) -> list[ErrorEstimate]:
        """The errors of what is asked for, of those of the parts, to first order."""
        values, slopes = self.linear(np.array([one.value for one in parts]))
        estimates, spreads, noise = np.array([[one.estimate, one.spread, one.round_off] for one in parts]).T
        columns = values, slopes @ estimates, abs(slopes) @ spreads, np.sqrt(slopes**2 @ noise**2)
        rows = zip(self.titles, *columns, strict=True)
        return [ErrorEstimate(title, *map(float, own)) for title, *own in rows]

    def gradient(self, of_parts: Gradient, system: System) -> Gradient:
        """The gradients of what is asked for, of those of the parts."""
        if not any(self._functions) and len(self.parts) == len(self.asked):
            return of_parts
        values, slopes = self.linear(of_parts.values)
        return replace(
            of_parts, responses=self.titles, values=values, matrix=slopes @ of_parts.matrix,
            response_units=self.units(system), errors=tuple(self.errors(of_parts.errors)) if of_parts.errors else (),
        )  # fmt: skip

    def curved(
        self,
        row: int,
        values: Array,
        matrix: Callable[[], Array],
        times: Callable[[int, Array], Array],
        direction: Array,
    ) -> Array:
        """The Hessian of what is asked for times a direction (p,).

        Parameters
        ----------
        values, matrix : of all parts, and their gradients, which only functions of parts need
        times : the Hessian of a part times a direction
        """
        place = self._places[row]
        slopes = self.linear(values)[1][row]
        bends = [slopes[n] * times(int(n), direction) for n in np.flatnonzero(slopes)]
        found, function = np.sum(bends, axis=0) if bends else np.zeros(len(direction)), self._functions[row]
        if function is not None:
            own = matrix()[place]
            found = found + function.slopes_along(values[place], own @ direction) @ own
        return np.asarray(found)


def response_of(given: Part, name: str = "") -> Response | Combined:
    """A response of what a user gives: itself, the final value of an output, or that of a formula.

    Raises
    ------
    SarrusError
        For a text that is no formula, or has no derivatives.
    """
    if isinstance(given, Response | Combined):
        return given
    return _of_formula(given, name) if isinstance(given, str) else Final(given, name)


def _of_formula(text: str, name: str) -> Response | Combined:
    try:
        tree = parse(text, functions=REDUCTIONS)
    except ModelError as wrong:
        if any(sign in text for sign in "+*/^("):
            raise SarrusError(f"response {text!r} {wrong.message}") from None
        return Final(text, name)  # which refuses the name with the nearest ones
    inner: dict[str, Response] = {}

    def part(node: Expression) -> Expression | None:
        return _reduced(node, inner) if is_reduction(node) or isinstance(node, Name) else None

    whole = tree.rebuilt(part)
    names = whole.names()
    if not names:
        raise SarrusError(
            f"response {text!r} names no output of the motion. Name one, such as max(slider.x)."
        )
    if isinstance(whole, Name):
        return replace(inner[whole.name], name=name)
    return Combined(PartsFormula(names, whole), [inner[one] for one in names], name=name or text)


def _reduced(node: Expression, inner: dict[str, Response]) -> Expression:
    """A reduction, or the final value of a name, as a formula of responses."""

    def own(response: Response) -> Name:
        known = f"part{len(inner)}"
        inner[known] = response
        return Name(known)

    if not isinstance(node, Call):
        return own(Final(str(node)))
    word, of = node.function.name, node.args[0]
    if any(map(is_reduction, of.nodes())):
        raise SarrusError(
            f"{node} has a reduction in a reduction, which cannot be differentiated here. Write it as two responses."
        )
    if word == ERROR:
        raise SarrusError(f"{node} has no derivatives. Leave error() out.")
    if word == "at":
        return own(At(str(of), time=float(node.args[1].value())))
    if word == "mean":
        return own(Integral(str(of))) / own(Integral("1"))
    if word == "rms":
        return call("sqrt", own(Integral(str(of * of))) / own(Integral("1")))
    return own(KINDS[word](str(of)))


KINDS: dict[str, type[Response]] = {
    "final": Final, "initial": Initial, "integral": Integral, "max": Maximum, "min": Minimum
}  # fmt: skip


@dataclass(frozen=True)
class PartsFormula:
    """A formula of responses as a function of their values, or of formulas of these."""

    names: tuple[str, ...]
    tree: Expression

    def __call__(self, *values: Any) -> Any:
        given = dict(zip(self.names, values, strict=True))
        return self.tree.replaced(given) if isinstance(values[0], Expression) else self.tree.value(given)
