"""Derivatives of an event's functions by the state: of formulas of outputs, and of Python functions (t, q, v).

Both are recorded at the state of the event, and the record is differentiated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....model.tape import Tape, Tracer
from ....outputs import Outputs
from ....outputs.output import formula_of
from ....outputs.recording import Angles, Key, States, Variable
from ....results import EventStep
from ....system import System
from ...dynamics.events.switching_functions import Corner
from ...dynamics.sampled.control import Sample


class Slopes(NamedTuple):
    """Derivatives of some numbers by q and v (n, nq), of joints' coordinates c (n, nc), t (n, 1), b (n, nb)."""

    q: Array
    v: Array
    c: Array
    t: Array
    b: Array


@dataclass(frozen=True)
class TapeValues:
    """Numbers on a tape, and the places of what they depend on.

    Attributes
    ----------
    sizes : how many there are of each kind of input, in the order of `Slopes`
    copies : how often the state is recorded side by side, each copy with inputs of its own
    """

    tape: Tape
    found: Sequence[Tracer | float]
    places: Mapping[Key, int]
    sizes: Sequence[int]
    copies: int = 1

    @cached_property
    def slopes(self) -> Slopes:
        every = [self.tape.gradient({x.at: 1.0} if isinstance(x, Tracer) else {}) for x in self.found]
        return Slopes._make(
            np.array([self.gathered(bars, kind)[0] for bars in every]) for kind in Slopes._fields
        )

    @cached_property
    def bends(self) -> Slopes:
        """The derivatives of the first number's gradient by q, of which there is a copy for each."""
        every = np.eye(self.copies)
        change = self._changed({place: every[n] for (kind, n), place in self.places.items() if kind == "q"})
        return Slopes._make(self.gathered(change, kind) for kind in Slopes._fields)

    @cached_property
    def bends_by_time(self) -> Slopes:
        """The derivatives of the first number's derivative by the time, each kind (1, n)."""
        change = self._changed({self.places["t", 0]: np.ones(self.copies)})
        return Slopes._make(self.gathered(change, kind)[:1] for kind in Slopes._fields)

    def _changed(self, moved: Mapping[int, Any]) -> list[Any]:
        """The change of the first number's gradient."""
        if not isinstance(self.found[0], Tracer):
            return [0.0] * len(self.tape.entries)
        return self.tape.gradient_along({self.found[0].at: 1.0}, {}, self.tape.along(moved))[1]

    def along(self, dots: Slopes) -> Array:
        """The changes of the numbers, for changes of q, v, c, the time and b, each (n,)."""
        change = self.tape.along(self._moved(dots))
        own = (change[x.at] if isinstance(x, Tracer) else 0.0 for x in self.found)
        return np.array([np.ravel(x)[0] for x in own], dtype=float)

    def turned(self, weights: Array, changes: Array, dots: Slopes) -> Slopes:
        """The change of the gradient of the numbers' sum with weights that change by `changes`, each kind (n,)."""
        pairs = [(x.at, n) for n, x in enumerate(self.found) if isinstance(x, Tracer)]
        bars, bar_dots = ({at: float(row[n]) for at, n in pairs} for row in (weights, changes))
        found = self.tape.gradient_along(bars, bar_dots, self.tape.along(self._moved(dots)))[1]
        return Slopes._make(self.gathered(found, kind)[0] for kind in Slopes._fields)

    def rate_along(self, direction: Array) -> TapeValues:
        """f_q u + f_t s of the first number, for a direction (u, s) (nq + 1,), which takes the place of v."""
        others = {key: place for key, place in self.places.items() if key[0] != "v"}
        moving = [(key, place) for key, place in others.items() if key[0] in ("q", "t")]
        of = {n if kind == "q" else self.sizes[0]: place for (kind, n), place in moving}
        rates = {place: self.tape.variable(float(direction[n])) for n, place in of.items()}
        first, directions = self.found[0], {("v", n): rates[place].at for n, place in of.items()}
        found = self.tape.recorded_along(first, rates) if isinstance(first, Tracer) else 0.0
        sizes = [self.sizes[0], len(direction), *self.sizes[2:]]
        return TapeValues(self.tape, [found], others | directions, sizes)

    def _moved(self, dots: Slopes) -> dict[int, float]:
        """Changes by places."""
        of = dots._asdict()
        return {place: float(of[kind][n]) for (kind, n), place in self.places.items() if kind in of}

    def gathered(self, bars: list[Any], kind: str) -> Array:
        """The gradient by the inputs of one kind, a row for each copy."""
        gathered = np.zeros((self.copies, self.sizes[Slopes._fields.index(kind)]))
        for (own, n), place in self.places.items():
            if own == kind:
                gathered[:, n] = bars[place]
        return gathered


class Copies(Outputs):
    """Outputs of a state that is there several times, each time with numbers of its own."""

    def _value(self, kind: str, n: int) -> Any:
        return np.broadcast_to(super()._value(kind, n), self.states.t.shape)


def recorded(
    system: System, event_step: EventStep, function: Any, b: Array, angles: Angles, copies: int = 1
) -> TapeValues:
    """The value of a formula, with all revolutions of joints, or of what a Python function returns, at an event.

    Raises
    ------
    ValueError
        For Python functions that cannot be recorded.
    """
    if isinstance(function, str):
        state = _state(system, event_step, copies)
        return of_formula(Copies(system, state, b, unknown, angles), function)
    if isinstance(function, Corner | Sample):
        outputs = Copies(system, _state(system, event_step, copies), b, unknown, angles)
        return _recorded(outputs, function.record(outputs))
    return _of_python(event_step, function, _sizes(system))


def _sizes(system: System) -> Sequence[int]:
    return system.nq, system.nq, len(system.joint_coordinates.b), 1, len(system.b)


def _state(system: System, event_step: EventStep, copies: int) -> States:
    one = (np.array(event_step.t), event_step.q, event_step.v, 0 * event_step.q)
    t, q, v, a = (np.tile(x, (copies, *[1] * x.ndim)) for x in one)
    return States(t, q, v, a, lambda: np.zeros((copies, system.m)))


def of_formula(outputs: Outputs, text: str) -> TapeValues:
    """The value of a formula at the states of some outputs."""
    tree = formula_of(outputs.system, text)
    return _recorded(outputs, tree.value({name: outputs(name) for name in tree.names()}))


def _recorded(outputs: Outputs, found: Any) -> TapeValues:
    """A function of some outputs, of its recorded value or values."""
    places = {key: variable.at for key, variable in outputs.inputs.items()} | {("t", 0): outputs.t.at}
    numbers = found if isinstance(found, list) else [found]
    return TapeValues(outputs.tape, numbers, places, _sizes(outputs.system), len(outputs.t.value))


def _of_python(
    event_step: EventStep, function: Callable[[Any, Any, Any], Any], sizes: Sequence[int]
) -> TapeValues:
    tape = Tape()
    t, q, v = tape.variable(event_step.t), _variables(tape, event_step.q), _variables(tape, event_step.v)
    inputs = {(kind, n): x.at for kind, xs in (("t", [t]), ("q", q), ("v", v)) for n, x in enumerate(xs)}
    try:
        found = list(np.ravel(np.asarray(function(t, q.copy(), v.copy()), dtype=object)))
    except Exception as error:  # foreign code: whatever it raises
        raise ValueError(
            f"the event {event_step.name} at t = {event_step.t:.6g} s cannot be differentiated through its Python "
            f"function: {str(error).rstrip('.')}. Write it with arithmetic and NumPy's functions of the entries of q "
            "and v, or as a formula."
        ) from error
    return TapeValues(tape, found, inputs, sizes)


def _variables(tape: Tape, values: Array) -> Array:
    return np.array([tape.variable(float(x)) for x in values], dtype=object)


def unknown(name: str, _: Variable) -> float:
    """Refuse a parameter in an event."""
    raise ValueError(f"an event cannot depend on the number {name!r}. Name outputs of the motion.")
