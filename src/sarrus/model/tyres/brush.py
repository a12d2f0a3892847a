"""Tyre with the law of the brush."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from ...elements.forces.tyres import Brush, TyreLaw
from ..forces.force import Force
from ..measure import In, Length, Ratio
from ..quantity import not_negative, positive
from .rolling_tyre import SimpleTyre


@dataclass(frozen=True, eq=False, kw_only=True)
class BrushTyre(SimpleTyre, Force):
    """A rolling tyre with the law of the brush: the simplest one whose directions share one friction.

    Parameters
    ----------
    c_kappa
        Longitudinal slip stiffness [N], the slope of F_x over κ.
    c_alpha
        Cornering stiffness [N/rad], greater than 0.
    mu
        Coefficient of friction.
    half_length
        Of the contact [m], for the aligning moment.
    """

    c_kappa: Annotated[float, In("N")]
    c_alpha: Annotated[float, In("N/rad")]
    mu: Ratio
    half_length: Length = 0.0

    def tyre_law(self) -> tuple[type[TyreLaw], Mapping[str, Any]]:
        return Brush, self.wheel() | {
            "c_kappa": positive(self.c_kappa, "c_kappa", "Give the slip stiffness in N."),
            "c_alpha": positive(self.c_alpha, "c_alpha", "Give the cornering stiffness in N/rad."),
            "mu": positive(self.mu, "mu", "Give the coefficient of friction."),
            "half_length": not_negative(self.half_length, "half_length", "Give it in m."),
        }
