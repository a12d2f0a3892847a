"""``load_urdf``: from a URDF file to a model."""

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
from ..robot.options import Base, InertiaOption, MeshOption, MimicOption
from .describe import describe
from .frame_pairs import with_frame_pairs
from .marked_loops import with_open_loops_noted

GRAVITY = (0.0, 0.0, -9.81)  # [m/s²] as every simulator of URDF assumes


@importer(".urdf", ".xml", roots=("robot",))
@checked
def load_urdf(
    path: str | os.PathLike[str],
    *,
    base: Base = "fixed",
    q0: Mapping[str, Any] | None = None,
    loops: str | os.PathLike[str] | None = None,
    lock: Sequence[str] = (),
    mimic: MimicOption = "couple",
    inertia: InertiaOption = "check",
    keep_fixed: bool = False,
    gravity: Vector = GRAVITY,
    ignore: Sequence[str] = (),
    controls: Mapping[str, Any] | None = None,
    meshes: MeshOption = "draw",
    search: Sequence[str | os.PathLike[str]] = (),
) -> Robot:
    """Read a robot from a URDF file.

    Each moving link becomes a body with the frame of the link. Links that are fixed to it are merged into it; their
    points and frames are available by ``robot.link(name)``. Visuals and limits are stored; limits are used only for the
    choice of a position with closed loops.

    Parameters
    ----------
    path
        The file. Meshes are read when the model is drawn.
    base
        ``"fixed"``: the root link is the ground. ``"floating"``: it is a body that moves freely; its motion is named
        ``base``.
    q0
        Initial coordinates of joints by name: angle [rad], displacement [m]; for a floating joint [r, p], seven
        numbers. The others start at zero. A planar joint ``j`` has the three motions ``j.x``, ``j.y`` and ``j.angle``.
    loops
        A YAML or JSON file with further ``joints`` and ``forces`` between links, in the form of a model file; or with
        pairs of frames that coincide (``closed_loop``), in the form of ``example-parallel-robots``.
    lock
        Joints that are locked in their initial position.
    mimic
        Joints that follow another: ``"couple"`` them, take them as ``"free"``, or ``"lock"`` them as well.
    inertia
        ``"check"`` refuses tensors that no distribution of mass has; ``"given"`` accepts them unchanged.
    keep_fixed
        Import fixed links with mass as separate bodies with a fixed joint.
    gravity
        In global axes [m/s²].
    ignore
        ``["dynamics"]`` leaves out damping and dry friction of joints, ``["actuators"]`` the motors of transmissions.
    controls
        Torques of the motors of simple transmissions by name: a number, or a formula of the time, ``"0.3*sin(2*t)"``.
        The joint has this torque times the reduction. The others are zero.
    meshes
        ``"ignore"`` leaves out visuals that are meshes.
    search
        Folders in which ``package://`` names and meshes are searched, besides those near the file and in
        ``ROS_PACKAGE_PATH`` and ``AMENT_PREFIX_PATH``.

    Returns
    -------
    Robot
        A `Model` that also knows its links, limits and joint space.

    Raises
    ------
    ModelError
        For anything that is wrong, in one message with file, line, part and remedy.
    """
    description = describe(Path(path), vector(gravity, "gravity", "Give three numbers in m/s²."))
    options = ImportOptions(
        base, q0 or {}, lock, mimic, inertia, keep_fixed, ignore, controls or {}, meshes, search
    )
    description, side_file = with_frame_pairs(description, loops)
    return with_open_loops_noted(close(build(description, options), side_file), description.links)
