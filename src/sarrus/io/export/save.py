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
from . import mjcf, sdf, urdf
from .contents import Contents, contents


class Format(NamedTuple):
    """The function that returns the text of a file, and the joints that can close loops in it."""

    write: Callable[[Contents], str]
    cut: Collection[type[object]]


FORMATS = {
    ".xml": Format(mjcf.mjcf, mjcf.CUT),
    ".sdf": Format(sdf.sdf, sdf.CUT),
    ".urdf": Format(urdf.urdf, urdf.CUT),
}


@checked
def export(model: Model, path: str | os.PathLike[str], *, ignore: Sequence[str] = ()) -> None:
    """Write a model for another program, in its assembled initial position, where all coordinates are zero.

    MJCF has trees, loops by ``connect`` and ``weld``, which are elastic in MuJoCo, springs, dampers, friction and
    inertia of joints, springs and rods between points, couplers, constant forces, ranges of joints without their
    stiffness, and initial velocities. SDF has trees and loops of simple joints with springs, dampers and friction. URDF
    has trees with dampers and friction; the origin of each link is moved to the joint above it.

    Parameters
    ----------
    model
        Any model whose parts the format has.
    path
        The file, which ends in ``.xml`` (MJCF), ``.sdf`` or ``.urdf``; one that is there is replaced.
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
