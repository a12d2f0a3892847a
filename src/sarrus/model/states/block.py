"""Blocks of states: three states are the velocities of a hidden body of unit mass that only translates.

    m v̇ = m f(v, outputs, t),    x = v

so that x' = f is one of the equations of motion, with all its derivatives, in every method. Unused slots of the body
are held by constraints. See decision 046.

States that drivers follow are two coordinates of such a body; the third is a clock τ = t: ṡ - f(s, outputs, τ) τ̇ = 0.

The rate of a state s that drivers follow is a constraint on velocities, with the clock τ = t of its block:

    ṡ - f(s, positions, τ) τ̇ = 0
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ... import elements
from ..._jit.formulas.expression import Expression as Recorded
from ...algebra import I3, Array, Row
from ...elements import InertiaElement, Nonholonomic, Single
from ...elements.element import POSITION, ROTATION, Grid, Kind, Scalar, Time
from ..arithmetic import Numeric
from ..coordinates import CoordinateBlock
from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..forces.formula_element import FormulaLoad, OutputLaws, Target, load_primitive
from ..laws.jumps import jumps
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import positive
from ..show import quote
from ..signals import Measure, Signal, Signals
from ..tape import value_of

STATES = Kind("states", POSITION.parts, True)  # displacements of a hidden body
SLOTS, CLOCK = 3, 2  # states of a block; the slot of the clock where drivers follow them
RATE = "rate"


class RateLoad(FormulaLoad, abstract=True):
    """Base of the classes of rates: they have no force, torque or power, and a single one is the output ``rate``."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        words = {RATE, *(word for word, _ in getattr(cls.structure.act, "outputs", ()))}
        cls.outputs = {word: one for word, one in cls.outputs.items() if word in words}

    def power(self, x: Any, v: Any, t: Scalar) -> Scalar:
        """Zero: states are no motion."""
        return 0


@dataclass(frozen=True)
class Slots:
    """The states of a block, as functions of the velocities of its body."""

    fields: ClassVar[dict[str, str]] = {"mass": "Scalar"}
    bodies: ClassVar[int] = 1
    load: ClassVar[type[FormulaLoad]] = RateLoad
    word: ClassVar[str] = RATE

    mass: Scalar  # [kg] of the block

    def values(self, x: Single, v: Single) -> Array:
        """The three states."""
        return v.r

    def positions(self, x: Single) -> Array:
        """The states that drivers follow."""
        return x.r


class Rates(NamedTuple):
    """What laws of rates load: m f on the slots of their states. Further laws are outputs, of a word and a unit."""

    places: tuple[int, ...]
    outputs: tuple[tuple[str, str], ...] = ()

    def __call__(self, of: Any, values: Any, x: Any, v: Any, t: Any) -> Row:
        """Q of the rates' values."""
        found: list[Any] = [0] * SLOTS
        for place, value in zip(self.places, values, strict=False):
            found[place] = of.mass * value
        return np.array(found), None


class RateConstraint(OutputLaws, Nonholonomic, abstract=True):
    """ṡ - f τ̇ = 0 for the states of a block that drivers follow. Its multipliers act on the block alone."""

    def Phi_q_xi(self, x: Any, xi: Any) -> Array:
        last = len(self.structure.parts) - 1
        clock, rates = self._local(last, x).r[CLOCK], self._local(last, xi).r
        act = self.structure.act
        assert isinstance(act, Constrained)
        pairs = zip(act.places, self.values(x, x, clock), strict=True)
        return np.array([rates[place] - value * rates[CLOCK] for place, value in pairs])


class Constrained(NamedTuple):
    """Slots whose rates are constraints."""

    places: tuple[int, ...]
    base: type[OutputLaws] = RateConstraint

    @property
    def rows(self) -> int:
        """Number of equations."""
        return len(self.places)


def rate_loads(
    names: Sequence[str],
    rates: Sequence[Recorded],
    recording: Recording,
    signals: Signals,
    unit: str = "",
    outputs: Mapping[str, tuple[Recorded, str]] | None = None,
) -> Iterator[Primitive]:
    """Yield the loads of some states' rates, one for each block.

    Parameters
    ----------
    names, rates
        The states, and their recorded rates.
    recording
        On which they are.
    signals
        Of the model.
    unit
        Of a single rate, which is an output then.
    outputs
        Further laws by word, with their units, which are outputs of the part.
    """
    further = outputs or {}
    states = [signals.states[name] for name in names]
    found = signals.of(recording)
    signals.used.update(dict.fromkeys(names, tuple(recording.signals)))
    for measure in dict.fromkeys(state.measure for state in states):
        chosen = [n for n, state in enumerate(states) if state.measure == measure]
        words = tuple((word, state) for word, (_, state) in further.items())
        act = Rates(tuple(states[n].component for n in chosen), words)
        laws = [*(rates[n] for n in chosen), *(law for law, _ in further.values())]
        yield load_primitive(Target(measure, act), laws, recording, found, unit)
        further = {}
        if names[chosen[0]] in signals.followed:
            yield _constraint([names[n] for n in chosen], [rates[n] for n in chosen], recording, signals)


def _constraint(
    names: Sequence[str], rates: Sequence[Recorded], recording: Recording, signals: Signals
) -> Primitive:
    """Return the constraint of the rates of states that drivers follow.

    Raises
    ------
    ModelError
        If a rate depends on velocities, or jumps.
    """
    field, found = recording.field, signals.of(recording)
    followed = f"the driver {signals.followed[names[0]]} follows {names[0]}"
    moving = [name for name, one in zip(recording.signals, found, strict=True) if one.arguments > 1]
    if moving:
        message = f"{field} uses {quote(moving[0])}, but {followed}, whose rate may use states, positions and t only"
        raise ModelError(f"{message}. Replace the driver by a force with a stiff controller.", field=field)
    if any(jumps(rate) for rate in rates):
        message = f"{field} jumps, but {followed}, whose rate must be continuous"
        raise ModelError(f"{message}. Use step(t, t0, 0, t1, 1), or a table.", field=field)
    states = [signals.states[name] for name in names]
    act = Constrained(tuple(one.component for one in states))
    made = load_primitive(Target(states[0].measure, act), list(rates), recording, found)
    return made._replace(label="rate constraint")


class StateValue(NamedTuple):
    """A state of a part: its name as an output, its initial value, its unit, and its size for tolerances.

    States with the same name of a ``block`` are all that is in it, in their order; its mass is 1 kg.
    """

    name: str
    initial: Numeric
    unit: str = ""
    nominal: float = 1.0
    block: str = ""


class StateInertia(InertiaElement, derivatives="automatic", rare=True, registered=False):
    """The inertia of a block: a mass that translates."""

    mass: Scalar  # [kg] a scale alone, which the states do not depend on

    def M(self, x: Single) -> Grid:
        return (self.mass * I3, None), (None, None)

    def S(self, x: Single, v: Single) -> Row:
        return None, None


class Unused(elements.Primitive, abstract=True):
    """Slots of a block without a state, and its rotation, are held."""

    used: ClassVar[int]

    def Phi(self, x: Single) -> Array:
        return np.array([*x.r[self.used :], *x.p[1:]])


class UnusedAfterOne(Unused, rows=5, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with one state."""

    used = 1


class UnusedAfterTwo(Unused, rows=4, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with two states."""

    used = 2


class UnusedAfterThree(Unused, rows=3, bodies=1, derivatives="automatic", rare=True, registered=False):
    """Of a block with three states."""

    used = 3


class Clocked(Unused, abstract=True):
    """The same with a clock in the last slot, for states that drivers follow."""

    t: Time  # which subclasses declare

    def Phi(self, x: Single) -> Array:
        return np.array([*x.r[self.used : CLOCK], x.r[CLOCK] - self.t, *x.p[1:]])


class ClockedAfterOne(Clocked, rows=5, bodies=1, derivatives="automatic", rare=True, registered=False):
    """A block with one state and a clock."""

    used = 1
    t: Time


class ClockedAfterTwo(Clocked, rows=4, bodies=1, derivatives="automatic", rare=True, registered=False):
    """A block with two states and a clock."""

    used = 2
    t: Time


UNUSED: tuple[type[Unused], ...] = (UnusedAfterOne, UnusedAfterTwo, UnusedAfterThree)
CLOCKED: tuple[type[Unused], ...] = (ClockedAfterOne, ClockedAfterTwo)


class Block(NamedTuple):
    """A block: the name of its body, its states, its mass, and whether drivers follow the states."""

    name: str
    states: tuple[StateValue, ...]
    mass: float
    followed: bool = False

    def coordinates(self) -> CoordinateBlock:
        """Its coordinates and velocities at the start."""
        values = [*(state.initial for state in self.states), 0.0, 0.0, 0.0][:SLOTS]
        still, upright = [0.0] * SLOTS, ROTATION.ground
        q, v = (values, still) if self.followed else (still, values)
        return CoordinateBlock(self.name, (STATES, ROTATION), (*q, *upright), (*v, 0.0, 0.0, 0.0, 0.0))

    def primitives(self) -> tuple[Primitive, Primitive]:
        """Its inertia, and the constraints of what is unused."""
        unused = (CLOCKED if self.followed else UNUSED)[len(self.states) - 1]
        return (
            Primitive(StateInertia, (self.name,), (self.mass,), "states"),
            Primitive(unused, (self.name,), (), "unused"),
        )

    def signals(self) -> Mapping[str, Signal]:
        """The states by name, for formulas."""
        measure = Measure(Slots, (self.name,), (self.mass,))
        read = ("positions", 1) if self.followed else ("values", 2)
        return {one.name: Signal(measure, *read, n, one.unit) for n, one in enumerate(self.states)}


def blocks_of(
    states: Iterable[StateValue], masses: Iterable[Any], followed: Collection[str] = ()
) -> tuple[Block, ...]:
    """The blocks of states, those that drivers follow last.

    Their mass is a power of two near the largest of the bodies' `masses`.
    """
    every, largest = list(states), max((float(value_of(mass)) for mass in masses), default=0.0)
    mass = float(2.0 ** np.round(np.log2(largest))) if largest > 0 else 1.0
    blocks: list[Block] = []
    for kind, size in ((False, SLOTS), (True, CLOCK)):
        own = [one for one in every if (one.name in followed) == kind and not one.block]
        for n in range(0, len(own), size):
            blocks.append(Block(f"states {len(blocks) + 1}", tuple(own[n : n + size]), mass, kind))
    named = dict.fromkeys(one.block for one in every if one.block)
    return *blocks, *(Block(name, tuple(one for one in every if one.block == name), 1.0) for name in named)


@dataclass(frozen=True, eq=False, kw_only=True)
class WithNominal:
    """A part with a ``nominal`` size of its states.

    Parameters
    ----------
    nominal
        A typical size of its states, in their unit; tolerances are relative to at least a thousandth of it.
    """

    nominal: Annotated[float, In("")] = 1.0

    def state_size(self) -> float:
        """Return the size of its states."""
        return float(value_of(positive(self.nominal, "nominal", "Give a usual size.")))


OUTPUT = "output"


@dataclass(frozen=True, eq=False, kw_only=True)
class WithInput(WithParameters):
    """A part with an ``input``.

    Parameters
    ----------
    input
        A number; a formula of outputs, states, ``t`` and ``parameters``, such as ``"0.3 - pin.angle"``; or a function.
    """

    input: Annotated[Law | None, In("", outputs=True)] = None

    def recording(self, field: str, signals: Signals) -> Recording:
        """Return a recording of its laws."""
        return Recording(field, {}, self.checked_parameters(), variables=signals.variables)

    def recorded_input(self, recording: Recording) -> Recorded:
        if self.input is None:
            raise ModelError("its input is missing. Give a formula, such as 'pin.angle'.", field="input")
        return self.recorded_law(recording, "input", self.input)


class InputOutputBlock(WithInput, ABC):
    """A controller or filter whose output is a formula, which others may use by ``name.output``."""

    name: str
    unit: str

    @abstractmethod
    def states(self) -> Iterator[StateValue]:
        """Yield its states."""

    @abstractmethod
    def laws(self, r: Recording) -> tuple[list[Recorded], Recorded]:
        """Return the rates of its states, and its output."""

    def recorded_output(self, recording: Recording) -> Recorded:
        return self.laws(recording)[1]

    def variables(self) -> Iterator[tuple[str, Callable[[Recording], Recorded]]]:
        yield f"{self.name}.{OUTPUT}", self.recorded_output

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the loads of its rates."""
        r = self.recording("input", signals)
        rates, output = self.laws(r)
        names = [one.name for one in self.states()]
        yield from rate_loads(names, rates, r, signals, outputs={OUTPUT: (output, self.unit)})
