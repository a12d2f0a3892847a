"""The Magic Formula, versions 6.1 and 6.2: forces in pure and in combined slip.

Equation numbers [P12]: H. B. Pacejka and I. Besselink, Tire and Vehicle Dynamics, 3rd edition, 2012, section 4.3.2.
[B10]: I. Besselink, A. Schmeitz and H. Pacejka, Vehicle System Dynamics 48 (2010), sup1, with the inflation pressure.
Turn slip is in the file of its own, where the factors ζ are not 1. α* and γ* are the slip angle and the inclination,
or with large angles tan α and sin γ. [P12 4.E3, 4.E4]

    MG(B, C, D, E, x) = D sin[C atan(B x - E (B x - atan B x))]
    MC(B, C, E, x) = cos[C atan(B x - E (B x - atan B x))]

The curvature factors E are at most 1, as the book requires. The sign of a slip in E is rounded, tanh(x/1e-4): E is
multiplied by x³.

Coefficients without RCX1 and RCY1 have no forces in combined slip. These are on an ellipse then, as in Adams: with the
slips x = κ + S_Hx and y = sin(α* + S_Hy), and the pure forces F_x0 and F_y0 without their vertical shifts,

    G_x = 1/√(1 + (F_x0 y/(x μ_y F_z))²),   G_y = 1/√(1 + (F_y0 x/(y μ_x F_z))²)

so that (F_x/(μ_x F_z))² + (F_y/(μ_y F_z))² = 1 where both pure forces are those of full friction.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...._jit.formulas.functions import atan, cos, exp, minimum, sin, sqrt, tan, tanh
from .law import Slip
from .magic_formula_wheel import MagicFormulaWheel
from .rounding import EDGE, SMALLEST, limited, rounded_absolute


class TurnFactors(NamedTuple):
    """ζ_0 to ζ_3 and ζ_5, ζ_6 of turn slip; without it, all are 1."""

    camber: Any = 1  # ζ_0
    F_x: Any = 1  # ζ_1
    F_y: Any = 1  # ζ_2
    K_y: Any = 1  # ζ_3
    trail: Any = 1  # ζ_5
    residual: Any = 1  # ζ_6


class Pure(NamedTuple):
    """A force in pure slip, and what further formulas need."""

    force: Any  # [N]
    mu: Any  # [-] friction
    K: Any  # [N] or [N/rad] slip stiffness
    B: Any  # stiffness factor
    C: Any  # shape factor
    S_H: Any  # horizontal shift
    S_V: Any  # [N] vertical shift


def over(a: Any, b: Any) -> Any:
    """a/b, and zero at b = 0."""
    return a * b / (b * b + SMALLEST * SMALLEST)


def bent(B: Any, E: Any, x: Any) -> Any:
    """B x - E (B x - atan B x)."""
    return B * x - E * (B * x - atan(B * x))


def MG(B: Any, C: Any, D: Any, E: Any, x: Any) -> Any:
    """The sine version of the formula."""
    return D * sin(C * atan(bent(B, E, x)))


def MC(B: Any, C: Any, E: Any, x: Any) -> Any:
    """The cosine version of the formula."""
    return cos(C * atan(bent(B, E, x)))


def _secant(force: Pure, slip: Any) -> Any:
    """A pure force over its slip, and the slope without slip [N]."""
    tiny = SMALLEST * SMALLEST
    return ((force.force - force.S_V) * slip + force.K * tiny) / (slip * slip + tiny)


class MagicFormulaForces(MagicFormulaWheel):
    """Forces of the Magic Formula 6.1 and 6.2; coefficients by their names in .tir files."""

    def alpha(self, slip: Slip) -> Any:
        """α* [rad]."""
        return slip.alpha

    def inclination(self, slip: Slip) -> Any:
        """γ* [rad]."""
        return slip.gamma

    def factors(self, slip: Slip) -> TurnFactors:
        """ζ_i of turn slip."""
        return TurnFactors()

    def in_range(self, slip: Slip) -> Slip:
        inside = {
            name: limited(getattr(slip, name), one.low, one.high) for name, one in self.ranges().items()
        }
        return slip._replace(tan_alpha=tan(inside.pop("alpha")), **inside)

    def longitudinal(self, slip: Slip) -> Pure:
        """F_x in pure longitudinal slip. [P12 4.E9 to 4.E18]"""
        F_z, df, dp, gamma, zeta = slip.load, self.df(slip), self.dp, slip.gamma, self.factors(slip).F_x
        C = self.PCX1 * self.LCX  # 4.E11
        mu = (self.PDX1 + self.PDX2 * df) * (1 + self.PPX3 * dp + self.PPX4 * dp * dp)
        mu = mu * (1 - self.PDX3 * gamma * gamma) * self.LMUX  # 4.E13
        D = mu * F_z * zeta  # 4.E12
        K = self.longitudinal_stiffness(slip)
        B = K / (C * D + SMALLEST)  # 4.E16
        S_H = (self.PHX1 + self.PHX2 * df) * self.LHX  # 4.E17
        S_V = F_z * (self.PVX1 + self.PVX2 * df) * self.LVX * self.LMUX * zeta  # 4.E18
        x = slip.kappa + S_H  # 4.E10
        E = (self.PEX1 + self.PEX2 * df + self.PEX3 * df * df) * (1 - self.PEX4 * tanh(x / EDGE)) * self.LEX
        return Pure(MG(B, C, D, minimum(E, 1), x) + S_V, mu, K, B, C, S_H, S_V)  # 4.E9, 4.E14

    def longitudinal_stiffness(self, slip: Slip) -> Any:
        """K_xκ [N]. [P12 4.E15]"""
        df, dp = self.df(slip), self.dp
        K = slip.load * (self.PKX1 + self.PKX2 * df) * exp(self.PKX3 * df)
        return K * (1 + self.PPX1 * dp + self.PPX2 * dp * dp) * self.LKX

    def lateral(self, slip: Slip, gamma: Any) -> Pure:
        """F_y in pure lateral slip at an inclination. [P12 4.E19 to 4.E30]"""
        F_z, df, dp, zeta = slip.load, self.df(slip), self.dp, self.factors(slip)
        K = self.cornering_stiffness(F_z, gamma) * zeta.K_y
        S_Vg = F_z * (self.PVY3 + self.PVY4 * df) * gamma * self.LKYC * self.LMUY * zeta.F_y  # 4.E28
        S_H = (self.PHY1 + self.PHY2 * df) * self.LHY + self.camber_shift(slip, gamma, K, S_Vg)  # 4.E27
        S_V = F_z * (self.PVY1 + self.PVY2 * df) * self.LVY * self.LMUY * zeta.F_y + S_Vg  # 4.E29
        C = self.PCY1 * self.LCY  # 4.E21
        mu = (self.PDY1 + self.PDY2 * df) * (1 + self.PPY3 * dp + self.PPY4 * dp * dp)
        mu = mu * (1 - self.PDY3 * gamma * gamma) * self.LMUY  # 4.E23
        D, x = mu * F_z * zeta.F_y, self.alpha(slip) + S_H  # 4.E22, 4.E20
        E = (1 + self.PEY5 * gamma * gamma) - (self.PEY3 + self.PEY4 * gamma) * tanh(x / EDGE)
        E = (self.PEY1 + self.PEY2 * df) * E * self.LEY  # 4.E24
        B = K / (C * D + SMALLEST)  # 4.E26
        return Pure(MG(B, C, D, minimum(E, 1), x) + S_V, mu, K, B, C, S_H, S_V)  # 4.E19

    def cornering_stiffness(self, F_z: Any, gamma: Any) -> Any:
        """K_yα [N/rad], negative in the axes of the contact. [P12 4.E25]"""
        steep = (self.PKY2 + self.PKY5 * gamma * gamma) * (1 + self.PPY2 * self.dp)
        K = self.PKY1 * self.nominal_load * (1 + self.PPY1 * self.dp) * self.LKY
        K = K * (1 - self.PKY3 * rounded_absolute(gamma, EDGE))
        return K * sin(self.PKY4 * atan(F_z / self.nominal_load / steep))

    def camber_shift(self, slip: Slip, gamma: Any, K: Any, S_Vg: Any) -> Any:
        """The part of S_Hy by the inclination. [P12 4.E27, 4.E30]"""
        return over(self.camber_stiffness(slip) * gamma - S_Vg, K)

    def camber_stiffness(self, slip: Slip) -> Any:
        """K_yγ0 [N/rad]. [P12 4.E30]"""
        return slip.load * (self.PKY6 + self.PKY7 * self.df(slip)) * (1 + self.PPY5 * self.dp) * self.LKYC

    def combined(self, slip: Slip, x: Pure, y: Pure) -> tuple[Any, Any]:
        """G_xα and G_yκ, or those of the ellipse."""
        if "RCX1" in self.given:
            return self.combined_x(slip), self.combined_y(slip)
        along, across = slip.kappa + x.S_H, sin(self.alpha(slip) + y.S_H)
        first = over(_secant(x, along) * across, y.mu * slip.load)
        second = over(_secant(y, across) * along, x.mu * slip.load)
        return 1 / sqrt(1 + first * first), 1 / sqrt(1 + second * second)

    def combined_x(self, slip: Slip) -> Any:
        """G_xα, by which the slip angle reduces F_x. [P12 4.E51 to 4.E57]"""
        gamma, df, alpha = self.inclination(slip), self.df(slip), self.alpha(slip)
        B = (self.RBX1 + self.RBX3 * gamma * gamma) * cos(atan(self.RBX2 * slip.kappa)) * self.LXAL  # 4.E54
        E = minimum(self.REX1 + self.REX2 * df, 1)  # 4.E56
        return MC(B, self.RCX1, E, alpha + self.RHX1) / MC(B, self.RCX1, E, self.RHX1)  # 4.E51

    def combined_y(self, slip: Slip) -> Any:
        """G_yκ, by which the longitudinal slip reduces F_y. [P12 4.E59 to 4.E65]"""
        gamma, df = self.inclination(slip), self.df(slip)
        B = (self.RBY1 + self.RBY4 * gamma * gamma) * cos(atan(self.RBY2 * (self.alpha(slip) - self.RBY3)))
        B, E = B * self.LYKA, minimum(self.REY1 + self.REY2 * df, 1)  # 4.E62, 4.E64
        S_H = self.RHY1 + self.RHY2 * df  # 4.E65
        return MC(B, self.RCY1, E, slip.kappa + S_H) / MC(B, self.RCY1, E, S_H)  # 4.E59

    def combined_shift(self, slip: Slip, mu: Any) -> Any:
        """S_Vyκ, the lateral force by the longitudinal slip [N]. [P12 4.E66, 4.E67]"""
        D = self.RVY1 + self.RVY2 * self.df(slip) + self.RVY3 * self.inclination(slip)
        D = mu * slip.load * D * cos(atan(self.RVY4 * self.alpha(slip))) * self.factors(slip).F_y
        return D * sin(self.RVY5 * atan(self.RVY6 * slip.kappa)) * self.LVYKA
