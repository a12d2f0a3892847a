"""The Magic Formula 5.2, and PAC2002 of Adams: fewer terms than 6.1, and a pneumatic trail of the whole lateral force.

H. B. Pacejka, Tyre and Vehicle Dynamics, 2nd edition, 2006, section 4.3; file types 5, 6, 21 and 52. Only what differs
from 6.1 is here. The inclination is scaled by LGAX, LGAY and LGAZ in F_x, F_y and M_z.
"""

from __future__ import annotations

from typing import Any

from ...._jit.formulas.functions import atan, sin
from .law import Slip
from .magic_formula import Pure
from .magic_formula_61 import MagicFormula61
from .rounding import EDGE, rounded_absolute


class MagicFormula52(MagicFormula61):
    """The Magic Formula 5.2 of coefficients by their names in .tir files."""

    def longitudinal(self, slip: Slip) -> Pure:
        return super().longitudinal(slip._replace(gamma=slip.gamma * self.LGAX))

    def lateral(self, slip: Slip, gamma: Any) -> Pure:
        return super().lateral(slip, gamma * self.LGAY)

    def aligning_moment(
        self, slip: Slip, x: Pure, y: Pure, F_x: Any, F_y: Any, trailing: Any, G_y: Any
    ) -> Any:
        inclined = slip._replace(gamma=slip.gamma * self.LGAZ)
        return super().aligning_moment(inclined, x, y, F_x, F_y, trailing, G_y)

    def cornering_stiffness(self, F_z: Any, gamma: Any) -> Any:
        """K_yα [N/rad]: PKY4 is 2, and the inclination does not change the load of the largest stiffness."""
        F_0 = self.nominal_load
        K = self.PKY1 * F_0 * sin(2 * atan(F_z / (self.PKY2 * F_0))) * self.LKY
        return K * (1 - self.PKY3 * rounded_absolute(gamma, EDGE))

    def camber_shift(self, slip: Slip, gamma: Any, K: Any, S_Vg: Any) -> Any:
        """PHY3 γ."""
        return self.PHY3 * gamma * self.LKYC

    def trailing_force(self, slip: Slip, G_y: Any, F_y: Any, shift: Any) -> Any:
        """F_y without the part of the longitudinal slip [N]."""
        return F_y - shift

    def rolling_resistance(self, slip: Slip, F_x: Any) -> Any:
        """M_y = -R_0 F_z LMY (QSY1 + ...) [N m]."""
        M = self.rolling_terms(slip, F_x)
        return -self.UNLOADED_RADIUS * slip.load * self.LMY * M * slip.direction
