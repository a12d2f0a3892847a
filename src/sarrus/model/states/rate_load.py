"""The element of rates of states: laws on the slots of a block, which is no force on a body."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..._jit.formulas.expression import Expression as Recorded
from ...algebra import Array, Row
from ...elements import Single
from ...elements.element import Scalar
from ..forces.formula_element import FormulaLoad, Target, load_primitive
from ..laws.recorded import Recording
from ..primitive import Primitive
from ..signals import Signals

SLOTS = 3  # states of a block
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
    for measure in dict.fromkeys(one.measure for one in own):
        chosen = [n for n, one in enumerate(own) if one.measure == measure]
        words = tuple((word, one) for word, (_, one) in further.items())
        act: Any = Rates(tuple(own[n].component for n in chosen), words)
        laws = [*(rates[n] for n in chosen), *(law for law, _ in further.values())]
        yield load_primitive(Target(measure, act), laws, recording, found, unit)
        further = {}
