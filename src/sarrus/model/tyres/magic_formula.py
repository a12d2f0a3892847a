"""Tyre with the Magic Formula."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite
from typing import Annotated, Any

from ...elements.forces.tyres import (
    LargeAngles52,
    LargeAngles61,
    LargeAnglesTurnSlip,
    MagicFormula52,
    MagicFormula61,
    Slip,
    TurnSlip,
    TyreLaw,
)
from ...elements.forces.tyres.magic_formula_wheel import CAMBER, SCALES, TERMS, TURN, WHEEL
from ..errors import ModelError
from ..forces.force import Force
from ..measure import In
from ..parity import declared
from ..quantity import number
from ..show import quote, show, suggest
from ..tape import value_of
from .rolling_tyre import RollingTyre

LAWS: dict[int, type[TyreLaw]] = {
    **dict.fromkeys((5, 6, 21, 52), MagicFormula52),
    **dict.fromkeys((60, 61, 62), MagicFormula61),
}
LARGE: dict[type[TyreLaw], type[TyreLaw]] = {
    MagicFormula52: LargeAngles52,
    MagicFormula61: LargeAngles61,
    TurnSlip: LargeAnglesTurnSlip,
}
POSITIVE = (
    "UNLOADED_RADIUS",
    "FNOMIN",
    "VERTICAL_STIFFNESS",
    "LONGVL",
    "LFZO",
    "LMUX",
    "LMUY",
    "PCX1",
    "PDX1",
    "PKX1",
    "PCY1",
)
OPTIONAL = ("LFZO", "LMUX", "LMUY")
NOT_ZERO = ("PDY1", "PKY1", "PKY2")
KNOWN = frozenset(("FITTYP", *SCALES, *TERMS, *TURN, *CAMBER, *WHEEL))
# Terms that break the symmetry of left and right
MIRRORED_TEXT = """
RHX1 PEY3 PHY1 PHY2 PVY1 PVY2 RBY3 RVY1 RVY2 QSX1 QHZ1 QHZ2 QBZ4 QDZ3 QEZ4 QDZ6 QDZ7 SSZ1
"""
MIRRORED = tuple(MIRRORED_TEXT.split())
RANGES = {
    "ALPMIN": "ALPMAX",
    "ALPMAX": "ALPMIN",
    "CAMMIN": "CAMMAX",
    "CAMMAX": "CAMMIN",
}  # exchanged, and negative


@dataclass(frozen=True, eq=False, kw_only=True)
class MagicFormulaTyre(RollingTyre, Force):
    """A rolling tyre with the Magic Formula 5.2, PAC2002, 6.1 or 6.2, by FITTYP.

    The belt's dynamics and the reduction of the load by F_x and F_y are left out. Slips, inclination and load are
    limited to the ranges of the file: KPUMIN to KPUMAX, ALPMIN to ALPMAX, CAMMIN to CAMMAX, and up to FZMAX. Without
    them, these are ±1.5, ±1.5 rad, ±0.26 rad and three times FNOMIN. Without the coefficients of combined slip, RCX1
    and RCY1, combined forces are on an ellipse, as in Adams.

    Parameters
    ----------
    coefficients
        Numbers in SI units by their names in .tir files, such as ``sr.load_tyre("car.tir").coefficients``. Derivatives
        can be taken with respect to all that the law uses, zero ones among them.
    turn_slip
        Whether the yaw rate of the wheel changes forces, and gives the moment of parking: for FITTYP 60 to 62, by the
        coefficients PDXP1 to QDRP2. A wheel that is turned at standstill creeps: its moment needs a yaw rate.
    large_angles
        Whether the formulas have tan α and sin γ in place of α and γ, as some programs that fit coefficients do.
    """

    parity = declared(RollingTyre.parity, coefficients="terms")
    odd_terms = frozenset((*MIRRORED, *RANGES))
    exchanged_terms = RANGES

    coefficients: Annotated[Mapping[str, float], In("")]
    turn_slip: bool = False
    large_angles: bool = False

    @property
    def radius(self) -> float:
        """The unloaded radius [m]."""
        return self.coefficients["UNLOADED_RADIUS"]

    @property
    def absent_numbers(self) -> Collection[tuple[str, ...]]:
        """The version of the law, which is no parameter, and coefficients that the law does not use, too."""
        unused = _unused(self.coefficients, self.turn_slip)
        return [*super().absent_numbers, *(("coefficients", name) for name in unused)]

    def tyre_law(self) -> tuple[type[TyreLaw], Mapping[str, Any]]:
        given: Any = self.coefficients
        if not isinstance(given, Mapping):
            message = (
                f"coefficients must be a mapping, but is {show(given)}. Give those of sr.load_tyre(...)."
            )
            raise ModelError(message, field="coefficients")
        for option in ("turn_slip", "large_angles"):
            if not isinstance(getattr(self, option), bool):
                message = f"{option} must be True or False, but is {show(getattr(self, option))}."
                raise ModelError(message, field=option)
        return checked(given, "coefficients", self.turn_slip, self.large_angles)


def checked(
    given: Mapping[str, Any], field: str, turn_slip: bool = False, large_angles: bool = False
) -> tuple[type[TyreLaw], dict[str, Any]]:
    """Return the law of coefficients, and those that it uses.

    Raises
    ------
    ModelError
        If one is unknown, missing or out of range.
    """
    for name, value in given.items():
        if name not in KNOWN:
            raise ModelError(
                f"{field} has the unknown name {quote(name)}. {suggest(name, KNOWN)}", field=field
            )
        number(value, f"{field}.{name}")
    plain = {name: float(value_of(value)) for name, value in given.items()}
    kinds = ", ".join(map(str, LAWS))
    if "FITTYP" not in plain:
        raise ModelError(
            f"{field} has no FITTYP, the version of the formulas. Give one of {kinds}.", field=field
        )
    kind = plain["FITTYP"]
    if kind not in LAWS:
        raise ModelError(
            f"{field}.FITTYP is {kind:g}, which is not supported. Choose from {kinds}.", field=field
        )
    _check_values(plain, field)
    law, unused = LAWS[int(kind)], _unused(given, turn_slip)
    if turn_slip:
        law = _turning(plain, field)
    used = {name: value for name, value in given.items() if name not in unused}
    _check_forces(law, tuple((name, plain[name]) for name in used), field)
    return LARGE[law] if large_angles else law, used


@lru_cache(100)
def _check_forces(kind: type[TyreLaw], numbers: tuple[tuple[str, float], ...], field: str) -> None:
    """Refuse coefficients with the wrong sign of the cornering stiffness, or with forces that are not finite.

    Raises
    ------
    ModelError
    """
    plain = dict(numbers)
    law: Any = kind(plain)
    try:
        nominal = law.nominal_load
        K = law.cornering_stiffness(nominal, 0.0)
        if K >= 0.0:
            message = f"{field} has the cornering stiffness {K:.4g} N/rad at FNOMIN, which must be negative"
            raise ModelError(
                f"{message}: F_y < 0 for α > 0. Correct the signs of PKY1, PKY2 and LKY.", field=field
            )
        for load in (0.0, nominal, plain.get("FZMAX", 3.0 * nominal)):
            forces = law.wrench(law.in_range(Slip(0.05, 0.1, 0.02, load)))
            if not all(map(isfinite, (*forces, law.vertical_force(0.01, 0.0, 0.0, 1e-3)))):
                raise OverflowError
    except ArithmeticError:
        message = f"{field} leads to forces that are not finite. Look for a coefficient of the wrong size"
        raise ModelError(f"{message}.", field=field) from None


def _unused(given: Any, turn_slip: bool) -> set[str]:
    """Names of the coefficients that the law does not use; files give 0 for none."""
    named = given if isinstance(given, Mapping) else {}
    plain = {name: value_of(value) for name, value in named.items()}
    unused = {"FITTYP"}
    if not turn_slip:
        unused |= {*TURN, "LMP"}
    if plain.get("FITTYP") != 62 or not (plain.get("Q_CAM1") or plain.get("Q_CAM2")):
        unused |= {*CAMBER, "WIDTH", "ASPECT_RATIO"}
    if not (plain.get("RCX1") or plain.get("RCY1")):
        unused |= {"RCX1", "RCY1"}
    if not plain.get("Q_FZ1"):
        unused.add("Q_FZ1")
    return unused.intersection(plain)


def _turning(plain: Mapping[str, float], field: str) -> type[TyreLaw]:
    """The law with turn slip.

    Raises
    ------
    ModelError
        If a coefficient that it needs is missing or has no sense.
    """
    if LAWS[int(plain["FITTYP"])] is not MagicFormula61:
        message = f"turn_slip needs a FITTYP from 60 to 62, but it is {plain['FITTYP']:g}"
        raise ModelError(f"{message}. Leave turn_slip out.", field="turn_slip")
    rules = {
        "PHYP1": ("not be 0", plain.get("PHYP1") != 0.0),
        "PHYP2": ("not be 0", plain.get("PHYP2") != 0.0),
        "QCRP1": ("be greater than 0", plain.get("QCRP1", 0.0) > 0.0),
        "QDRP1": ("be between 0 and 2", 0.0 < plain.get("QDRP1", 0.0) < 2.0),
        "PECP1": ("be less than 1", plain.get("PECP1", 0.0) < 1.0),
    }
    for name, (rule, right) in rules.items():
        if name not in plain and name != "PECP1":
            raise ModelError(f"{field} has no {name}, which turn_slip needs. Add it.", field=field)
        if not right:
            message = f"{field}.{name} must {rule} for turn_slip, but is {plain[name]:g}"
            raise ModelError(f"{message}. Correct it.", field=field)
    return TurnSlip


def _check_values(plain: Mapping[str, float], field: str) -> None:
    later = ("PKY4",) if LAWS[int(plain["FITTYP"])] is MagicFormula61 else ()
    for name in (*POSITIVE, *NOT_ZERO, *later):
        if name not in plain and name not in OPTIONAL:
            raise ModelError(f"{field} has no {name}. Add it.", field=field)
        value = plain.get(name, 1.0)
        if value == 0.0 or (value < 0.0 and name in POSITIVE):
            rule = "must not be 0" if name not in POSITIVE else f"must be greater than 0, but is {value:g}"
            raise ModelError(f"{field}.{name} {rule}. Correct it.", field=field)
    for name in ("NOMPRES", "INFLPRES", "LONGITUDINAL_STIFFNESS", "LATERAL_STIFFNESS", "FZMAX"):
        if plain.get(name, 1.0) <= 0.0:
            message = f"{field}.{name} must be greater than 0, but is {plain[name]:g}"
            raise ModelError(f"{message}. Correct it, or leave it out.", field=field)
    for name, other in (("RCX1", "RCY1"), ("RCY1", "RCX1")):
        if plain.get(name) and not plain.get(other):
            message = f"{field} has {name}, but no {other}, for forces in combined slip"
            raise ModelError(f"{message}. Add it, or leave out both for an ellipse.", field=field)
    if plain["FITTYP"] == 62 and (plain.get("Q_CAM1") or plain.get("Q_CAM2")):
        for name, most in (("WIDTH", inf), ("ASPECT_RATIO", 2.0)):
            if not 0.0 < plain.get(name, 0.0) < most:
                rule = f"must be greater than 0 and less than {most:g}" if name in plain else "is missing"
                raise ModelError(f"{field}.{name} {rule}, with Q_CAM1 and Q_CAM2. Correct it.", field=field)
        if plain.get("Q_CAM1", 0.0) + plain.get("Q_CAM2", 0.0) * plain["UNLOADED_RADIUS"] == 0.0:
            raise ModelError(f"{field}.Q_CAM1 + Q_CAM2 R must not be 0. Correct them.", field=field)
    if "PTY2" in plain and plain["PTY2"] == 0.0:
        raise ModelError(f"{field}.PTY2 must not be 0. Correct it, or leave out PTY1 and PTY2.", field=field)
    for name in ("KPU", "ALP", "CAM"):
        low, high = plain.get(f"{name}MIN", -0.1), plain.get(f"{name}MAX", 0.1)
        if low >= 0.0 or high <= 0.0:
            message = (
                f"{field} has the range {low:g} to {high:g} of {name}MIN and {name}MAX, without zero in it"
            )
            raise ModelError(f"{message}. Correct it.", field=field)
    steep = plain["VERTICAL_STIFFNESS"] * plain["UNLOADED_RADIUS"] / plain["FNOMIN"]
    if plain.get("Q_FZ1", 0.0) < 0.0:
        message = f"{field}.Q_FZ1 must not be negative, but is {plain['Q_FZ1']:g}"
        raise ModelError(f"{message}. Correct it, or leave it out.", field=field)
    if not plain.get("Q_FZ1") and 4 * plain.get("Q_FZ2", 0.0) >= steep * steep:
        limit = f"{field}.Q_FZ2 must be less than {steep * steep / 4:.6g}, that VERTICAL_STIFFNESS is reached at FNOMIN"
        raise ModelError(f"{limit}, but is {plain['Q_FZ2']:g}. Correct it, or give Q_FZ1.", field=field)
    for name in ("VERTICAL_DAMPING", "QSY7"):
        if plain.get(name, 0.0) < 0.0:
            raise ModelError(f"{field}.{name} must not be negative. Correct it.", field=field)


def mirrored(coefficients: Mapping[str, float]) -> dict[str, float]:
    """Return the coefficients of the mirrored tyre: F_y, M_x and M_z at -α and -γ with the opposite sign."""
    return {
        RANGES.get(name, name): -value if name in MIRRORED or name in RANGES else value
        for name, value in coefficients.items()
    }
