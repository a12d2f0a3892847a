"""Fiala's tyre: friction that falls with the slip, brush in each direction, without combination of the directions.

E. Fiala, "Seitenkräfte am rollenden Luftreifen", VDI-Z 96 (1954), in the form that Adams/Tire documents:

    U = μ_max - (μ_max - μ_min) min(1, √(κ² + tan² α))
    |κ| < κ_c = U F_z/(2 C):            F_x = C κ;    beyond it  F_x = sgn(κ) [U F_z - (U F_z)²/(4 |κ| C)]
    |tan α| < 3 U F_z/C_α:              F_y = -U F_z (1 - H³) sgn(α),  M_z = U F_z w (1 - H) H³ sgn(α) d
    with H = 1 - C_α |tan α|/(3 U F_z); beyond it  F_y = -U F_z sgn(α),  M_z = 0;
    d is the direction of V_x, -1 in reverse

The law is once continuously differentiable at κ_c, and twice at the sliding angle. The minimum of U is a corner at the
slip 1. F_y has the second derivative ∓C_α²/(3 U F_z) on the two sides of α = 0, between which it changes within 1e-6.
"""

from __future__ import annotations

from typing import Any

from ...._jit.formulas.functions import maximum, minimum, sqrt
from .law import Slip, TyreLaw, Wrench
from .rounding import SMALLEST, rounded_absolute

EDGE = 1e-6  # [-] slip below which its sign and size are rounded


class Fiala(TyreLaw):
    """Fiala's law of the coefficients radius, k, c, c_kappa, c_alpha, mu_max, mu_min, width."""

    def sliding_slips(self, load: Any) -> tuple[Any, Any]:
        """3 μ_max F_z/C: there F_y slides; F_x, which tends to U F_z as the slip grows, is 11/12 of it."""
        return 3 * self.mu_max * load / self.c_kappa, 3 * self.mu_max * load / self.c_alpha

    def rolling_radius(self, loaded: Any, load: Any, spin: Any) -> Any:
        """The loaded radius, as Adams takes it [m]."""
        return loaded

    def friction(self, slip: Slip) -> Any:
        """U F_z [N]."""
        total = sqrt(slip.kappa * slip.kappa + slip.tan_alpha * slip.tan_alpha + SMALLEST * SMALLEST)
        return (self.mu_max - (self.mu_max - self.mu_min) * minimum(total, 1)) * slip.load

    def wrench(self, slip: Slip) -> Wrench:
        N = self.friction(slip)
        z = self.c_alpha * rounded_absolute(slip.tan_alpha, EDGE) / (3 * N + SMALLEST)
        part, elastic = minimum(z, 1), self.c_alpha * slip.tan_alpha
        H = 1 - part
        F_y = -elastic * (1 - part + part * part / 3) / maximum(z, 1)  # N (1 - H³) = C |tan α| (1 - z + z²/3)
        M_z = self.width * elastic / 3 * H * H * H * slip.direction
        return Wrench(self.longitudinal(slip.kappa, N), F_y, M_y=self.rolling_moment(slip), M_z=M_z)

    def longitudinal(self, kappa: Any, N: Any) -> Any:
        """F_x = C κ (2/m - 1/m²) with m = |κ|/κ_c, or 1 below it [N]."""
        m = maximum(2 * self.c_kappa * rounded_absolute(kappa, EDGE) / (N + SMALLEST), 1)
        return self.c_kappa * kappa * (2 / m - 1 / (m * m))
