"""The Magic Formula 6.1 and 6.2, complete: its moments, and forces and moments together.

Equation numbers as in `magic_formula`. At standstill the sign of V_x is rounded (`Slip.direction`).
"""

from __future__ import annotations

from math import pi
from typing import Any

from ...._jit.formulas.functions import atan, cos, exp, log, minimum, sin, sqrt, tan
from .law import Slip, Wrench
from .magic_formula import MC, MagicFormulaForces, Pure, over
from .rounding import EDGE, SMALLEST, rounded_absolute


class MagicFormula61(MagicFormulaForces):
    """The Magic Formula 6.1 and 6.2 of coefficients by their names in .tir files."""

    def wrench(self, slip: Slip) -> Wrench:
        x, y = self.longitudinal(slip), self.lateral(slip, self.inclination(slip))
        G_x, G_y = self.combined(slip, x, y)
        shift = self.combined_shift(slip, y.mu)
        F_x, F_y = G_x * x.force, G_y * y.force + shift  # 4.E50, 4.E58
        M_z = self.aligning_moment(slip, x, y, F_x, F_y, self.trailing_force(slip, G_y, F_y, shift), G_y)
        return Wrench(F_x, F_y, self.overturning_moment(slip, F_y), self.rolling_resistance(slip, F_x), M_z)

    def trailing_force(self, slip: Slip, G_y: Any, F_y: Any, shift: Any) -> Any:
        """The part of F_y that acts at the pneumatic trail, that of an upright wheel [N]. [P12 4.E72]"""
        return G_y * self.lateral(slip._replace(turn=0, roll=0), 0).force

    def aligning_moment(
        self, slip: Slip, x: Pure, y: Pure, F_x: Any, F_y: Any, trailing: Any, G_y: Any
    ) -> Any:
        """M_z = -t F'_y + M_zr + s F_x [N m]. [P12 4.E71 to 4.E78]"""
        ratio, alpha = over(x.K, y.K) * slip.kappa, self.alpha(slip)
        alpha_t, alpha_r = alpha + self.trail_shift(slip), alpha + y.S_H + over(y.S_V, y.K)  # 4.E37
        t = self.trail(slip, alpha_t, _equivalent(alpha_t, ratio))  # 4.E77
        s = self.SSZ1 + self.SSZ2 * F_y / self.FNOMIN + (self.SSZ3 + self.SSZ4 * self.df(slip)) * slip.gamma
        s = self.UNLOADED_RADIUS * s * self.LS  # 4.E76
        return -t * trailing + self.residual_moment(slip, y, _equivalent(alpha_r, ratio), G_y) + s * F_x

    def trail_shift(self, slip: Slip) -> Any:
        """S_Ht [rad]. [P12 4.E35]"""
        df = self.df(slip)
        return self.QHZ1 + self.QHZ2 * df + (self.QHZ3 + self.QHZ4 * df) * self.inclination(slip)

    def trail(self, slip: Slip, alpha_t: Any, equivalent: Any) -> Any:
        """The pneumatic trail t [m]. [P12 4.E73, 4.E40 to 4.E44]"""
        df, gamma = self.df(slip), slip.gamma
        B = (self.QBZ1 + self.QBZ2 * df + self.QBZ3 * df * df) * self.LKY / self.LMUY
        B = B * (1 + self.QBZ4 * gamma + self.QBZ5 * rounded_absolute(gamma, EDGE))  # 4.E40
        D = slip.load * self.UNLOADED_RADIUS / self.nominal_load * (self.QDZ1 + self.QDZ2 * df)
        D = D * (1 - self.PPZ1 * self.dp) * self.LTR * self.factors(slip).trail
        D = D * (1 + self.QDZ3 * gamma + self.QDZ4 * gamma * gamma)  # 4.E43
        E = 1 + (self.QEZ4 + self.QEZ5 * self.inclination(slip)) * (2 / pi) * atan(B * self.QCZ1 * alpha_t)
        E = minimum((self.QEZ1 + self.QEZ2 * df + self.QEZ3 * df * df) * E, 1)  # 4.E44
        return D * MC(B, self.QCZ1, E, equivalent) * slip.direction * cos(slip.alpha) * self.LFZO

    def residual_moment(self, slip: Slip, y: Pure, equivalent: Any, G_y: Any) -> Any:
        """M_zr [N m]. [P12 4.E75, 4.E45 to 4.E47]"""
        df, gamma, zeta = self.df(slip), self.inclination(slip), self.factors(slip)
        B = (self.QBZ9 * self.LKY / self.LMUY + self.QBZ10 * y.B * y.C) * zeta.residual  # 4.E45
        D = (self.QDZ8 + self.QDZ9 * df) * (1 + self.PPZ2 * self.dp)
        D = (D + (self.QDZ10 + self.QDZ11 * df) * rounded_absolute(gamma, EDGE)) * gamma * self.LKZC
        D = (self.QDZ6 + self.QDZ7 * df) * self.LRES * zeta.F_y + D * zeta.camber
        D = slip.load * self.UNLOADED_RADIUS * D * self.LMUY * slip.direction * cos(self.alpha(slip))  # 4.E47
        shape, turning = self.turning(slip, y, G_y)  # 4.E46
        return (D + turning) * cos(shape * atan(B * equivalent))

    def turning(self, slip: Slip, y: Pure, G_y: Any) -> tuple[Any, Any]:
        """ζ_7 and ζ_8 - 1 = D_rφ [N m], of turn slip."""
        return 1, 0

    def overturning_moment(self, slip: Slip, F_y: Any) -> Any:
        """M_x [N m]. [P12 4.E69], with the terms of both published forms."""
        gamma, f, y = slip.gamma, slip.load / self.FNOMIN, F_y / self.FNOMIN
        lean = rounded_absolute(gamma, EDGE)
        M = self.QSX1 * self.LVMX - self.QSX2 * gamma * (1 + self.PPMX1 * self.dp) + self.QSX3 * y
        angle = self.QSX7 * gamma + self.QSX8 * atan(self.QSX9 * y)
        M = M + self.QSX4 * cos(self.QSX5 * atan(self.QSX6 * f * self.QSX6 * f)) * sin(angle)
        M = M + self.QSX10 * atan(self.QSX11 * f) * gamma - self.QSX12 * gamma * lean
        return self.UNLOADED_RADIUS * self.LMX * (slip.load * M + F_y * (self.QSX13 + self.QSX14 * lean))

    def rolling_resistance(self, slip: Slip, F_x: Any) -> Any:
        """M_y [N m]. [P12 4.E70]; f^QSY7 = f f^(QSY7 - 1), so that it vanishes with the load."""
        f, gamma = slip.load / self.FNOMIN, slip.gamma
        M = self.rolling_terms(slip, F_x) + (self.QSY5 + self.QSY6 * f) * gamma * gamma
        M = -self.UNLOADED_RADIUS * slip.load * self.LMY * M * slip.direction
        if "QSY7" in self.given:
            M = M * exp((self.QSY7 - 1) / 2 * log(f * f + SMALLEST * SMALLEST))
        if "QSY8" in self.given and "NOMPRES" in self.given:
            M = M * exp(self.QSY8 * log(1 + self.dp))
        return M

    def rolling_terms(self, slip: Slip, F_x: Any) -> Any:
        """QSY1 + QSY2 F_x/F_z0 + QSY3 |V_x/V_0| + QSY4 (V_x/V_0)⁴."""
        v = slip.speed / self.LONGVL
        M = self.QSY1 + self.QSY2 * F_x / self.FNOMIN + self.QSY3 * rounded_absolute(v, 1e-3)
        return M + self.QSY4 * v * v * v * v


def _equivalent(alpha: Any, ratio: Any) -> Any:
    """√(tan² α + (K_x κ/K_y)²) as an angle [rad], of whose cosine version the sign has no effect. [P12 4.E74]"""
    return atan(sqrt(tan(alpha) * tan(alpha) + ratio * ratio + SMALLEST * SMALLEST))
