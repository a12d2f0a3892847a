"""What controllers and filters share: an input that is a formula of outputs, and recorded rates and outputs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from ..._jit.formulas.expression import Expression as Recorded
from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In
from ..signals import Signals

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


class WithOutput:
    """A part whose output is a formula, which others may use by ``name.output``."""

    name: str

    def recorded_output(self, recording: Recording) -> Recorded:
        """Return its output."""
        raise NotImplementedError

    def variables(self) -> Iterator[tuple[str, Any]]:
        """Yield the output."""
        yield f"{self.name}.{OUTPUT}", self.recorded_output
