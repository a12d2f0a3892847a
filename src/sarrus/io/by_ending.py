"""Importers of models, found by the extension and the content of a file. Each registers itself with `importer`."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ..model import Model, ModelError
from ..model.checks.arguments import checked
from ..model.file.load import loaded, read, shipped
from ..model.file.text.source import root_tag
from ..model.show import suggest

Read = TypeVar("Read", bound=Callable[..., Model])


class Importer(NamedTuple):
    """A function that reads a model, the extensions of its files, and the tags of their first element if it is XML."""

    read: Callable[..., Model]
    extensions: tuple[str, ...]
    roots: tuple[str, ...]


IMPORTERS: list[Importer] = []


def importer(*extensions: str, roots: tuple[str, ...] = ()) -> Callable[[Read], Read]:
    """Register a function ``f(path, **options)`` that reads models from files with these extensions.

    Parameters
    ----------
    extensions : in lower case, as in ".urdf"
    roots : tags of the first element of XML; files that begin with one are for this importer, whatever their extension
    """

    def register(read: Read) -> Read:
        IMPORTERS.append(Importer(read, extensions, roots))
        return read

    return register


@checked
def load_any(path: str | os.PathLike[str], **options: Any) -> Model:
    """Read a model from a model file (.yaml, .json), URDF, SDF (.sdf, .world), MJCF (.xml), or by a user's importer.

    The first element decides in XML, whatever the name of the file: ``<robot>`` is a URDF, ``<sdf>`` an SDF, and
    ``<mujoco>`` an MJCF. A file without an ending that is no XML is a model file.

    Parameters
    ----------
    path
        The file, or the name of a shipped mechanism.
    options
        Handed to the importer, as `load_urdf` or `load_mjcf`; a model file takes ``parameters``.

    Raises
    ------
    ModelError
        For anything that is wrong with the file, or an option that its reader does not have.
    """
    file = shipped(path)
    reads = _reader(file)
    if reads is load_model_file and not os.path.isfile(file):
        read(file)  # whose message comes before that on an option
    _refuse_unknown(reads, options, str(path))
    model: Model = reads(path, **options)
    return model


def _reader(file: Path) -> Callable[..., Model]:
    """Return the importer of the extension and the content, of the content, or of the extension, in this order."""
    root = root_tag(file)
    fit = [one for one in reversed(IMPORTERS) if file.suffix.lower() in one.extensions]
    sure = [one for one in fit if not one.roots or root in one.roots]
    by_content = [one for one in IMPORTERS if root in one.roots]
    return next((one.read for one in (*sure, *by_content, *fit)), load_model_file)


def load_model_file(
    path: str | os.PathLike[str], *, parameters: Mapping[str, float | str] | None = None
) -> Model:
    """Read a model file; see `sarrus.load`."""
    return loaded(read(shipped(path)), parameters)


def _refuse_unknown(read: Callable[..., Model], options: Mapping[str, Any], file: str) -> None:
    known = [name for name in inspect.signature(read).parameters if name != "path"]
    for name in options:
        if name not in known:
            raise ModelError(
                f"is read without the option {name}. {suggest(name, known)}", part="file", where=file
            )
