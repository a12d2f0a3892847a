"""Which reader a file needs, told by its ending."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ..model import Model, ModelError, load


def load_any(path: str | os.PathLike[str], **wishes: Any) -> Model:
    """Read a model from a model file (.yaml, .yml, .json), a URDF (.urdf) or an MJCF (.xml).

    Parameters
    ----------
    path
        The file.
    wishes
        Handed to `load_urdf` or `load_mjcf`; a model file takes none.

    Raises
    ------
    ModelError
        For anything that is wrong with the file.
    """
    ending = Path(path).suffix.lower()
    if ending == ".urdf" or (ending == ".xml" and _is_urdf(Path(path))):
        from .urdf import load_urdf

        return load_urdf(path, **wishes)
    if ending == ".xml":
        from .mjcf import load_mjcf

        return load_mjcf(path, **wishes)
    if wishes:
        told = f"is a model file, which says all itself; leave out {', '.join(wishes)}"
        raise ModelError(told, part="file", where=str(path))
    return load(path)


def _is_urdf(path: Path) -> bool:
    """Whether an XML file begins as a robot; one that cannot be read is told of by its reader."""
    from .urdf.element import read_xml

    try:
        return read_xml(path).tag == "robot"
    except ModelError:
        return False
