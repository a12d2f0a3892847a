"""Turn slip of the Magic Formula 6.1 and 6.2: the moment of a wheel that is steered as it stands or rolls slowly.

[P12]: H. B. Pacejka and I. Besselink, Tire and Vehicle Dynamics, 3rd edition, 2012, section 4.3.3. With the yaw rate
ψ̇ of the wheel and the velocity V of its contact, at least `creep`, the turn slip and the spin slip [1/m] are

    φ_t = ψ̇/|V|,   φ = φ_t + (1 - ε_γ) Ω sin γ/|V|,   ε_γ = PECP1 (1 + PECP2 df)

[P12 4.75, 4.76, 4.90], positive to the left, as z is upwards: the book, whose z is downwards, has the opposite sign in
both. Forces by the inclination are those of φ, so ζ_0 = 0. |φ| is rounded below R_0 φ = `EDGE`, where ζ_7 is 1.

    ζ_4 - 1 = S_Hyφ - S_Vyγ/K_yα,  S_Hyφ = D_Hyφ sin[C_Hyφ atan(B R_0 φ - E_Hyφ (B R_0 φ - atan B R_0 φ))] sgn V_x
    D_rφ = M_z∞/sin(π/2 QDRP1) sin[QDRP1 atan(B_Drφ R_0 φ - ...)],   M_z∞ = QCRP1 μ_y R_0 F_z √(F_z/F'_z0) LMP
"""

from __future__ import annotations

from math import pi
from typing import Any

from ...._jit.formulas.functions import acos, atan, cos, sin, sqrt
from ..laws import soft_ramp
from .law import Slip
from .magic_formula import MG, Pure, TurnFactors, over
from .magic_formula_61 import MagicFormula61
from .rounding import EDGE, SMALLEST, rounded_absolute


class TurnSlip(MagicFormula61):
    """The Magic Formula 6.1 and 6.2 with turn slip."""

    turns = True

    def free_spin(self, slip: Slip) -> Any:
        """1 - ε_γ. [P12 4.90]"""
        return 1 - self.PECP1 * (1 + self.PECP2 * self.df(slip))

    def spin_slip(self, slip: Slip) -> Any:
        """R_0 φ. [P12 4.76]"""
        return self.UNLOADED_RADIUS * (slip.turn + self.free_spin(slip) * slip.roll * sin(slip.gamma))

    def factors(self, slip: Slip) -> TurnFactors:
        phi, df = self.spin_slip(slip), self.df(slip)
        x = self.PDXP1 * (1 + self.PDXP2 * df) * cos(atan(self.PDXP3 * slip.kappa)) * phi  # 4.105, 4.106
        B, size = self.PDYP1 * (1 + self.PDYP2 * df), rounded_absolute(phi, EDGE)
        B = B * cos(atan(self.PDYP3 * slip.tan_alpha))  # 4.78
        root = sqrt(size + SMALLEST * SMALLEST)
        y = size * (size + self.PDYP4 * (2 * root + self.PDYP4))  # (R_0 |φ| + PDYP4 √(R_0 |φ|))², 4.77
        K = self.PKYP1 * phi * phi  # 4.79
        return TurnFactors(
            camber=0,
            F_x=_cos_atan(x * x),
            F_y=_cos_atan(B * B * y),
            K_y=_cos_atan(K * K),
            trail=_cos_atan(self.QDTP1 * phi * (self.QDTP1 * phi)),  # 4.91
            residual=_cos_atan(self.QBRP1 * phi * (self.QBRP1 * phi)),  # 4.102
        )

    def camber_shift(self, slip: Slip, gamma: Any, K: Any, S_Vg: Any) -> Any:
        """ζ_4 - 1. [P12 4.80 to 4.89]"""
        D = self.PHYP2 + self.PHYP3 * self.df(slip)
        K_R = self.camber_stiffness(slip) / self.free_spin(slip)
        B = over(K_R, self.PHYP1 * D * self.cornering_stiffness(slip.load, 0))
        return MG(B, self.PHYP1, D, self.PHYP4, self.spin_slip(slip)) * slip.direction - over(S_Vg, K)

    def turning(self, slip: Slip, y: Pure, G_y: Any) -> tuple[Any, Any]:
        """ζ_7 and D_rφ [N m]. [P12 4.92 to 4.104]"""
        F_z, df, R, C = slip.load, self.df(slip), self.UNLOADED_RADIUS, self.QDRP1
        most = self.QCRP1 * y.mu * R * F_z * self.LMP  # M_z∞, 4.95
        most = most * sqrt(sqrt(F_z * F_z + SMALLEST) / self.nominal_load)
        K = self.QDZ10 + self.QDZ11 * df
        K = self.QDZ8 + self.QDZ9 * df + K * rounded_absolute(slip.gamma, EDGE)
        K = F_z * R * K * self.LKZC / self.free_spin(slip)  # 4.99
        D = most / sin(pi / 2 * C)  # 4.94
        moment = MG(over(K, C * D), C, D, self.QDRP2, self.spin_slip(slip))
        quarter = most * (2 / pi) * atan(self.QCRP2 * rounded_absolute(R * slip.turn, EDGE)) * G_y  # 4.103
        ratio = quarter / sqrt(moment * moment + K * EDGE * (K * EDGE) + SMALLEST)
        ratio = ratio - soft_ramp(ratio - (1 - SMALLEST), EDGE)  # at most 1
        return 2 / pi * acos(ratio), moment


def _cos_atan(squared: Any) -> Any:
    """cos(atan x) of x²."""
    return 1 / sqrt(1 + squared)
