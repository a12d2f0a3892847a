"""The brush: bristles with a parabolic pressure, and one friction for all directions.

[P12 3.2]: with the direction d of V_x (1, and -1 in reverse), the slips σ_x = κ/(1 + κ d), σ_y = tan α/(1 + κ d), the
elastic force g = √((C_x σ_x)² + (C_y σ_y)²) and l = 3 μ F_z,

    F = g - g²/l + g³/(3 l²) for g < l, else μ F_z;      F_x = F C_x σ_x/g,  F_y = -F C_y σ_y/g
    t = (a/3) (1 - g/l)³/(1 - g/l + (g/l)²/3),           M_z = -t F_y d

F is twice continuously differentiable over g. Without slip, the second derivative of a force over its slip changes its
sign, within elastic forces of 1e-6 N. 1 + κ d is at least `LOCKED`, as a locked wheel has κ d = -1.
"""

from __future__ import annotations

from typing import Any

from ...._jit.formulas.functions import minimum, ramp, sqrt
from .law import Slip, TyreLaw, Wrench
from .rounding import LOCKED, SMALLEST, at_least


class Brush(TyreLaw):
    """The brush of the coefficients radius, k, c, c_kappa, c_alpha, mu, half_length."""

    def sliding_slips(self, load: Any) -> tuple[Any, Any]:
        """The slips from which on the whole contact slides, 3 μ F_z/C."""
        return 3 * self.mu * load / self.c_kappa, 3 * self.mu * load / self.c_alpha

    def wrench(self, slip: Slip) -> Wrench:
        ratio = at_least(1 + slip.kappa * slip.direction, LOCKED)
        g_x, g_y = self.c_kappa * slip.kappa / ratio, self.c_alpha * slip.tan_alpha / ratio
        g = sqrt(g_x * g_x + g_y * g_y + SMALLEST * SMALLEST)
        limit = 3 * self.mu * slip.load + SMALLEST
        part = minimum(g / limit, 1)
        share = limit * part * (1 - part * (1 - part / 3)) / g  # F/g
        F_y = -share * g_y
        left = ramp(1 - part)
        trail = self.half_length / 3 * left * left * left / (1 - part + part * part / 3)
        return Wrench(share * g_x, F_y, M_y=self.rolling_moment(slip), M_z=-trail * F_y * slip.direction)
