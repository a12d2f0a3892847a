"""The source of the model of a case: a model and the parameters that a case changes in it.

Names are those of all analyses: parameters of the model (``spring.k``, ``rod.inertia.xx``, ``pin.point.x``), parameters
of its file (``stroke``, ``crank.l``), and the initial estimate of the assembly (``start.q.crank.r.x``).
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path, PurePath
from typing import Any, NamedTuple

import numpy as np

from ..model import Model, SarrusError, load
from ..model.show import suggest
from ..model.written import with_numbers, written_numbers
from ..system import System
from .parameters import Array

GUESS = {"start.q.": "q", "start.v.": "v"}


class Start(NamedTuple):
    """The guess from which a position is sought: coordinates and velocities (nq,)."""

    q: Array
    v: Array


@dataclass(frozen=True)
class Source:
    """A model that can be sent to another process, and be made anew with other numbers.

    Attributes
    ----------
    model : as it was given
    files : the texts of its files by their names below a common folder, the main file first; empty if there are none
    """

    model: Model
    files: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, model: Model) -> Source:
        """The source of a model; its files are stored if the model still agrees with them."""
        source: object = model
        if not isinstance(source, Model):
            kind = type(source).__name__
            raise TypeError(f"a study needs a Model, got {kind}. Call sr.study(sr.load(path), ...).")
        files = _files(model)
        if files and fingerprint(System(load(_unpacked(tuple(files.items()))))) != fingerprint(System(model)):
            files = {}  # it was changed in Python after it was read
        return cls(model, files)

    @property
    def _follows(self) -> bool:
        """Whether the model follows its parameters: those of its files as they are, or those of Python code."""
        return bool(self.files) or self.model.origin is None

    def check(self, names: Iterable[str]) -> None:
        """Raise a SarrusError for a name that is no number of the model."""
        system = System(self.model)
        guess = [f"{start}{name}" for start in GUESS for name in system.coordinate_names]
        parameters = self.model.parameters if self._follows else ()
        known = [*parameters, *written_numbers(self.model), *guess]
        for name in names:
            if name in self.model.parameters and not self._follows:
                message = f"{name!r} is a parameter of a file that {system.name} no longer follows"
                raise SarrusError(
                    f"{message}. Study the model as it was loaded, or change its numbers directly."
                )
            if name not in known:
                raise SarrusError(f"{system.name} has no parameter {name!r}. {suggest(name, known)}")

    def made(self, values: Mapping[str, float]) -> tuple[System, Start]:
        """The system of a case, and its guess."""
        parameters = {name: value for name, value in values.items() if name in self.model.parameters}
        model = self.model
        if parameters and not self.files:
            model = model.with_parameters(parameters)
        elif parameters:
            model = load(_unpacked(tuple(self.files.items())), parameters=parameters)
        numbers = {n: v for n, v in values.items() if n not in parameters and not n.startswith(tuple(GUESS))}
        system = System(with_numbers(model, numbers) if numbers else model)
        return system, _guess(system, values)

    def readable(self, message: str) -> str:
        """A message without the folder in which the files were written for a case."""
        if not self.files:
            return message
        return message.replace(f"{_unpacked(tuple(self.files.items())).parent}{os.sep}", "")


def _guess(system: System, values: Mapping[str, float]) -> Start:
    start = Start(system.q0.copy(), system.v0.copy())
    for name, value in values.items():
        for beginning, field_name in GUESS.items():
            if name.startswith(beginning):
                place = system.coordinate_names.index(name.removeprefix(beginning))
                getattr(start, field_name)[place] = value
    return start


def _files(model: Model) -> dict[str, str]:
    """The files of a model as they are now, by their names below a common folder."""
    if model.origin is None:
        return {}
    paths = [Path(name) for name in dict.fromkeys([model.origin.file, *model.origin.files.values()])]
    if not all(path.is_file() for path in paths) or paths[0].suffix.lower() not in (".yaml", ".yml", ".json"):
        return {}
    root = os.path.commonpath([path.resolve().parent for path in paths])
    return {_below(path, root): path.read_text(encoding="utf-8") for path in paths}


def _below(path: Path, root: str) -> str:
    return PurePath(os.path.relpath(path.resolve(), root)).as_posix()


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """A folder of this process, removed at its end."""
    return tempfile.TemporaryDirectory(prefix="sarrus-model-")


@cache
def _unpacked(files: tuple[tuple[str, str], ...]) -> Path:
    """Write a model's files, once in a process; the path of the main one."""
    folder = Path(_folder().name) / hashlib.sha256(repr(files).encode()).hexdigest()[:16]
    for name, text in files:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder / files[0][0]


def fingerprint(system: System) -> str:
    """Hash of all names and numbers of a system: the same for the same mechanism, however it was described."""
    digest = hashlib.sha256()
    for names in (system.bodies, system.coordinate_names, system.row_names, system.parameter_names):
        digest.update(repr(list(names)).encode())
    for numbers in (system.q0, system.v0, system.b):
        digest.update(np.ascontiguousarray(numbers, dtype=float).tobytes())
    return digest.hexdigest()[:20]


def facts(source: Source) -> dict[str, Any]:
    """Return the stored description of a model: its name, fingerprint, files and parameters."""
    return {
        "name": source.model.name,
        "fingerprint": fingerprint(System(source.model)),
        "files": list(source.files),
        "parameters": dict(source.model.parameters),
        "numbers": written_numbers(source.model),
    }
