"""Values of the outputs of events, and their exact derivatives for impacts."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.expression import Expression, Name, parse
from ....model.expression.tree import lift
from ....model.tape import value_of
from ....outputs import Level, Output, Outputs, find_output
from ....outputs.measure import measured
from ....outputs.output import formula_of
from ....outputs.recording import States
from ....system import System
from ...equations.motion import EquationsOfMotion
from ...redundancy.redundant_constraints import Independence

EVENT, IMPACT = "an event", "an impact"
NAME = re.compile(r"[^\W\d][\w-]*(\([^()]*\))?(\.[\w-]+)*")


class Names:
    """Outputs by name as formulas, for functions of outputs: their values are then formulas."""

    t = Name("t")

    def __call__(self, name: str) -> Expression:
        """A name, or a formula."""
        return Name(name) if NAME.fullmatch(name) else parse(name)

    __getitem__ = __call__


def takes_outputs(function: Callable[..., Any]) -> bool:
    """Whether a function has one argument: all outputs."""
    try:
        return len(inspect.signature(function).parameters) == 1
    except ValueError:
        return False


def as_formula(given: Any, what: str) -> Any:
    """The formula of a function of outputs; what is no function remains.

    Raises
    ------
    TypeError
        For a function whose value is no formula of outputs.
    """
    if given is None or isinstance(given, str):
        return given
    try:
        return str(lift(given(Names())))
    except Exception as error:  # foreign code: whatever it raises
        raise TypeError(
            f'{what} must be a formula, such as "ball.z", or a function of outputs by name, got {given!r:.60}: '
            f"{str(error).rstrip('.')}. Write a formula."
        ) from None


class EventOutput:
    """A formula of a system's outputs, with its exact derivatives by the position and by the time.

    Angles are counted in revolutions from their value at the last state asked for.
    """

    def __init__(self, system: System, text: str) -> None:
        self._system, self._tree, self._b = system, formula_of(system, text), system.b.copy()
        self._outputs = {
            name: find_output(system, name, Level.ACCELERATION, EVENT) for name in self._tree.names()
        }
        of_position = [name for name, one in self._outputs.items() if one.element and one.place is None]
        self._measures = {name: measured(system, name, IMPACT) for name in of_position}
        self._near: dict[str, float | None] = dict.fromkeys(of_position)
        self._recording = any(one.element is None and one.place is None for one in self._outputs.values())
        self._rates: dict[str, Expression] = {name: self._tree.derivative(name) for name in self._outputs}
        self._motion: tuple[Independence, EquationsOfMotion] | None = None

    def _values(self, t: float, q: Array, v: Array) -> dict[str, float]:
        if self._recording:
            self._system.remember(q, self._b, t)
        return {name: self._value(name, one, t, q, v) for name, one in self._outputs.items()}

    def _value(self, name: str, output: Output, t: float, q: Array, v: Array) -> float:
        if output.place is not None:
            return float(q[output.place])
        if name not in self._near:
            return t if name == "t" else self._recorded(output, t, q, v)
        near = self._near[name]
        if near is None and output.name not in self._system.joint_coordinates.names:
            near = self._recorded(output, t, q, v)
        self._near[name] = self._measures[name].value(q, near)
        return float(self._near[name] or 0.0)

    def _recorded(self, output: Output, t: float, q: Array, v: Array) -> float:
        """The value of any output."""
        a, lam = (
            (0 * q, np.zeros(self._system.m)) if output.level < Level.ACCELERATION else self._solved(t, q, v)
        )
        states = States(np.array([t]), q[None], v[None], a[None], lambda: lam[None])
        found = output.record(Outputs(self._system, states, self._b, _no_parameter))
        return float(np.ravel(value_of(found))[0])

    def _solved(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """Accelerations and multipliers, those of least norm where constraints are redundant."""
        if self._motion is None:
            choice = Independence(self._system, q, t)
            self._motion = choice, EquationsOfMotion(self._system, choice.rows)
        choice, motion = self._motion
        if choice.renew(t, q):
            motion.keep(choice.rows)
        motion.b[:] = self._b
        a, lam = motion.acceleration(t, q, v)
        return a, lam if choice.rows is None else choice.shortest(t, q, lam)

    def __call__(self, t: float, q: Array, v: Array) -> float:
        return float(self._tree.value(self._values(t, q, v)))

    @property
    def near(self) -> Array:
        """The angles at the last state asked for; not a number before the first."""
        return np.array([np.nan if x is None else x for x in self._near.values()])

    @near.setter
    def near(self, values: Array) -> None:
        for name, x in zip(self._near, values, strict=True):
            self._near[name] = None if np.isnan(x) else float(x)

    def near_start(self, coordinates: Array, memory: Array) -> None:
        """Take all joints' coordinates at the start, with their revolutions, and what elements remember."""
        every = self._system.joint_coordinates
        for name in self._near:
            known = self._outputs[name].name in every.names
            self._near[name] = float(coordinates[every.index(self._outputs[name].name)]) if known else None
        if len(memory):
            self._b[self._system.memory_places] = memory

    def refuse_no_gradient(self) -> None:
        """Refuse outputs that an impact cannot be along.

        Raises
        ------
        UnknownOutput
        """
        for name, one in self._outputs.items():
            if one.place is None and name != "t":
                measured(self._system, name, IMPACT)

    def gradient(self, t: float, q: Array, v: Array) -> tuple[Array, float]:
        """Its derivatives by q (nq,), and by the time where the formula names it."""
        values, by_q, by_t = self._values(t, q, v), np.zeros(self._system.nq), 0.0
        for name, tree in self._rates.items():
            place, rate = self._outputs[name].place, float(tree.value(values))
            if place is not None:
                by_q[place] += rate
            elif name == "t":
                by_t += rate
            else:
                measure = self._measures.get(name) or measured(self._system, name, IMPACT)
                by_q += rate * measure.gradient(q).toarray()[0]
        return by_q, by_t


def _no_parameter(name: str, _: Any) -> float:
    raise ValueError(f"an event cannot depend on the parameter {name!r}. Name outputs of the motion.")
