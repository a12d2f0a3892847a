"""``load_mjcf``: from an MJCF file to a model, by way of the ``mujoco`` package."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...model.checks.arguments import checked
from ...model.errors import ModelError
from ...model.quantity import triple
from ..by_ending import importer
from ..loops import close
from ..robot import Description, ImportOptions, Robot, build
from ..robot.options import InertiaOption, MimicOption
from .bodies import edges_of, limits_of, links_of, visuals_of, zeros_of
from .compiled import compiled
from .loops import closing_joints, mimics_of


@importer(".xml")
@checked
def load_mjcf(
    path: str | os.PathLike[str],
    *,
    q0: Mapping[str, Any] | None = None,
    loops: str | os.PathLike[str] | None = None,
    lock: Sequence[str] = (),
    mimic: MimicOption = "couple",
    inertia: InertiaOption = "check",
    keep_fixed: bool = False,
) -> Robot:
    """Read a model from an MJCF file: bodies, their joints, inertials, gravity, and ``connect`` and ``weld``.

    The world is the ground. Several joints of one body become one joint that leaves the same freedoms: two crossed
    hinges a universal joint, three a spherical one, two slides and a hinge a planar one.

    Parameters
    ----------
    path
        The file; the package ``mujoco`` reads it, with its includes and meshes.
    q0
        Where joints start, by name, from the pose of the file: angle [rad], displacement [m]; for a ball four Euler
        parameters; for a free body [r, p], by default as in the file.
    loops, lock, mimic, inertia, keep_fixed
        As in `sarrus.load_urdf`.

    Returns
    -------
    Robot
        Its ``notes`` list what was left out: actuators, contact, damping, armature, ...

    Raises
    ------
    ModelError
        For anything that is wrong or not supported.
    ImportError
        If ``mujoco`` is not installed.
    """
    read = compiled(Path(path))
    robot = build(
        _description(read, Path(path)), ImportOptions("fixed", q0 or {}, lock, mimic, inertia, keep_fixed)
    )
    return close(robot.adding(*closing_joints(read, robot)), loops)


def _description(read: Any, path: Path) -> Description:
    if read.nflex:
        raise ModelError("has flexible bodies. Take them out of the file.", part="file", where=str(path))
    links = links_of(read)
    return Description(
        name=path.stem,
        file=str(path),
        links=links,
        edges=edges_of(read),
        root=next(iter(links)),
        gravity=triple(read.opt.gravity),
        limits=limits_of(read),
        mimics=mimics_of(read, str(path)),
        visuals=list(visuals_of(read)),
        notes=notes(read),
        zero=zeros_of(read),
    )


PER_FREEDOM = {
    "dof_damping": "damping of {n} joint freedoms is left out",
    "dof_frictionloss": "dry friction of {n} joint freedoms is left out",
    "dof_armature": "armature of {n} joint freedoms is left out: the mass matrix is that of the bodies",
}
COUNTS = {
    "nu": "{n} actuators are left out",
    "ntendon": "{n} tendons are left out",
    "ngeom": "{n} shapes are used for drawing only: there is no contact",
}


def notes(compiled: Any) -> list[str]:
    """Return one message for each kind of thing that is left out."""
    counts = {message: int(np.count_nonzero(getattr(compiled, key))) for key, message in PER_FREEDOM.items()}
    counts["springs of {n} joints are left out"] = int(np.count_nonzero(compiled.jnt_stiffness))
    counts["limits of {n} joints are stored, not enforced"] = int(np.count_nonzero(compiled.jnt_limited))
    counts |= {message: int(getattr(compiled, key)) for key, message in COUNTS.items()}
    return [message.format(n=n) for message, n in counts.items() if n]
