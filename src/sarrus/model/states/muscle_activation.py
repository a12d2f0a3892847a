"""Activation dynamics of a muscle: a lag behind its excitation, with time constants that depend on the activation."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from ...functions import maximum, minimum, step
from ..forces.force import Force
from ..measure import In
from ..primitive import Primitive
from ..quantity import fraction, not_negative, positive
from ..signals import Signals
from ..tape import value_of
from .block import StateValue
from .rate_load import rate_loads
from .with_input import WithInput
from .with_nominal import WithNominal


def activation_rate(u: Any, a: Any, rise: Any, fall: Any, width: Any = None) -> Any:
    """ȧ = (u - a)/τ for an excitation u, with τ as in `MuscleActivation`; the switch is smooth over a width."""
    factor = 0.5 + 1.5 * _clamped(a)
    apart, rise, fall = _clamped(u) - a, rise * factor, fall / factor
    if width is None:
        rises = step(apart)
        return apart * (rises / rise + (1 - rises) / fall)
    s = _clamped(apart / width + 0.5)
    return apart / (fall + (rise - fall) * (s * s * s * (s * (6 * s - 15) + 10)))


def _clamped(x: Any) -> Any:
    return maximum(minimum(x, 1), 0)


@dataclass(frozen=True, eq=False, kw_only=True)
class MuscleActivation(WithInput, WithNominal, Force):
    """The activation a of a `Muscle`, which follows its excitation, the input u: ȧ = (u - a)/τ. Its output is its name.

    τ is activation_time · (0.5 + 1.5 a) where u > a, and deactivation_time/(0.5 + 1.5 a) where u < a, as in MuJoCo. An
    input below 0 acts like 0, one above 1 like 1. Without smoothing, derivatives at u = a are those of u < a.

    Parameters
    ----------
    activation_time, deactivation_time
        Time constants [s].
    smoothing
        Range of u - a over which one time constant becomes the other by a polynomial of fifth degree; 0 switches.
    initial
        Its value at the start of a run, from 0 to 1.
    """

    activation_time: Annotated[float, In("s")] = 0.01
    deactivation_time: Annotated[float, In("s")] = 0.04
    smoothing: Annotated[float, In("1")] = 0.0
    initial: Annotated[float, In("1")] = 0.0

    @property
    def absent_numbers(self) -> Collection[tuple[str, ...]]:
        """The smoothing where it is zero, because τ then switches."""
        return () if self.smoothing else [("smoothing",)]

    def states(self) -> Iterator[StateValue]:
        """Yield itself."""
        initial = fraction(self.initial, "initial", "Give the activation at the start.")
        yield StateValue(self.name, initial, "1", self.state_size())

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of its rate."""
        r = self.recording("input", signals)
        rise, fall = (
            r.number(positive(getattr(self, field), field, "Give a time constant in s."))
            for field in ("activation_time", "deactivation_time")
        )
        width = not_negative(self.smoothing, "smoothing", "Give a range of activations, or 0.")
        smooth = r.number(width) if value_of(width) else None
        rate = activation_rate(self.recorded_input(r), r.named(self.name), rise, fall, smooth)
        yield from rate_loads([self.name], [rate], r, signals, "1/s")
