"""An MJCF file as MuJoCo compiles it: defaults, classes, includes and shapes are resolved there."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

from ...model.errors import ModelError
from ..plurals import counted
from ..xml.element import read_xml
from .counts import check_counts

MISSING = "opening file"  # in MuJoCo's message
SYNTAX = re.compile("XML parse error|ParseXML")
TETRAHEDRON = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]


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
