"""Choice of the reader of a model by the file extension."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..model import Model, ModelError, load
from ..model.checks.arguments import checked
from ..model.show import suggest


@checked
def load_any(path: str | os.PathLike[str], **options: Any) -> Model:
    """Read a model from a model file (.yaml, .yml, .json), a URDF (.urdf) or an MJCF (.xml).

    Parameters
    ----------
    path
        The file. An ``.xml`` whose first element is ``<robot>`` is a URDF too.
    options
        Handed to `load_urdf` or `load_mjcf`; a model file takes none.

    Raises
    ------
    ModelError
        For anything that is wrong with the file, or an option that its reader does not have.
    """
    read = _reader(Path(path))
    _refuse_unknown(read, options, str(path))
    model: Model = read(path, **options)
    return model


def _reader(path: Path) -> Callable[..., Model]:
    ending = path.suffix.lower()
    if ending == ".urdf" or (ending == ".xml" and _is_urdf(path)):
        from .urdf import load_urdf

        return load_urdf
    if ending == ".xml":
        from .mjcf import load_mjcf

        return load_mjcf
    return load


def _refuse_unknown(read: Callable[..., Model], options: Mapping[str, Any], file: str) -> None:
    known = [name for name in inspect.signature(read).parameters if name != "path"]
    for name in options:
        if name not in known:
            raise ModelError(
                f"is read without the option {name}; {suggest(name, known)}", part="file", where=file
            )


def _is_urdf(path: Path) -> bool:
    """Whether an XML file begins as a robot; its reader reports one that cannot be read."""
    from .urdf.element import read_xml

    try:
        return read_xml(path).tag == "robot"
    except ModelError:
        return False
