"""A first-order state by a formula or function of its rate: ẋ = f(x, outputs, t, parameters)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..forces.force import Force
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import number
from ..signals import Signals
from .block import StateValue, WithNominal, rate_loads


@dataclass(frozen=True, eq=False, kw_only=True)
class StateVariable(WithParameters, WithNominal, Force):
    """A state variable x with ẋ = f(x, outputs, t, parameters), such as a current, a temperature or a filtered signal.

    Its value is the output with its name, ``run["current"]``, which formulas of forces and of other states may use;
    ``current.rate`` is ẋ. In an equilibrium f is zero.

    Parameters
    ----------
    rate
        f: a number; a text such as ``"(U - R*current - k*pin.rate)/L"`` of its own name or ``x``, outputs, other
        states, ``t`` and ``parameters``; a Python function of arguments with these names, ``lambda x, t: ...``, or of
        one that has all outputs, ``lambda o: -o["current"]``; or a table over what ``over`` names.
    initial
        Its value at the start of a run.
    unit
        Of x, for plots and tables.
    over
        For a table: an output, or a formula.
    """

    rate: Annotated[Law | None, In("", outputs=True)] = None
    initial: Annotated[float | None, In("")] = None
    unit: str = ""
    over: str = ""

    def states(self) -> Iterator[StateValue]:
        if self.initial is None:
            raise ModelError(
                "its initial value is missing. Give initial=0, or another number.", field="initial"
            )
        yield StateValue(self.name, number(self.initial, "initial"), self.unit, self.state_size())

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of its rate."""
        if self.rate is None:
            raise ModelError(
                "its rate is missing. Give a number, a formula, a function or a table.", field="rate"
            )
        recording = Recording(
            "rate", {"x": self.name}, self.checked_parameters(), variables=signals.variables
        )
        rate, unit = recording.law(self.rate, self.over), f"{self.unit or '1'}/s"
        self.check_units(self.rate, "rate", unit if self.unit else "", recording, signals)
        yield from rate_loads([self.name], [rate], recording, signals, unit)
