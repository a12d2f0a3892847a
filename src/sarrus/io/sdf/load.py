"""``load_sdf``: from an SDF file to a model."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...model.checks.arguments import checked
from ...model.quantity import Vector, vector
from ..by_ending import importer
from ..loops import close
from ..robot import ImportOptions, Robot, build
from ..robot.options import Base, InertiaOption, MeshOption, MimicOption, check_floating
from .describe import describe


@importer(".sdf", ".world", ".xml", roots=("sdf", "gazebo"))
@checked
def load_sdf(
    path: str | os.PathLike[str],
    *,
    base: Base = "file",
    q0: Mapping[str, Any] | None = None,
    loops: str | os.PathLike[str] | None = None,
    lock: Sequence[str] = (),
    mimic: MimicOption = "couple",
    inertia: InertiaOption = "check",
    keep_fixed: bool = False,
    gravity: Vector | None = None,
    ignore: Sequence[str] = (),
    meshes: MeshOption = "draw",
    search: Sequence[str | os.PathLike[str]] = (),
) -> Robot:
    """Read a model from an SDF file: a model, or a world with its models, nested and included ones too.

    Links, joints and frames of nested models are named with the model, ``arm::elbow``; names of a file with one model
    do without it. A link with two parents closes a loop. Joints with two axes have the motions ``JOINT.1`` and
    ``JOINT.2``, a screw ``JOINT`` and ``JOINT.displacement``.

    Parameters
    ----------
    path
        The file. Meshes are read when the model is drawn.
    base
        ``"file"`` and ``"floating"``: links that are not connected with the world move freely; the motion of the
        first is named ``base``. ``"fixed"`` fixes the first link of such a model to the world, in its pose.
    q0
        Initial coordinates of joints by name, relative to the pose of the file: angle [rad], displacement [m]; for a
        ball four Euler parameters; for a free link [r, p], by default as in the file.
    loops, lock, mimic, inertia, keep_fixed
        As in `sarrus.load_urdf`.
    gravity
        In global axes [m/s²]; by default that of the world, or (0, 0, -9.8).
    ignore
        Elements to leave out although they change the motion: "kinematic", "decay" (``velocity_decay``), "fluid" (added
        mass), and "includes" that are not found; "dynamics" leaves out springs, dampers and friction of joints.
    meshes
        ``"ignore"`` leaves out visuals that are meshes.
    search
        Folders in which included models and meshes are searched, besides those near the file and in ``SDF_PATH``,
        ``GZ_SIM_RESOURCE_PATH`` and ``GAZEBO_MODEL_PATH``.

    Returns
    -------
    Robot
        Its ``notes`` list what was left out: contact, sensors, plugins, ...

    Raises
    ------
    ModelError
        For anything that is wrong or not supported, in one message with file, line, part and remedy.
    """
    given = None if gravity is None else vector(gravity, "gravity", "Give three numbers in m/s².")
    description = describe(Path(path), gravity=given, fixed=base == "fixed", ignore=ignore, search=search)
    check_floating(base, description.edges)
    given_base = "file" if base == "floating" else base
    options = ImportOptions(
        given_base, q0 or {}, lock, mimic, inertia, keep_fixed, ignore, {}, meshes, search
    )
    return close(build(description, options), loops)
