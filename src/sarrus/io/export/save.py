"""``export``: a model as a file for another program."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import NamedTuple

from ...model import Model
from ...model.checks.arguments import checked
from ...model.errors import ModelError
from ...model.file.text.source import SUFFIXES
from .contents import Contents, contents
from .mjcf import CUT, mjcf


class Format(NamedTuple):
    """The function that returns the text of a file, and the joints that can close loops in it."""

    write: Callable[[Contents], str]
    cut: Collection[type[object]]


FORMATS = {".xml": Format(mjcf, CUT)}


@checked
def export(model: Model, path: str | os.PathLike[str], *, ignore: Sequence[str] = ()) -> None:
    """Write a model as an MJCF file (``.xml``), in its assembled initial position, where all coordinates are zero.

    Parameters
    ----------
    model
        Any model: joints make a tree; MJCF closes its loops by ``connect`` and ``weld``, which are elastic in MuJoCo.
    path
        The file; one that is there is replaced.
    ignore
        Names of joints, drivers and forces to leave out.

    Raises
    ------
    ModelError
        For a part that the format cannot have.
    """
    file = Path(path)
    if file.suffix.lower() not in FORMATS:
        message = f"must end in {', '.join((*SUFFIXES, *FORMATS))}. Rename it."
        raise ModelError(message, where=str(file))
    kind = FORMATS[file.suffix.lower()]
    file.write_text(kind.write(contents(model, ignore, kind.cut)), encoding="utf-8")
