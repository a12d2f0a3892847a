"""A suspension on the rig in a file: the model, the wheels and the sweeps; every error with file and line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from ..model import Model, SarrusError
from ..model.checks.findings import Origin
from ..model.expression import parse
from ..model.expression.quantity import quantity_of
from ..model.file.load import read, shipped
from ..model.file.text.document import Document
from ..model.quantity import number
from ..model.show import suggest
from ..system import System
from ..vehicles import Corner, Suspension, Vehicle, suspension
from ..vehicles.corner import FORWARD, PlacedCorner, Side
from ..vehicles.rig import coordinate
from .file import Entries

LENGTHS = ("bump", "roll")
OPTIONS = ("bump", "roll", "steering", "steer", "steps", "fixed", "forward")
KEYS = ("model", "wheels", "vehicle", *OPTIONS)
SECTION = "rig"  # of a model file, with all keys but the model
MODEL = ("bodies", "left", "right", "include")  # keys of model files
SIDES = ("left", "right")
UNITS = {
    "radius": "m", "wheelbase": "m", "cg_height": "m", "brake_share": "1", "drive_share": "1", "tyre_stiffness": "N/m",
}  # fmt: skip


class RigFile(NamedTuple):
    """The system of a file, and the arguments of `suspension`."""

    system: System
    arguments: Mapping[str, Any]
    file: Entries

    def analysed(self) -> Suspension:
        """The suspension on the rig; errors name the file."""
        try:
            return suspension(self.system, **self.arguments)
        except SarrusError as wrong:
            raise self.file.refused(str(wrong)) from None


def read_suspension_file(path: str | Path, load: Callable[[Path], Model]) -> RigFile:
    """Read a rig from a YAML or JSON file, or from the section of a model file, and check all of it.

    Parameters
    ----------
    path : of the file, or the name of a shipped suspension
    load : reads the model, whose name is relative to the file

    Raises
    ------
    ModelError
        For anything that is wrong: file and line, what, and what to do.
    """
    path = shipped(path)
    file = Entries(read(path), "a rig", "rig, ")
    keys = {*file.document.data} if isinstance(file.document.data, dict) else set()
    if "model" not in keys and keys & {SECTION, *MODEL}:
        if SECTION not in keys:
            raise file.refused("the model has no section rig. Add it, as in 'rig: {wheels: {left: ...}}'.")
        file, model = Entries(_section(file.document), "a rig", "rig, "), path
        file.check_keys(KEYS[1:], ())
    else:
        file.check_keys(KEYS, ("model",))
        file.check_kind("model", str, "the name of a file")
        model = path.parent / file.document.data["model"]
    data = file.document.data
    system = System(load(model))
    file.check_kind("wheels", dict, "a mapping with the keys left and right")
    found = {side: file.part(partial(_wheel_of, side), "wheels", side) for side in data.get("wheels", {})}
    if "vehicle" in data:
        found["vehicle"] = file.part(partial(_part_of, Vehicle), "vehicle")
    unit = file.part(partial(_steering_unit, system), "steering") if "steering" in data else "m"
    for key in OPTIONS:
        if key in data:
            found[key] = file.part(partial(_option, system, unit, key), key)
    forward = found.get("forward", "x")
    for side in data.get("wheels", {}):
        file.part(partial(_check_wheel, system, found[side], side, forward), "wheels", side)
    return RigFile(system, found, file)


def _section(document: Document) -> Document:
    """The rig of a model file, with its lines."""
    origin = document.origin
    lines = {path[1:]: line for path, line in origin.lines.items() if path[:1] == (SECTION,)}
    return Document(document.data[SECTION], Origin(origin.file, lines))


def _steering_unit(system: System, joint: Any) -> str:
    """The unit of the coordinate that steers."""
    if not isinstance(joint, str):
        raise SarrusError(f"must be the name of a joint, got {joint!r}. Write steering: rack.")
    return "m" if "displacement" in coordinate(system, joint)[1] else "rad"


def _wheel_of(side: str, entry: Any) -> Any:
    """The wheel of a side."""
    if side not in SIDES:
        raise SarrusError(f"there is no side {side!r}. Give left and right.")
    return _part_of(Corner, entry)


def _check_wheel(system: System, corner: Corner, side: Side, forward: str, entry: Any) -> None:
    """Refuse a wheel that the system does not have."""
    PlacedCorner(system, corner, side, forward)


def _part_of(kind: type, entry: Any) -> Any:
    """A `Corner` or a `Vehicle` of its keys."""
    names = [one.name for one in fields(kind)]
    if not isinstance(entry, dict):
        raise SarrusError(f"must be a mapping, got {entry!r}. Give the keys {', '.join(names)}.")
    for key in entry:
        if key not in names:
            raise SarrusError(f"there is no key {key!r}. {suggest(str(key), names)}")
    values = {key: _value(key, value) for key, value in entry.items()}
    for one in fields(kind):
        if one.default is MISSING and one.name not in values:
            raise SarrusError(f"the key {one.name!r} is missing. Add it.")
    return kind(**values)


def _value(key: str, value: Any) -> Any:
    """A number with its unit, a global point, the names of a kingpin, or a text."""
    if key in UNITS:
        return in_unit(value, UNITS[key])
    if key == "kingpin" and isinstance(value, list):
        return tuple(_value("point", one) for one in value)
    return tuple(in_unit(one, "m") for one in value) if isinstance(value, list) else value


def _option(system: System, steering: str, key: str, value: Any) -> Any:
    """The value of an argument of `suspension`; limits of the steering have its unit."""
    if key in (*LENGTHS, "steer"):
        if value is None:
            return None
        if not isinstance(value, list) or len(value) != 2:
            raise SarrusError(f"must be two displacements, got {value!r}. Write {key}: [-50 mm, 50 mm].")
        return tuple(in_unit(one, "m" if key in LENGTHS else steering) for one in value)
    if key == "steps":
        return _count(value)
    if key == "forward" and value not in [*FORWARD]:
        raise SarrusError(f"must be one of {', '.join(FORWARD)}, got {value!r}. Choose one of them.")
    return _bodies(system, value) if key == "fixed" else value


def _count(value: Any) -> int:
    """A whole number of at least 1."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 1 <= value < inf or value % 1:
        raise SarrusError(f"must be a whole number of at least 1, got {value!r}. Write steps: 20.")
    return int(value)


def _bodies(system: System, value: Any) -> tuple[str, ...]:
    """The names of bodies that are fixed."""
    if not isinstance(value, list):
        raise SarrusError(f"must be a list of names of bodies, got {value!r}. Write fixed: [chassis].")
    for name in value:
        if name not in [*system.bodies]:
            raise SarrusError(f"the model has no body {name!r}. {suggest(str(name), [*system.bodies])}")
    return tuple(value)


def in_unit(value: Any, unit: str) -> float:
    """A number in SI units, of a number or a text with a unit."""
    if isinstance(value, str):
        return quantity_of(parse(value), unit, value).value
    return number(value, "the value", f"Give a number in {unit}, or with a unit.")
