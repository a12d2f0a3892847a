"""Tyre with the Magic Formula."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite
from typing import Annotated, Any, NamedTuple

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
KNOWN = frozenset(("FITTYP", *SCALES, *TERMS, *TURN, *CAMBER, *WHEEL))
# Terms that break the symmetry of left and right
MIRRORED_TEXT = """
RHX1 PEY3 PHY1 PHY2 PVY1 PVY2 RBY3 RVY1 RVY2 QSX1 QHZ1 QHZ2 QBZ4 QDZ3 QEZ4 QDZ6 QDZ7 SSZ1
"""
MIRRORED = tuple(MIRRORED_TEXT.split())
# Ends of ranges, which are exchanged, and negative
RANGES = {"ALPMIN": "ALPMAX", "ALPMAX": "ALPMIN", "CAMMIN": "CAMMAX", "CAMMAX": "CAMMIN"}


class Rule(NamedTuple):
    """What values of coefficients must be, and the message behind the name of one that is not."""

    coefficients: str
    holds: Callable[[float], bool]
    message: str
    needed: str | None = None  # for what, if they must not be left out


POSITIVE = "must be greater than 0, but is {:g}. Correct it"
RULES = (
    Rule("UNLOADED_RADIUS FNOMIN VERTICAL_STIFFNESS LONGVL", lambda x: x > 0, f"{POSITIVE}.", ""),
    Rule("UNLOADED_RADIUS", lambda x: x <= 5, "is {:g} m. Is the unit of the file mm? Give [UNITS] LENGTH."),
    Rule("PCX1 PDX1 PKX1 PCY1", lambda x: x > 0, f"{POSITIVE}.", ""),
    Rule("PDY1 PKY1 PKY2", bool, "must not be 0. Correct it.", ""),
    Rule("LFZO LMUX LMUY NOMPRES INFLPRES FZMAX", lambda x: x > 0, f"{POSITIVE}, or leave it out."),
    Rule("LONGITUDINAL_STIFFNESS LATERAL_STIFFNESS", lambda x: x > 0, f"{POSITIVE}, or leave it out."),
    Rule("Q_FZ1", lambda x: x >= 0, "must not be negative, but is {:g}. Correct it, or leave it out."),
    Rule("VERTICAL_DAMPING QSY7", lambda x: x >= 0, "must not be negative. Correct it."),
    Rule("PTY2", bool, "must not be 0. Correct it, or leave out PTY1 and PTY2."),
)
KINDS = ", ".join(map(str, LAWS))
UNSUPPORTED = f"is {{:g}}, which is not supported. Choose from {KINDS}."
VERSION = Rule("FITTYP", LAWS.__contains__, UNSUPPORTED, f", the version of the formulas, one of {KINDS}")
OF_61 = (Rule("PKY4", bool, "must not be 0. Correct it.", ""),)
EDGE = ", which Q_CAM1 and Q_CAM2 need"
OF_EDGE = (  # of the tread of an inclined tyre, 6.2
    Rule("WIDTH", lambda x: x > 0, f"must be greater than 0{EDGE}. Correct it.", EDGE),
    Rule("ASPECT_RATIO", lambda x: 0 < x < 2, f"must be between 0 and 2{EDGE}. Correct it.", EDGE),
)
TURNS = ", which turn_slip needs"
OF_TURN_SLIP = (
    Rule("PHYP1 PHYP2", bool, "must not be 0 for turn_slip, but is {:g}. Correct it.", TURNS),
    Rule("QCRP1", lambda x: x > 0, "must be greater than 0 for turn_slip, but is {:g}. Correct it.", TURNS),
    Rule("QDRP1", lambda x: 0 < x < 2, "must be between 0 and 2 for turn_slip, but is {:g}. Correct it.", TURNS),
    Rule("PECP1", lambda x: x < 1, "must be less than 1 for turn_slip, but is {:g}. Correct it."),
)  # fmt: skip


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
            message = f"coefficients must be a mapping, but is {show(given)}"
            raise ModelError(f"{message}. Give those of sr.load_tyre(...).", field="coefficients")
        for option in ("turn_slip", "large_angles"):
            if not isinstance(value := getattr(self, option), bool):
                raise ModelError(f"{option} must be True or False, but is {show(value)}.", field=option)
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
            message = f"{field} has the unknown name {quote(name)}. {suggest(name, KNOWN)}"
            raise ModelError(message, field=field)
        number(value, f"{field}.{name}")
    plain = {name: float(value_of(value)) for name, value in given.items()}
    _check(plain, [VERSION], field)
    kind = plain["FITTYP"]
    law, unused = LAWS[int(kind)], _unused(given, turn_slip)
    _check_values(plain, law, field)
    if turn_slip and law is not MagicFormula61:
        message = f"turn_slip needs a FITTYP from 60 to 62, but it is {kind:g}. Leave turn_slip out."
        raise ModelError(message, field="turn_slip")
    if turn_slip:
        _check(plain, OF_TURN_SLIP, field)
        law = TurnSlip
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
            remedy = "F_y < 0 for α > 0. Correct the signs of PKY1, PKY2 and LKY."
            raise ModelError(f"{message}: {remedy}", field=field)
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
    unused = {"FITTYP", "FZMIN"}
    if not turn_slip:
        unused |= {*TURN, "LMP"}
    if plain.get("FITTYP") != 62 or not (plain.get("Q_CAM1") or plain.get("Q_CAM2")):
        unused |= {*CAMBER, "WIDTH", "ASPECT_RATIO"}
    if not (plain.get("RCX1") or plain.get("RCY1")):
        unused |= {"RCX1", "RCY1"}
    if not plain.get("Q_FZ1"):
        unused.add("Q_FZ1")
    return unused.intersection(plain)


def _check(plain: Mapping[str, float], rules: Iterable[Rule], field: str) -> None:
    for rule in rules:
        for name in rule.coefficients.split():
            if name not in plain and rule.needed is not None:
                raise ModelError(f"{field} has no {name}{rule.needed}. Add it.", field=field)
            if name in plain and not rule.holds(plain[name]):
                raise ModelError(f"{field}.{name} {rule.message.format(plain[name])}", field=field)


def _check_values(plain: Mapping[str, float], law: type[TyreLaw], field: str) -> None:
    _check(plain, (*RULES, *OF_61) if law is MagicFormula61 else RULES, field)
    for name, other in (("RCX1", "RCY1"), ("RCY1", "RCX1")):
        if plain.get(name) and not plain.get(other):
            message = f"{field} has {name}, but no {other}, for forces in combined slip"
            raise ModelError(f"{message}. Add it, or leave out both for an ellipse.", field=field)
    if plain["FITTYP"] == 62 and (plain.get("Q_CAM1") or plain.get("Q_CAM2")):
        _check(plain, OF_EDGE, field)
        if plain.get("Q_CAM1", 0.0) + plain.get("Q_CAM2", 0.0) * plain["UNLOADED_RADIUS"] == 0.0:
            raise ModelError(f"{field}.Q_CAM1 + Q_CAM2 R must not be 0. Correct them.", field=field)
    for name in ("KPU", "ALP", "CAM"):
        low, high = plain.get(f"{name}MIN", -0.1), plain.get(f"{name}MAX", 0.1)
        if low >= 0.0 or high <= 0.0:
            span = f"the range {low:g} to {high:g} of {name}MIN and {name}MAX, without zero in it"
            raise ModelError(f"{field} has {span}. Correct it.", field=field)
    if plain.get("FZMIN", 0.0) >= plain.get("FZMAX", inf):
        raise ModelError(f"{field}.FZMIN must be below FZMAX, {plain['FZMAX']:g} N. Correct it.", field=field)
    steep = plain["VERTICAL_STIFFNESS"] * plain["UNLOADED_RADIUS"] / plain["FNOMIN"]
    if not plain.get("Q_FZ1") and 4 * plain.get("Q_FZ2", 0.0) >= steep * steep:
        limit = f"{field}.Q_FZ2 must be less than {steep * steep / 4:.6g}, that VERTICAL_STIFFNESS is reached at FNOMIN"
        raise ModelError(f"{limit}, but is {plain['Q_FZ2']:g}. Correct it, or give Q_FZ1.", field=field)


def mirrored(coefficients: Mapping[str, float]) -> dict[str, float]:
    """Return the coefficients of the mirrored tyre: F_y, M_x and M_z at -α and -γ with the opposite sign."""
    return {
        RANGES.get(name, name): -value if name in MIRRORED or name in RANGES else value
        for name, value in coefficients.items()
    }
