"""Importers of models, found by the extension of a file. Each registers itself with `importer`."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ..model import Model, ModelError
from ..model.checks.arguments import checked
from ..model.file.load import loaded, read, shipped
from ..model.show import suggest

Read = TypeVar("Read", bound=Callable[..., Model])


class Importer(NamedTuple):
    """A function that reads a model, the extensions of its files, and how it recognizes one that others read, too."""

    read: Callable[..., Model]
    extensions: tuple[str, ...]
    recognizes: Callable[[Path], bool] | None


IMPORTERS: list[Importer] = []


def importer(*extensions: str, recognizes: Callable[[Path], bool] | None = None) -> Callable[[Read], Read]:
    """Register a function ``f(path, **options)`` that reads models from files with these extensions.

    Parameters
    ----------
    extensions : in lower case, as in ".urdf"
    recognizes : whether a file is for this importer, where several read files with its extension
    """

    def register(read: Read) -> Read:
        IMPORTERS.append(Importer(read, extensions, recognizes))
        return read

    return register


@checked
def load_any(path: str | os.PathLike[str], **options: Any) -> Model:
    """Read a model from a model file (.yaml, .json), URDF, SDF (.sdf, .world), MJCF (.xml), or by a user's importer.

    Parameters
    ----------
    path
        The file, or the name of a shipped mechanism. An ``.xml`` whose first element is ``<robot>`` is a URDF, one
        with ``<sdf>`` an SDF.
    options
        Handed to the importer, as `load_urdf` or `load_mjcf`; a model file takes ``parameters``.

    Raises
    ------
    ModelError
        For anything that is wrong with the file, or an option that its reader does not have.
    """
    file = Path(path)
    fit = [one for one in reversed(IMPORTERS) if file.suffix.lower() in one.extensions]
    fit.sort(key=lambda one: one.recognizes is None)
    reads = next((one.read for one in fit if one.recognizes is None or one.recognizes(file)), load_model_file)
    _refuse_unknown(reads, options, str(path))
    model: Model = reads(path, **options)
    return model


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
