"""What parts with states share: the size of their states, by which tolerances are measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ..measure import In
from ..quantity import positive
from ..tape import value_of


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
