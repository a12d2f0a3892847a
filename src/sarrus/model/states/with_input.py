"""What controllers and filters share: an input that is a formula of outputs, and recorded rates and outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated

from ..._jit.formulas.expression import Expression as Recorded
from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..signals import Signals
from .block import StateValue
from .rate_load import rate_loads

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
        """Return its input."""
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
        """Return its output."""
        return self.laws(recording)[1]

    def variables(self) -> Iterator[tuple[str, Callable[[Recording], Recorded]]]:
        """Yield the output."""
        yield f"{self.name}.{OUTPUT}", self.recorded_output

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the loads of its rates."""
        r = self.recording("input", signals)
        rates, output = self.laws(r)
        names = [one.name for one in self.states()]
        yield from rate_loads(names, rates, r, signals, outputs={OUTPUT: (output, self.unit)})
