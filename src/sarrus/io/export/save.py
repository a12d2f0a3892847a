"""``export``: a model as a file for another program."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Collection, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from ...model import Model
from ...model.checks.arguments import checked
from ...model.errors import ModelError, SarrusWarning
from ...model.file.text.source import SUFFIXES
from ...model.show import quote
from ...results.saving.exported_file import exporting
from . import mjcf, sdf, urdf
from .contents import Contents, contents
from .looks import BASIC, with_shapes
from .missing import Gap, refusal


class Format(NamedTuple):
    """The function that returns the text of a file, the joints that can close loops in it, and the shapes it has.

    ``beside`` returns the text of a second file, with the loops; ``missing`` what the format does not have.
    """

    write: Callable[[Contents], str]
    cut: Collection[type[object]]
    shapes: Collection[str]
    meshes: Collection[str]
    missing: Callable[[Contents], Sequence[Gap]] = lambda contents: ()
    beside: Callable[[Contents], str] = lambda contents: ""


MESHES = (".stl", ".obj", ".dae", ".gltf", ".glb")
ALL = (*BASIC, "capsule", "ellipsoid")
FORMATS = {
    ".xml": Format(mjcf.mjcf, mjcf.CUT, ALL, (".stl", ".obj", ".msh")),
    ".sdf": Format(sdf.sdf, sdf.CUT, ALL, MESHES, sdf.missing),
    ".urdf": Format(urdf.urdf, urdf.CUT, BASIC, MESHES, urdf.missing, urdf.loops),
}


@checked
def export(model: Model, path: str | os.PathLike[str], *, ignore: Sequence[str] = ()) -> None:
    """Write a model for another program, in its assembled initial position, where all coordinates are zero.

    MJCF has trees, loops by ``connect`` and ``weld``, which are elastic in MuJoCo, springs, dampers, friction and
    inertia of joints, springs and rods between points, couplers, constant forces, ranges of joints without their
    stiffness, and initial velocities. SDF has trees and loops of simple joints with springs, dampers and friction. URDF
    has trees with dampers and friction; the origin of each link is moved to the joint above it. Its loops are written
    to a second file, ``crank.loops.yaml`` for ``crank.urdf``, which `load_urdf` reads by ``loops=``. Shapes of bodies
    are those of the format, capsules in URDF a cylinder and two spheres; meshes are named relative to the file.

    Parameters
    ----------
    model
        Any model whose parts the format has.
    path
        The file, which ends in ``.xml`` (MJCF), ``.sdf`` or ``.urdf``; one that is there is replaced, that of loops,
        too.
    ignore
        Names of joints, drivers and forces to leave out.

    Raises
    ------
    ModelError
        For the parts that the format cannot have, all in one message with the whole list for `ignore`.
    """
    file = Path(path)
    if file.suffix.lower() not in FORMATS:
        message = f"must end in {', '.join((*SUFFIXES, *FORMATS))}. Rename it."
        raise ModelError(message, where=str(file))
    kind = FORMATS[file.suffix.lower()]
    found = with_shapes(_contents(model, ignore, kind), file.parent, kind.shapes, kind.meshes)
    text, beside = kind.write(found), kind.beside(found)
    loops = file.with_suffix(".loops.yaml")
    with ExitStack() as whole:  # both files are whole before one is replaced
        for place, content in ((file, text), (loops, beside)):
            if content:
                whole.enter_context(exporting(place)).write_text(content, encoding="utf-8")
    if beside:
        message = f"{model.name}: the format has no loops; they are in {loops}."
        warnings.warn(f"{message} Load both with loops={str(loops)!r}.", SarrusWarning, stacklevel=3)


def _contents(model: Model, ignore: Sequence[str], kind: Format) -> Contents:
    """Return what an export writes.

    The model is read again without the parts that are missing, since others may depend on them.
    """
    found, more = _read(model, ignore, kind)
    missing = [*more]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about a model that nobody has
        while more:
            names = (name for one in missing for name in one.names)
            _, more = _read(model, [*ignore, *names], kind)
            missing += more
    if found is None or missing:
        raise refusal(model.name, missing, ignore)
    return found


def _read(model: Model, ignore: Sequence[str], kind: Format) -> tuple[Contents | None, Sequence[Gap]]:
    """Return what an export writes, and what the format does not have; nothing to write if a part is refused."""
    try:
        found = contents(model, ignore, kind.cut)
    except ModelError as error:
        parts = [
            part.name for parts in model.sections().values() for part in parts if part.name not in ignore
        ]
        dependent = [name for name in parts if ignore and error.part.endswith(f" {quote(name)}")]
        if not dependent:
            raise
        return None, [Gap("nothing for a part that depends on what is left out", (*dependent,))]
    return found, found.missing or kind.missing(found)
