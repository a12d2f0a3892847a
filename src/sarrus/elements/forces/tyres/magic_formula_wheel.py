"""The wheel of the Magic Formula: load over the compression, rolling radius, relaxation lengths, and neutral values.

[B10]: I. Besselink, A. Schmeitz and H. Pacejka, Vehicle System Dynamics 48 (2010), sup1; names as in .tir files.
"""

from __future__ import annotations

from collections.abc import Container
from functools import cached_property
from typing import Any, NamedTuple

from ...._jit.formulas.functions import atan, exp, sin, sqrt, tan
from ..laws import along, soft_ramp, soft_step
from .law import Slip, TyreLaw
from .rounding import EDGE, SMALLEST, limited, rounded_absolute

# Factors, which are 1 if a file does not have them
SCALES_TEXT = """
LFZO LCX LMUX LEX LKX LHX LVX LCY LMUY LEY LKY LKYC LKZC LHY LVY LTR LRES LXAL LYKA LVYKA LS LMX LVMX LMY LMP
LSGKP LSGAL LGAX LGAY LGAZ Q_RE0
"""
# Coefficients, which are 0 if a file does not have them
TERMS_TEXT = """
VERTICAL_DAMPING Q_V1 Q_V2 Q_FZ2 PFZ1 BREFF DREFF FREFF PCFX1 PCFX2 PCFX3 PCFY1 PCFY2 PCFY3 PCX1 PDX1 PDX2
PDX3 PEX1 PEX2 PEX3 PEX4 PKX1 PKX2 PKX3 PHX1 PHX2 PVX1 PVX2 PPX1 PPX2 PPX3 PPX4 RBX1 RBX2 RBX3 RCX1 REX1 REX2
RHX1 PTX1 PTX2 PTX3 PCY1 PDY1 PDY2 PDY3 PEY1 PEY2 PEY3 PEY4 PEY5 PKY1 PKY2 PKY3 PKY4 PKY5 PKY6 PKY7 PHY1 PHY2
PHY3 PVY1 PVY2 PVY3 PVY4 PPY1 PPY2 PPY3 PPY4 PPY5 RBY1 RBY2 RBY3 RBY4 RCY1 REY1 REY2 RHY1 RHY2 RVY1 RVY2 RVY3
RVY4 RVY5 RVY6 PTY1 PTY2 QSX1 QSX2 QSX3 QSX4 QSX5 QSX6 QSX7 QSX8 QSX9 QSX10 QSX11 QSX12 QSX13 QSX14 PPMX1 QSY1
QSY2 QSY3 QSY4 QSY5 QSY6 QSY7 QSY8 QBZ1 QBZ2 QBZ3 QBZ4 QBZ5 QBZ9 QBZ10 QCZ1 QDZ1 QDZ2 QDZ3 QDZ4 QDZ6 QDZ7 QDZ8
QDZ9 QDZ10 QDZ11 QEZ1 QEZ2 QEZ3 QEZ4 QEZ5 QHZ1 QHZ2 QHZ3 QHZ4 PPZ1 PPZ2 SSZ1 SSZ2 SSZ3 SSZ4
"""
# Coefficients of turn slip, with LMP
TURN_TEXT = """
PDXP1 PDXP2 PDXP3 PKYP1 PDYP1 PDYP2 PDYP3 PDYP4 PHYP1 PHYP2 PHYP3 PHYP4 PECP1 PECP2 QDTP1 QCRP1 QCRP2 QBRP1 QDRP1
QDRP2
"""
# Coefficients of the compression by the inclination of 6.2, with WIDTH and ASPECT_RATIO
CAMBER_TEXT = "Q_CAM1 Q_CAM2 Q_CAM3"
# Numbers without a neutral value
WHEEL_TEXT = """
UNLOADED_RADIUS FNOMIN LONGVL VERTICAL_STIFFNESS NOMPRES INFLPRES Q_FZ1 LONGITUDINAL_STIFFNESS
LATERAL_STIFFNESS FZMIN FZMAX KPUMIN KPUMAX ALPMIN ALPMAX CAMMIN CAMMAX WIDTH ASPECT_RATIO
"""
SCALES, TERMS, WHEEL = (tuple(text.split()) for text in (SCALES_TEXT, TERMS_TEXT, WHEEL_TEXT))
TURN, CAMBER = (tuple(text.split()) for text in (TURN_TEXT, CAMBER_TEXT))
RANGES = {"KPU": 1.5, "ALP": 1.5, "CAM": 0.2618}  # of slips [-] and angles [rad] if a file has none
HIGHEST = 3.0  # [-] load over the nominal one, likewise
STANDING = 1.0  # [rad/s] spin below which its size is rounded


def without_relaxation(given: Container[str]) -> tuple[str, ...]:
    """The directions of which coefficients have neither a stiffness of the carcass nor an empirical length."""
    x = "LONGITUDINAL_STIFFNESS" in given or "PTX1" in given or "PTX2" in given
    y = "LATERAL_STIFFNESS" in given or ("PTY1" in given and "PTY2" in given)
    return tuple(word for word, has in (("longitudinal", x), ("lateral", y)) if not has)


class Range(NamedTuple):
    """The limits of a slip, an angle or a load, and the names of the coefficients that set them."""

    low: Any
    high: Any
    coefficients: str


class MagicFormulaWheel(TyreLaw):
    """The wheel; `R_0` is the unloaded radius, `nominal_load` F'_z0, scaled by LFZO."""

    neutral = dict.fromkeys(SCALES, 1) | dict.fromkeys((*TERMS, *TURN, *CAMBER), 0)

    @property
    def unloaded_radius(self) -> Any:
        """R_0 [m]."""
        return self.UNLOADED_RADIUS

    def ranges(self) -> dict[str, Range]:
        """The limits of kappa, alpha, gamma and the load; beyond them the forces are constant."""
        limits = {}
        for name, key in (("kappa", "KPU"), ("alpha", "ALP"), ("gamma", "CAM")):
            low, high = f"{key}MIN", f"{key}MAX"
            ends = self.given.get(low, -RANGES[key]), self.given.get(high, RANGES[key])
            limits[name] = Range(*ends, f"{low} and {high}")
        limits["load"] = Range(-self.FNOMIN, self.given.get("FZMAX", HIGHEST * self.FNOMIN), "FZMAX")
        return limits

    @cached_property
    def nominal_load(self) -> Any:
        """F'_z0 = LFZO F_z0 [N]. [P12 4.E1]"""
        return self.LFZO * self.FNOMIN

    def df(self, slip: Slip) -> Any:
        """Change of the load over the nominal one. [P12 4.E2a]"""
        return slip.load / self.nominal_load - 1

    @cached_property
    def dp(self) -> Any:
        """Change of the pressure over the nominal one. [P12 4.E2b]"""
        if "NOMPRES" not in self.given or "INFLPRES" not in self.given:
            return 0
        return self.INFLPRES / self.NOMPRES - 1

    def free_radius(self, spin: Any) -> Any:
        """R_Ω, which grows with the spin [m]. [B10 1]"""
        ratio = self.UNLOADED_RADIUS * spin / self.LONGVL
        return self.UNLOADED_RADIUS * (self.Q_RE0 + self.Q_V1 * ratio * ratio)

    def depth(self, loaded: Any, spin: Any, gamma: Any) -> Any:
        """ρ = R_Ω - R_l, and with Q_CAM the compression ρ_γ of the edge of an inclined tread (6.2) [m].

        ρ_γ = [R_l (Q_CAM1 + Q_CAM2 R_l)/(R_Ω (Q_CAM1 + Q_CAM2 R_Ω))]² (w/8) |tan γ| - Q_CAM3 (R_Ω - R_l) |γ|, with the
        width w = (1.075 - 0.5 ASPECT_RATIO) WIDTH of the tread. Its rate is left out of the damping. Off the road, ρ_γ
        does not grow with R_l.
        """
        free = self.free_radius(spin)
        if "Q_CAM1" not in self.given and "Q_CAM2" not in self.given:
            return free - loaded
        within = self.ranges()["gamma"]
        l, gamma = free * limited(loaded / free, 0, 1), limited(gamma, within.low, within.high)
        ratio = l * (self.Q_CAM1 + self.Q_CAM2 * l) / (free * (self.Q_CAM1 + self.Q_CAM2 * free))
        tread = (1.075 - 0.5 * self.ASPECT_RATIO) * self.WIDTH
        edge = ratio * ratio * tread / 8 * rounded_absolute(tan(gamma), EDGE)
        return free - loaded + edge - self.Q_CAM3 * (free - l) * rounded_absolute(gamma, EDGE)

    def _stiffness(self) -> tuple[Any, Any]:
        """Linear [N/m] and quadratic [N/m²] vertical stiffness."""
        k, second = self.VERTICAL_STIFFNESS, self.Q_FZ2
        R, F = self.UNLOADED_RADIUS, self.FNOMIN
        if "Q_FZ1" in self.given:
            k = self.Q_FZ1 * F / R
        elif "Q_FZ2" in self.given:
            k = sqrt(k * R / F * (k * R / F) - 4 * second) * F / R
        harder = 1 + self.PFZ1 * self.dp
        return k * harder, second * F / (R * R) * harder

    def vertical_force(self, depth: Any, rate: Any, spin: Any, width: Any) -> Any:
        """F_z without the effects of F_x and F_y on it [N]. [B10 3]"""
        k, second = self._stiffness()
        faster = 1 + self.Q_V2 * self.UNLOADED_RADIUS * rounded_absolute(spin, STANDING) / self.LONGVL
        linear = soft_ramp(faster * k * depth + self.VERTICAL_DAMPING * rate, k * width)
        pressed = soft_ramp(depth, width)
        return soft_step(depth, width) * linear + faster * second * pressed * pressed

    def stored_energy(self, depth: Any, width: Any) -> Any:
        """The integral of F_z over ρ for ρ̇ = 0 at rest [J]."""
        k, second = self._stiffness()
        pressed, (u, b) = soft_ramp(depth, width), along(depth, width)
        cubic = width**3 * u**7 * (1 / 7 - u / 8 + u * u / 36)  # the integral of ρ₊²
        cubic = cubic + b * (b * b + 1.5 * b * width + 0.75 * width * width) / 3
        return k * pressed * pressed / 2 + second * cubic

    def rolling_radius(self, loaded: Any, load: Any, spin: Any) -> Any:
        """R_e [m]. [B10 2], [P12 4.E100]"""
        f, C = load / self.FNOMIN, self.VERTICAL_STIFFNESS * (1 + self.PFZ1 * self.dp)
        return self.free_radius(spin) - self.FNOMIN / C * (self.DREFF * atan(self.BREFF * f) + self.FREFF * f)

    def relaxation_lengths(self, slip: Slip) -> tuple[Any, Any]:
        """σ = K/C of the carcass (6.x), or the empirical length of 5.2 where a file has no such stiffness [m]."""
        return self._longitudinal_length(slip, self.df(slip)), self._lateral_length(slip, self.df(slip))

    def _longitudinal_length(self, slip: Slip, df: Any) -> Any:
        if "LONGITUDINAL_STIFFNESS" not in self.given:
            length = slip.load / self.nominal_load * self.UNLOADED_RADIUS * self.LSGKP
            return length * (self.PTX1 + self.PTX2 * df) * exp(-self.PTX3 * df)
        C = self.LONGITUDINAL_STIFFNESS * (1 + self.PCFX1 * df + self.PCFX2 * df * df)
        K = self.longitudinal_stiffness(slip)
        return sqrt(K * K + SMALLEST) / (C * (1 + self.PCFX3 * self.dp))

    def _lateral_length(self, slip: Slip, df: Any) -> Any:
        if "LATERAL_STIFFNESS" in self.given:
            C = self.LATERAL_STIFFNESS * (1 + self.PCFY1 * df + self.PCFY2 * df * df)
            K = self.cornering_stiffness(slip.load, slip.gamma)
            return sqrt(K * K + SMALLEST) / (C * (1 + self.PCFY3 * self.dp))
        if "lateral" in without_relaxation(self.given):
            return 0
        length = self.PTY1 * sin(2 * atan(slip.load / (self.PTY2 * self.nominal_load)))
        length = length * self.LFZO * self.LSGAL
        return length * self.UNLOADED_RADIUS * (1 - self.PKY3 * rounded_absolute(slip.gamma, EDGE))

    def sliding_slips(self, load: Any) -> tuple[Any, Any]:
        """Three times friction over slip stiffness."""
        x = self.PDX1 * self.LMUX * load / (self.longitudinal_stiffness(Slip(0, 0, 0, load)) + SMALLEST)
        y = self.PDY1 * self.LMUY * load / (self.cornering_stiffness(load, 0) - SMALLEST)
        return 3 * sqrt(x * x), 3 * sqrt(y * y)
