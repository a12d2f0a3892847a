"""The elements of rates of states: laws on the slots of a block, which is no force on a body.

The rate of a state s that drivers follow is a constraint on velocities, with the clock τ = t of its block:

    ṡ - f(s, positions, τ) τ̇ = 0
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..._jit.formulas.expression import Expression as Recorded
from ...algebra import Array, Row
from ...elements import Nonholonomic, Single
from ...elements.element import Scalar
from ..errors import ModelError
from ..forces.formula_element import FormulaLoad, OfOutputs, Target, load_primitive
from ..laws.jumps import jumps
from ..laws.recorded import Recording
from ..primitive import Primitive
from ..show import quote
from ..signals import Signals

SLOTS, CLOCK = 3, 2  # states of a block; the slot of the clock where drivers follow them
RATE = "rate"


class RateLoad(FormulaLoad, abstract=True):
    """Base of the classes of rates: they have no force, torque or power, and a single one is the output ``rate``."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        words = {RATE, *(word for word, _ in getattr(cls.structure.act, "outputs", ()))}
        cls.outputs = {word: one for word, one in cls.outputs.items() if word in words}


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


class RateConstraint(OfOutputs, Nonholonomic, abstract=True):
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
    base: type[OfOutputs] = RateConstraint

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
    own = [signals.states[name] for name in names]
    found = signals.of(recording)
    signals.used.update(dict.fromkeys(names, tuple(recording.signals)))
    for measure in dict.fromkeys(one.measure for one in own):
        chosen = [n for n, one in enumerate(own) if one.measure == measure]
        words = tuple((word, one) for word, (_, one) in further.items())
        act = Rates(tuple(own[n].component for n in chosen), words)
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
    own = [signals.states[name] for name in names]
    act = Constrained(tuple(one.component for one in own))
    made = load_primitive(Target(own[0].measure, act), list(rates), recording, found)
    return made._replace(label="rate constraint")
