"""An MJCF file as MuJoCo compiles it: defaults, classes, includes and shapes are resolved there."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from contextlib import suppress
from enum import IntEnum
from importlib import import_module
from math import prod
from pathlib import Path
from typing import Any
from xml.parsers import expat

from ...model.errors import ModelError
from ...model.file.include import DEEPEST
from ...model.file.text.source import read_bytes
from ...model.show import counted
from ..xml.element import read_xml

MISSING = "opening file"  # in MuJoCo's message
SYNTAX = re.compile("XML parse error|ParseXML")
TETRAHEDRON = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]


class Shape(IntEnum):
    """MuJoCo's mjtGeom."""

    PLANE = 0
    SPHERE = 2
    CAPSULE = 3
    ELLIPSOID = 4
    CYLINDER = 5
    BOX = 6
    MESH = 7


class Object(IntEnum):
    """MuJoCo's mjtObj."""

    BODY = 1
    XBODY = 2
    JOINT = 3
    GEOM = 5
    SITE = 6


class Transmission(IntEnum):
    """MuJoCo's mjtTrn."""

    JOINT = 0
    IN_PARENT = 1
    TENDON = 3
    SITE = 4


class ActuatorDynamics(IntEnum):
    """MuJoCo's mjtDyn."""

    INTEGRATOR = 1
    FILTER = 2
    EXACT = 3
    MUSCLE = 4


class Gain(IntEnum):
    """MuJoCo's mjtGain and mjtBias."""

    FIXED = 0
    AFFINE = 1
    MUSCLE = 2


MOST = 20_000  # elements, those those in <replicate> counted as often as they are repeated
MOST_CELLS = 25_000_000  # of a texture or a height field
COUNTS = {"replicate": "count", "composite": "count", "flexcomp": "count"}
CELLS = {"texture": ("width", "height"), "hfield": ("nrow", "ncol")}
FILES = ("include", "model")  # elements that name another file


def mujoco() -> Any:
    """Return the module ``mujoco``.

    Raises
    ------
    ImportError
        If it is not installed, with the command that does it.
    """
    try:
        return import_module("mujoco")
    except ImportError:
        message = 'reading MJCF needs the package mujoco. Install it, pip install "sarrus[mjcf]".'
        raise ImportError(message) from None


def version() -> tuple[int, ...]:
    """Return the major and the minor version of MuJoCo, which decide what some attributes mean."""
    return tuple(int(word) for word in mujoco().__version__.split(".")[:2])


def compiled(path: Path, search: Sequence[str | os.PathLike[str]] = ()) -> tuple[Any, list[str]]:
    """Return the compiled ``MjModel`` of a file, and a note where meshes are missing, in the folders of search, too.

    Raises
    ------
    ModelError
        If there is no such file, or MuJoCo cannot read it.
    """
    check_counts(path)
    try:
        return mujoco().MjModel.from_xml_path(str(path)), []
    except (ValueError, RuntimeError) as error:
        refusal = _refusal(path, " ".join(str(error).split()))
    if SYNTAX.search(refusal.message):
        read_xml(path)  # whose message has the line and the reason
    if MISSING in refusal.message:
        with suppress(ValueError, RuntimeError):
            return _without_missing_meshes(path, refusal, search)
    raise refusal


def _without_missing_meshes(
    path: Path, refusal: ModelError, search: Sequence[str | os.PathLike[str]]
) -> tuple[Any, list[str]]:
    """Return a model with meshes from other folders, and a tetrahedron, without contact, in place of each missing one.

    Raises
    ------
    ModelError
        The refusal, if the mass of a body follows from one of them.
    """
    spec = mujoco().MjSpec.from_file(str(path))
    folder = Path(spec.modelfiledir) / spec.meshdir
    absent = [mesh for mesh in spec.meshes if mesh.file and not (folder / mesh.file).is_file()]
    for mesh in absent:
        mesh.name = mesh.name or Path(mesh.file).stem
        places = (Path(one).resolve() / mesh.file for one in search)
        mesh.file = next((str(place) for place in places if place.is_file()), "")
    missing = [mesh for mesh in absent if not mesh.file]
    for mesh in missing:
        mesh.uservert = TETRAHEDRON
    names = {mesh.name for mesh in missing}
    for geom in spec.geoms:
        if geom.meshname in names:
            if not geom.parent.explicitinertial and geom.parent.name != "world":
                raise refusal
            geom.contype = geom.conaffinity = 0
    text = "{n} [mesh whose file is|meshes whose files are] missing: [it is|they are] neither drawn nor in contact"
    return spec.compile(), [counted(text, len(names))] if names else []


def name_of(compiled: Any, word: str, k: int) -> str:
    """Return the name of a body, joint, sensor, ...; without one its kind and number, and `_` where that is a name."""
    elements = getattr(compiled, word)
    name = str(elements(k).name) or f"{word}{k}"
    while not elements(k).name and _is_there(elements, name):
        name += "_"
    return name


def _is_there(elements: Any, name: str) -> bool:
    try:
        elements(name)
    except KeyError:
        return False
    return True


def _refusal(path: Path, message: str) -> ModelError:
    line = re.search(r"line (\d+)", message)
    where = f"{path}:{line[1]}" if line else str(path)
    return ModelError(f"cannot be read by MuJoCo, {message.rstrip('.')}. Fix it.", part="file", where=where)


def check_counts(path: Path) -> None:
    """Raise a ModelError for a file that asks for more than MuJoCo can make in seconds."""
    _Counter(path, path.parent, 1, 0).read()


class _Counter:
    """Counts the elements of a file and of those that it includes, each times the repetitions around it."""

    def __init__(self, file: Path, folder: Path, times: int, depth: int) -> None:
        self.file, self.folder, self.depth = file, folder, depth
        self.count = 0
        self.times = [times]
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = lambda tag: self.times.pop()
        self.parser.StartDoctypeDeclHandler = self._doctype

    def read(self) -> int:
        """Return the count; MuJoCo reports what is not XML."""
        try:
            self.parser.Parse(read_bytes(self.file), True)
        except (expat.ExpatError, LookupError):
            return self.count
        return self.count

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.times.append(self.times[-1] * _product(attributes.get(COUNTS.get(tag, ""), "1")))
        self.count += self.times[-1]
        if tag in FILES and (self.folder / attributes.get("file", "")).is_file():
            self._other(self.folder / attributes["file"])
        if tag == "connect" and "anchor" in attributes and len(attributes["anchor"].split()) != 3:
            anchor = attributes["anchor"]
            message = f'`anchor` of <connect> must be three numbers, got "{anchor}". Give the point in body1.'
            raise ModelError(
                message, part="file", where=self._place()
            )  # MuJoCo reads on beyond its end, and may hang
        if self.count > MOST:
            raise self._refusal(f"asks for more than {MOST:,} elements, with those that <replicate> repeats")
        if tag in CELLS and _product(*(attributes.get(name, "1") for name in CELLS[tag])) > MOST_CELLS:
            raise self._refusal(f"asks for a {tag} of more than {MOST_CELLS:,} cells")

    def _other(self, file: Path) -> None:
        if self.depth == DEEPEST:
            raise self._refusal(f"includes more than {DEEPEST} levels of files")
        self.count += _Counter(file, self.folder, self.times[-1], self.depth + 1).read()

    def _doctype(self, *declared: object) -> None:
        raise self._refusal("declares a document type, which could define entities")

    def _refusal(self, message: str) -> ModelError:
        message = f"{message}. Take it out, or make the file smaller."
        return ModelError(message, part="file", where=self._place())

    def _place(self) -> str:
        return f"{self.file}:{self.parser.CurrentLineNumber}"


def _product(*texts: str) -> int:
    """The product of whole numbers; other words are left to MuJoCo."""
    return prod(int(word) for text in texts for word in text.split() if word.isdecimal() and len(word) < 19)


WIDER = {"SPRING": ("PASSIVE",), "DAMPER": ("PASSIVE",)}  # one flag for both before MuJoCo 3.3.6
CONSTRAINTS = ("EQUALITY", "FRICTIONLOSS", "LIMIT", "CONTACT")


def disabled(compiled: Any, name: str) -> bool:
    """Return whether the file has ``<flag name="disable">``, or switches off all constraints, of which this is one."""
    words = (name, *WIDER.get(name, ()), *(("CONSTRAINT",) if name in CONSTRAINTS else ()))
    bits = (getattr(mujoco().mjtDisableBit, f"mjDSBL_{word}", 0) for word in words)
    return any(int(compiled.opt.disableflags) & int(bit) for bit in bits)


def no_passive_forces(compiled: Any) -> bool:
    """Return whether springs and dampers are disabled, and with them all passive forces, as of a fluid."""
    return disabled(compiled, "SPRING") and disabled(compiled, "DAMPER")


def enabled(compiled: Any, name: str) -> bool:
    """Return whether the file has ``<flag name="enable">``."""
    bit = int(getattr(mujoco().mjtEnableBit, f"mjENBL_{name}", 0))
    return bool(int(compiled.opt.enableflags) & bit)
