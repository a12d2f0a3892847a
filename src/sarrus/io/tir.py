"""Files of tyre coefficients, .tir: read in their units, written in SI units.

The format has sections of lines ``KEY = value``, with comments behind $ and !. It differs between programs: values may
be quoted, keys may be of lower case, the load scale is LFZO or LFZ0, PAC2002 has no FITTYP, and calls pressures IP and
IP_NOM. Coefficients of the formulas have no unit, so only dimensions, loads, stiffnesses, pressures and ranges are in
the units of the file.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..algebra import Array
from ..deferred import renderer
from ..elements.forces.tyres import Slip, TyreLaw, Wrench, sampled
from ..elements.forces.tyres.magic_formula_wheel import TURN, without_relaxation
from ..model.errors import ModelError, SarrusWarning, listed
from ..model.expression.units import UnitFactor, in_si
from ..model.show import quote, suggest
from ..model.tyres.magic_formula import KNOWN, checked, mirrored
from ..results.saving.exported_file import exporting
from .tyre_fit import TyreFit, columns, fitted

LINE = re.compile(r"\s*(?P<key>[A-Za-z_]\w*)\s*=\s*(?P<value>.*?)\s*")
SECTION = re.compile(r"\s*\[(?P<name>[^\]]*)\]\s*")
SHIPPED = Path(__file__).resolve().parents[1] / "mechanisms"
ALIASES = {"LFZ0": "LFZO", "IP": "INFLPRES", "IP_NOM": "NOMPRES"}
SPELLINGS = {  # of units, by symbols of Sarrus, of which the first one is that of the SI
    "LENGTH": "m meter metre, mm millimeter millimetre, cm centimeter centimetre, km kilometer, in inch, ft foot",
    "FORCE": "N newton, kN kilonewton knewton, lbf pound_force, kgf kilogram_force",
    "ANGLE": "rad radian radians, deg degree degrees",
    "TIME": "s second seconds sec, ms millisecond, min minute, h hour",
    "PRESSURE": "Pa pascal newton/meter^2, kPa kilopascal kpascal, MPa megapascal mpascal, bar, psi",
}
SYMBOLS = {
    kind: {word.lower(): words.split()[0] for words in text.split(",") for word in words.split()}
    for kind, text in SPELLINGS.items()
}
DIMENSIONS: dict[str, dict[str, int]] = {  # of the numbers that have one, powers of the units of a file
    **{key: {"LENGTH": 1} for key in ("UNLOADED_RADIUS", "WIDTH")},
    **{key: {"FORCE": 1} for key in ("FNOMIN", "FZMIN", "FZMAX")},
    **{key: {"PRESSURE": 1} for key in ("NOMPRES", "INFLPRES")},
    **{key: {"ANGLE": 1} for key in ("ALPMIN", "ALPMAX", "CAMMIN", "CAMMAX")},
    **{f"{word}_STIFFNESS": {"FORCE": 1, "LENGTH": -1} for word in ("VERTICAL", "LONGITUDINAL", "LATERAL")},
    "LONGVL": {"LENGTH": 1, "TIME": -1},
    "VERTICAL_DAMPING": {"FORCE": 1, "LENGTH": -1, "TIME": 1},
}
WRITTEN = {kind: [*words][1] for kind, words in SYMBOLS.items()} | {"MASS": "kg"}
SIDES = ("left", "right", "symmetric")
DESCRIBED = ("TYRESIDE", "PROPERTY_FILE_FORMAT", "LCZ")  # further keys that are read
FORMULAS = ("VERTICAL", "STRUCTURAL")  # sections of the formulas' numbers, beside those named coefficients
# In names of numbers there that are not of the formulas
DESCRIBING = ("RADIUS", "WIDTH", "BOTTOM", "DYNAMIC")
SECTIONS = (  # of written files: name, and what its keys begin with
    ("MODEL", ("FITTYP", "LONGVL")),
    ("DIMENSION", ("UNLOADED", "WIDTH", "ASPECT")),
    ("OPERATING_CONDITIONS", ("INFLPRES", "NOMPRES")),
    ("VERTICAL", ("FNOMIN", "VERTICAL", "Q_", "PFZ", "BREFF", "DREFF", "FREFF")),
    ("STRUCTURAL", ("LONGITUDINAL", "LATERAL", "PCF")),
    ("LONG_SLIP_RANGE", ("KPU",)),
    ("SLIP_ANGLE_RANGE", ("ALP",)),
    ("INCLINATION_ANGLE_RANGE", ("CAM",)),
    ("VERTICAL_FORCE_RANGE", ("FZM",)),
    ("SCALING_COEFFICIENTS", ("L",)),
    ("TURNSLIP_COEFFICIENTS", TURN),
    ("LONGITUDINAL_COEFFICIENTS", ("PCX", "PDX", "PEX", "PKX", "PHX", "PVX", "PPX", "R", "PTX")),
    ("OVERTURNING_COEFFICIENTS", ("QSX", "PPM")),
    ("ROLLING_COEFFICIENTS", ("QSY",)),
    ("ALIGNING_COEFFICIENTS", ("Q", "S", "PPZ")),
    ("LATERAL_COEFFICIENTS", ("P", "R")),
)


class Entry(NamedTuple):
    """A value of a file: its text, its line, and the section."""

    text: str
    line: int
    section: str


@dataclass(frozen=True, eq=False)
class TyreFile:
    """The coefficients of a tyre, by the names of .tir files.

    Attributes
    ----------
    name : of the file, without its ending
    coefficients : numbers in SI units, with FITTYP, for `MagicFormulaTyre`
    side : on which side of a vehicle the tyre was measured, ``left``, ``right`` or empty
    notes : what of the file is not used
    """

    name: str
    coefficients: Mapping[str, float]
    side: str = ""
    notes: tuple[str, ...] = field(default=())

    def law(self) -> TyreLaw:
        """Return the law with these coefficients, for its forces in given slips."""
        kind, coefficients = checked(self.coefficients, "coefficients")
        return kind(coefficients)

    def mirrored(self) -> TyreFile:
        """Return the mirrored tyre, for the other side of a vehicle."""
        other = {"left": "right", "right": "left"}.get(self.side, "")
        return TyreFile(self.name, mirrored(self.coefficients), other, self.notes)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a .tir file in SI units."""
        with exporting(Path(path)) as draft:
            Path(draft).write_text("\n".join(self._lines()) + "\n", encoding="latin-1")

    def plot(self) -> Any:
        """Draw F_x over κ, F_y and M_z over α at several loads, and F_x and F_y together; returns the figure."""
        return renderer().tyre_figure(self.law(), self.name)

    def forces(self, slips: Mapping[str, Any]) -> dict[str, Array]:
        """Return F_x, F_y [N], M_x, M_y and M_z [N m] at slips, columns by name as in `fit`."""
        law = self.law()
        values, _ = sampled(law, columns(slips, law, "slips")[0])
        return dict(zip(Wrench._fields, values, strict=True))

    def fit(
        self,
        measured: Mapping[str, Any],
        wrt: Sequence[str],
        *,
        sigma: Mapping[str, float] | None = None,
        bounds: Mapping[str, tuple[float, float]] | None = None,
    ) -> TyreFit:
        """Estimate coefficients from steady-state measurements, by least squares with exact derivatives.

        Parameters
        ----------
        measured : columns (n,) by name, also a data frame: ``load`` [N], ``kappa`` [-], ``alpha`` and ``gamma`` [rad],
            ``speed`` [m/s], and what was measured of ``F_x``, ``F_y`` [N], ``M_x``, ``M_y``, ``M_z`` [N m]. Slips that
            are left out are 0, and the speed is LONGVL.
        wrt : names of the coefficients to estimate, which the file has: their values are the start
        sigma : standard deviation of each force and moment; by default all have the same relative to their largest
            value, and the noise is estimated from the residuals
        bounds : least and largest value of coefficients

        Returns
        -------
        TyreFit

        Raises
        ------
        ModelError
            If columns or coefficients are missing, unknown or not finite, or the measurements do not determine them.
        """
        return fitted(self, measured, wrt, sigma, bounds)

    def _lines(self) -> Iterator[str]:
        yield "$ written by Sarrus"
        header = {"FILE_TYPE": "'tir'", "FILE_VERSION": "3.0", "FILE_FORMAT": "'ASCII'"}
        yield from ("[MDI_HEADER]", *(f"{key:24}= {text}" for key, text in header.items()))
        yield from ("[UNITS]", *(f"{key:24}= '{unit}'" for key, unit in WRITTEN.items()))
        left = dict(self.coefficients)
        for section, beginnings in SECTIONS:
            chosen = [name for name in left if name.startswith(beginnings)]
            chosen = [name for name in chosen if section != "LONGITUDINAL_COEFFICIENTS" or name[2:3] != "Y"]
            if chosen:
                yield f"[{section}]"
            if section == "MODEL" and self.side:
                yield f"{'TYRESIDE':24}= '{self.side.upper()}'"
            yield from (f"{name:24}= {_written(name, left.pop(name))}" for name in chosen)


def _written(name: str, value: float) -> str:
    """A number of a written file; the version of the formulas is a whole one."""
    return str(int(value)) if name == "FITTYP" else repr(float(value))


def load_tyre(path: str | os.PathLike[str]) -> TyreFile:
    """Read a .tir file of the Magic Formula 5.2, 6.1 or 6.2, or of PAC2002.

    Parameters
    ----------
    path : the file; or ``"passenger_car"``, which comes with the package

    Returns
    -------
    TyreFile
        With a warning if the file has numbers of parts of the formulas that are not supported.

    Raises
    ------
    ModelError
        With file, line and remedy, if a value is missing or has no sense.
    """
    file = Path(path)
    if str(path) == file.stem and not file.exists() and (SHIPPED / f"{path}.tir").exists():
        file = SHIPPED / f"{path}.tir"
    try:
        text = file.read_text(encoding="latin-1")
    except OSError as error:
        reason = "does not exist" if isinstance(error, FileNotFoundError) else "cannot be read"
        raise ModelError(f"{file} {reason}. Give the path of a .tir file.") from None
    entries = dict(_entries(text, str(path)))
    if not entries or "\0" in text:
        message = "has no lines KEY = value of a text file. Give a .tir file, which is plain text"
        raise ModelError(f"{message} in ASCII or Latin-1.", where=str(path))
    coefficients, unused = _coefficients(entries, str(path))
    try:
        checked(coefficients, "the file")
    except ModelError as error:
        raise _placed(error, entries, str(path)) from None
    notes = tuple(_notes(text, unused, coefficients))
    for note in notes:
        warnings.warn(f"{file.name}: {note}", SarrusWarning, stacklevel=2)
    side = entries["TYRESIDE"].text.lower() if "TYRESIDE" in entries else ""
    if side not in (*SIDES, ""):
        message = f"TYRESIDE must be one of {', '.join(SIDES).upper()}, but is {quote(side)}. Correct it."
        raise ModelError(message, where=f"{path}:{entries['TYRESIDE'].line}")
    return TyreFile(file.stem, coefficients, side if side in ("left", "right") else "", notes)


def _placed(error: ModelError, entries: Mapping[str, Entry], path: str) -> ModelError:
    """An error of the coefficients, with the line of the key that it begins with."""
    match = re.match(r"the file\.(?P<key>\w+)", error.message)
    if match is None or match["key"] not in entries:
        return ModelError(error.message, where=path)
    return ModelError(error.message.removeprefix("the file."), where=f"{path}:{entries[match['key']].line}")


def _entries(text: str, path: str) -> Iterator[tuple[str, Entry]]:
    """The values by key in upper case, units those of their section.

    The same key twice in one section, or one that is used, is refused if the values differ.
    """
    section, found = "", dict[str, Entry]()
    for number, line in enumerate(text.splitlines(), 1):
        line = _without_comment(line)
        if match := SECTION.fullmatch(line):
            section = match["name"].strip().upper()
        if match := LINE.fullmatch(line):
            key = ALIASES.get(match["key"].upper(), match["key"].upper())
            entry = Entry(match["value"].strip("'\"").strip(), number, section)
            if key in SYMBOLS and section != "UNITS":
                continue
            before = found.setdefault(key, entry)
            counts = key in KNOWN or key in DESCRIBED or section == before.section
            if counts and before.text != entry.text and _value(before.text) != _value(entry.text):
                message = f"{key} is {before.text} in line {before.line} and {entry.text} in line {number}"
                raise ModelError(f"{message}. Remove one of them.", where=f"{path}:{number}")
    yield from found.items()


def _value(text: str) -> float | str:
    """A number, also with an exponent of Fortran, or the text."""
    try:
        return float(re.sub("[dD]", "e", text))
    except ValueError:
        return text


def _without_comment(line: str) -> str:
    """The part of a line before $ or !, which are no comments within quotes."""
    kept = re.match(r"""(?:'[^']*'|"[^"]*"|[^$!])*""", line)
    return kept[0] if kept else ""


def _coefficients(entries: Mapping[str, Entry], path: str) -> tuple[dict[str, float], list[str]]:
    """The numbers of the formulas in SI units, and the names of those that are not used."""
    units = {kind: _unit(entries, kind, path) for kind in SYMBOLS}
    found, unused = dict[str, float](), list[str]()
    for key, entry in entries.items():
        if key in KNOWN:
            powers = DIMENSIONS.get(key, {}).items()
            factors = [UnitFactor(units[kind], power) for kind, power in powers if units[kind]]
            found[key], _ = in_si(_number(key, entry, path), factors)
        elif _counts(key, entry):
            unused.append(key)
    if "LCZ" in entries and "VERTICAL_STIFFNESS" in found:
        found["VERTICAL_STIFFNESS"] *= _number("LCZ", entries["LCZ"], path)
    program = entries["PROPERTY_FILE_FORMAT"].text.upper() if "PROPERTY_FILE_FORMAT" in entries else ""
    if "FITTYP" not in found and program == "PAC2002":
        found["FITTYP"] = 6.0
    if "FITTYP" not in found:
        message = "FITTYP is missing, the version of the formulas. Add it to [MODEL], such as FITTYP = 61."
        if program:
            message = f"{program} is not supported. Give a file of PAC2002, or of Magic Formula 5.2 to 6.2."
        raise ModelError(message, where=path)
    return found, unused


def _counts(key: str, entry: Entry) -> bool:
    """Whether a number that is not known would change forces."""
    value, neutral = _value(entry.text), 1.0 if entry.section.startswith("SCALING") else 0.0
    of_formulas = entry.section in FORMULAS or "COEFFICIENTS" in entry.section
    describes = key == "LCZ" or any(word in key for word in DESCRIBING)
    return isinstance(value, float) and of_formulas and not describes and value != neutral


def _unit(entries: Mapping[str, Entry], kind: str, path: str) -> str:
    """The symbol of a unit of the file; empty if it is that of the SI."""
    known = SYMBOLS[kind]
    if kind not in entries:
        return ""
    word = entries[kind].text.lower()
    if word not in known:
        message = f"{kind} has the unknown unit {quote(entries[kind].text)}. {suggest(word, known)}"
        raise ModelError(message, where=f"{path}:{entries[kind].line}")
    return "" if known[word] == next(iter(known.values())) else known[word]


def _number(key: str, entry: Entry, path: str) -> float:
    value = _value(entry.text)
    if isinstance(value, str):
        message = f"{key} must be a number, but is {quote(entry.text)}. Correct it."
        raise ModelError(message, where=f"{path}:{entry.line}")
    return value


def _negative(coefficients: Mapping[str, float]) -> Iterator[str]:
    """Where frictions and stiffnesses lose their sign below the largest load of a file."""
    kind, given = checked(coefficients, "the file")
    law: Any = kind(given)
    most = coefficients.get("FZMAX", 1.5 * float(law.nominal_load))
    loads = np.linspace(0.0, most, 201)[1:]
    slips = [Slip(0.0, 0.0, 0.0, float(load)) for load in loads]
    for what, values in (
        ("the longitudinal slip stiffness", [law.longitudinal_stiffness(slip) for slip in slips]),
        ("the longitudinal friction", [law.longitudinal(slip).mu for slip in slips]),
        ("the cornering stiffness", [-law.cornering_stiffness(slip.load, 0.0) for slip in slips]),
        ("the lateral friction", [law.lateral(slip, 0.0).mu * law.PDY1 for slip in slips]),
    ):
        wrong = loads[np.array(values) <= 0.0]
        if wrong.size:
            yield f"{what} has the wrong sign from {wrong[0]:.4g} N to {wrong[-1]:.4g} N. Give a smaller FZMAX"


def _notes(text: str, unused: list[str], coefficients: Mapping[str, float]) -> Iterator[str]:
    if unused:
        yield f"{listed(unused)} not used: the belt and further effects are left out"
    if "[DEFLECTION_LOAD_CURVE]" in text.upper():
        yield "DEFLECTION_LOAD_CURVE is not used: the load is that of VERTICAL_STIFFNESS"
    if not coefficients.get("RCX1") and not coefficients.get("RCY1"):
        yield "there are no RCX1 and RCY1: forces in combined slip are on an ellipse"
    for word in without_relaxation(coefficients):
        yield f"there is no {word} relaxation length, so it is shortest_relaxation of the tyre"
    least, load, most = (coefficients.get(name, 0.0) for name in ("FZMIN", "FNOMIN", "FZMAX"))
    if not least <= load <= (most or load):
        yield f"FNOMIN, {load:g} N, is not between FZMIN and FZMAX. Correct them: beyond FZMAX forces are constant"
    yield from _negative(coefficients)
