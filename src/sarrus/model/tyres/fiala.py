"""Tyre with Fiala's law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from ...elements.forces.tyres import Fiala, TyreLaw
from ..errors import ModelError
from ..forces.force import Force
from ..measure import In, Length, Ratio
from ..quantity import not_negative, positive
from .rolling_tyre import SimpleTyre


@dataclass(frozen=True, eq=False, kw_only=True)
class FialaTyre(SimpleTyre, Force):
    """A rolling tyre with the law of Fiala, in the form of Adams: five numbers that a data sheet has.

    Its friction falls from ``mu_max`` to ``mu_min`` as the slip √(κ² + tan² α) goes from 0 to 1. The directions are not
    combined otherwise.

    Parameters
    ----------
    c_kappa
        Longitudinal slip stiffness [N], the slope of F_x over κ.
    c_alpha
        Cornering stiffness [N/rad], greater than 0.
    mu_max, mu_min
        Friction without slip, and at full slip.
    width
        Of the tyre [m], for the aligning moment.
    """

    c_kappa: Annotated[float, In("N")]
    c_alpha: Annotated[float, In("N/rad")]
    mu_max: Ratio
    mu_min: Ratio | None = None
    width: Length = 0.0

    def tyre_law(self) -> tuple[type[TyreLaw], Mapping[str, Any]]:
        largest = positive(self.mu_max, "mu_max", "Give the coefficient of friction.")
        least = largest if self.mu_min is None else positive(self.mu_min, "mu_min", "Give that at full slip.")
        if float(least) > float(largest):
            message = f"mu_min must not be greater than mu_max, but they are {float(least):g} and {float(largest):g}"
            raise ModelError(f"{message}. Exchange them.", field="mu_min")
        return Fiala, self.wheel() | {
            "c_kappa": positive(self.c_kappa, "c_kappa", "Give the slip stiffness in N."),
            "c_alpha": positive(self.c_alpha, "c_alpha", "Give the cornering stiffness in N/rad."),
            "mu_max": largest,
            "mu_min": least,
            "width": not_negative(self.width, "width", "Give it in m."),
        }
