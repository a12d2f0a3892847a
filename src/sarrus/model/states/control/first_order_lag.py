"""First-order lag: time · ẋ + x = gain · input."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ...forces.force import Force
from ...measure import In
from ...primitive import Primitive
from ...quantity import number, positive
from ...signals import Signals
from ..block import StateValue
from ..rate_load import rate_loads
from ..with_input import WithInput
from ..with_nominal import WithNominal


@dataclass(frozen=True, eq=False, kw_only=True)
class FirstOrderLag(WithInput, WithNominal, Force):
    """A sensor, filter or actuator x with time · ẋ + x = gain · input. Its output is its name.

    Parameters
    ----------
    time
        Time constant [s].
    gain
        Of its input.
    initial
        Its value at the start of a run.
    unit
        Of x, for plots and tables.
    """

    time: Annotated[float, In("s")]
    gain: Annotated[float, In("")] = 1.0
    initial: Annotated[float, In("")] = 0.0
    unit: str = ""

    def states(self) -> Iterator[StateValue]:
        """Yield itself."""
        yield StateValue(self.name, number(self.initial, "initial"), self.unit, self.state_size())

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of its rate."""
        r = self.recording("input", signals)
        time, gain = positive(self.time, "time", "Give a time constant in s."), number(self.gain, "gain")
        rate = (r.number(gain) * self.recorded_input(r) - r.named(self.name)) / r.number(time)
        yield from rate_loads([self.name], [rate], r, signals, f"{self.unit or '1'}/s")
