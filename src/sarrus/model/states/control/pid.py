"""PID controller with a filtered derivative, limits and anti-windup."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Annotated

from ...._jit.formulas.expression import Expression as Recorded
from ....functions import maximum, minimum
from ...errors import ModelError
from ...forces.force import Force
from ...laws.recorded import Recording
from ...measure import In
from ...quantity import number, positive
from ..block import StateValue
from ..with_input import InputOutputBlock
from ..with_nominal import WithNominal


@dataclass(frozen=True, eq=False, kw_only=True)
class PID(InputOutputBlock, WithNominal, Force):
    """A controller of an error e, its ``input``: u = kp e + ki ∫e dt + kd ė, within limits.

    The derivative is filtered, ė ≈ (e - f) / filter with ḟ = (e - f) / filter. Where u is limited, the integral follows
    by back-calculation, ∫(e + (limited - u) / (ki · tracking)) dt. Its output is ``name.output``, its states are
    ``name.integral`` and ``name.filtered``.

    Parameters
    ----------
    kp, ki, kd
        Gains of the error, of its integral [1/s] and of its derivative [s].
    filter
        Time constant of the derivative's filter [s]; needed with kd.
    lower, upper
        Limits of u.
    tracking
        Time constant of the anti-windup [s].
    unit
        Of u, for plots and tables.
    """

    kp: Annotated[float, In("")] = 0.0
    ki: Annotated[float, In("")] = 0.0
    kd: Annotated[float, In("")] = 0.0
    filter: Annotated[float | None, In("s")] = None
    lower: Annotated[float | None, In("")] = None
    upper: Annotated[float | None, In("")] = None
    tracking: Annotated[float, In("s")] = 0.1
    unit: str = ""

    @property
    def absent_numbers(self) -> Collection[tuple[str, ...]]:
        """Gains that are 0 where others have a further term, by the derivative's filter or by limits."""
        limited = self.lower is not None or self.upper is not None
        absent = {"kd": not self.kd and self.filter is None, "ki": not self.ki and limited}
        return [(name,) for name, one in absent.items() if one]

    def states(self) -> Iterator[StateValue]:
        """Yield the integral of the error and its filtered value."""
        if self.kd and self.filter is None:
            raise ModelError("filter is missing, which kd needs. Give a time constant in s.", field="filter")
        yield StateValue(f"{self.name}.integral", 0.0, nominal=self.state_size())
        if self.filter is not None:
            yield StateValue(f"{self.name}.filtered", 0.0, nominal=self.state_size())

    def laws(self, r: Recording) -> tuple[list[Recorded], Recorded]:
        """Return its rates, and its output."""
        e, integral = self.recorded_input(r), r.named(f"{self.name}.integral")
        u = r.number(number(self.kp, "kp")) * e + r.number(number(self.ki, "ki")) * integral
        rates = []
        if self.filter is not None:
            time = r.number(positive(self.filter, "filter", "Give a time constant in s."))
            slope = (e - r.named(f"{self.name}.filtered")) / time
            u, rates = u + r.number(number(self.kd, "kd")) * slope, [slope]
        limited = u
        if self.lower is not None:
            limited = maximum(limited, r.number(number(self.lower, "lower")))
        if self.upper is not None:
            limited = minimum(limited, r.number(number(self.upper, "upper")))
        if limited is not u:
            back = r.number(positive(self.tracking, "tracking", "Give a time constant in s."))
            if self.ki:
                e = e + (limited - u) / (r.number(number(self.ki, "ki")) * back)
            else:
                e = (
                    -integral / back
                )  # nothing depends on it, so that it rests where the error does not vanish
        return [e, *rates], limited
