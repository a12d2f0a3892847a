"""Transfer function: output = (b₀ sᵐ + … + b_m) / (a₀ sⁿ + … + a_n) · input, with m ≤ n."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from ...._jit.formulas.expression import Expression as Recorded
from ...errors import ModelError
from ...forces.force import Force
from ...laws.recorded import Recording
from ...measure import In
from ...quantity import is_list, numbers
from ...show import quote, show
from ..block import StateValue
from ..with_input import InputOutputBlock
from ..with_nominal import WithNominal
from .linear_system import arrays_of

COEFFICIENTS = "Give those of s² + 3 s + 2 as [1, 3, 2]."


@dataclass(frozen=True, eq=False, kw_only=True)
class TransferFunction(InputOutputBlock, WithNominal, Force):
    """A linear controller or filter by its transfer function, from rest.

    Its output is ``name.output``, its states ``name.x1``, ``name.x2``, ... are those of the controller canonical form:
    ẋ₁ = input - a₁ x₁ - … - a_n x_n, ẋ_k = x_(k-1), for a₀ = 1.

    Parameters
    ----------
    numerator, denominator
        Coefficients of falling powers of s, as of `scipy.signal.TransferFunction`; the numerator has no more than the
        denominator.
    unit
        Unit of the output, for plots and tables.
    """

    numerator: Annotated[Sequence[float], In("")]
    denominator: Annotated[Sequence[float], In("")]
    unit: str = ""

    @classmethod
    def of(cls, name: str, system: Any, **given: Any) -> TransferFunction:
        """Return the block of a transfer function of `scipy.signal` or python-control with one input and one output.

        Parameters
        ----------
        name
            Name of the part.
        system
            Object with ``num`` and ``den``, or with ``to_tf()``.
        given
            ``input`` and other fields.

        Raises
        ------
        ModelError
            If it is another object, in discrete time, or has several inputs or outputs.
        """
        part = f"transfer function {quote(name)}"
        arrays = arrays_of(system, "to_tf", ("num", "den"), part)
        above, below = (_flat(values, part) for values in arrays)
        return cls(name, numerator=above, denominator=below, **given)

    @property
    def absent_numbers(self) -> Collection[tuple[str | int, ...]]:
        """The first coefficient of a numerator that is as long as the denominator, if nothing passes through it."""
        above, below = self.numerator, self.denominator
        given = is_list(above) and is_list(below) and 0 < len(above) == len(below)
        return [("numerator", 0)] if given and not above[0] else ()

    def _coefficients(self, field: str) -> list[float]:
        """Its coefficients, which must be numbers."""
        given: Any = getattr(self, field)
        return [*numbers(given, len(given) if is_list(given) else 1, field, COEFFICIENTS)]

    def _checked(self) -> tuple[list[Any], list[Any]]:
        """Numerator with leading zeros, and denominator."""
        above, below = (self._coefficients(field) for field in ("numerator", "denominator"))
        if len(below) < 2 or below[0] == 0.0:
            message = (
                f"denominator must have two coefficients, the first not 0, but is {show(self.denominator)}"
            )
            raise ModelError(f"{message}. {COEFFICIENTS}", field="denominator")
        if not 0 < len(above) <= len(below):
            message = "numerator must have as many coefficients as the denominator, or less. Add poles."
            raise ModelError(message, field="numerator")
        return [0.0] * (len(below) - len(above)) + above, below

    def states(self) -> Iterator[StateValue]:
        """Yield its states."""
        for n in range(1, len(self._checked()[1])):
            yield StateValue(f"{self.name}.x{n}", 0.0, nominal=self.state_size())

    def laws(self, r: Recording) -> tuple[list[Recorded], Recorded]:
        """Return its rates, and its output."""
        above, below = ([r.number(value) for value in values] for values in self._checked())
        x = [r.named(f"{self.name}.x{n}") for n in range(1, len(below))]
        first = self.recorded_input(r)
        for a, one in zip(below[1:], x, strict=True):
            first = first - a / below[0] * one
        through = above[0] / below[0] * first if any(self._checked()[0][:1]) else 0.0
        return [first, *x[:-1]], through + self._of_states(r)

    def recorded_output(self, recording: Recording) -> Recorded:
        """Return its output."""
        return self.laws(recording)[1] if any(self._checked()[0][:1]) else self._of_states(recording)

    def _of_states(self, r: Recording) -> Recorded:
        """Its output, where it does not depend on the input itself."""
        above, below = self._checked()
        scale, found = r.number(below[0]), r.graph.constant(0.0)
        for n, b in enumerate(above[1:], 1):
            found = found + r.number(b) / scale * r.named(f"{self.name}.x{n}")
        return found


def _flat(values: Any, part: str) -> list[float]:
    """The coefficients of one input and one output."""
    while hasattr(values, "__len__") and hasattr(values[0], "__len__"):
        if len(values) > 1:
            message = "system has several inputs or outputs. Give one transfer function for each."
            raise ModelError(message, part=part)
        values = values[0]
    return [float(value) for value in values]
