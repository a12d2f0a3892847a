"""``load_mjcf``: from an MJCF file to a model, by way of the ``mujoco`` package."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...model.checks.arguments import checked
from ...model.quantity import triple
from ..by_ending import importer
from ..loops import close
from ..robot import Description, ImportOptions, Robot, build
from ..robot.options import Base, InertiaOption, MeshOption, MimicOption
from .base import with_base
from .bodies import edges_of, links_of, visuals_of, zeros_of
from .compiled import compiled
from .flags import disabled
from .keyframes import keyframes_of
from .left_out import notes
from .loads.actuators import actuators_of
from .loads.contacts import contacts_of
from .loads.fluid import fluid_forces
from .loads.joint_dynamics import dynamics_of
from .loads.lifted import lifted_by
from .loads.limits import limits_of, stops_of
from .loads.tendons import tendons_of
from .loops import closing_parts, equalities_of, mimics_of
from .sensors import sensors_of

UNNAMED = "MuJoCo Model"  # MuJoCo's name of a model without one


@importer(".xml", ".mjcf", roots=("mujoco", "mujocoinclude"))
@checked
def load_mjcf(
    path: str | os.PathLike[str],
    *,
    base: Base = "file",
    q0: Mapping[str, Any] | None = None,
    loops: str | os.PathLike[str] | None = None,
    lock: Sequence[str] = (),
    mimic: MimicOption = "couple",
    inertia: InertiaOption = "check",
    keep_fixed: bool = False,
    ignore: Sequence[str] = (),
    controls: Mapping[str, Any] | None = None,
    meshes: MeshOption = "draw",
    search: Sequence[str | os.PathLike[str]] = (),
) -> Robot:
    """Read a model from an MJCF file: bodies, joints with springs, dampers, dry friction and armature, gravity, loops.

    The world is the ground. Several joints of one body become one joint with the same degrees of freedom, if there is
    one and none of them has a force: two crossed hinges a universal joint, three a spherical one, two slides and a
    hinge a planar one. Otherwise each becomes a separate joint, with massless frames between them.

    Parameters
    ----------
    path
        The file; the package ``mujoco`` reads it, with its includes and meshes.
    base
        ``"file"``: as in the file. ``"fixed"``: bodies with a free joint are fixed in their position. ``"floating"``:
        without a free joint, the first body of the world that has no joint moves freely; the motion is named ``base``.
    q0
        Initial coordinates of joints by name, relative to the pose of the file: angle [rad], displacement [m]; for a
        ball four Euler parameters; for a free body [r, p], by default as in the file.
    loops, lock, mimic, inertia, keep_fixed, meshes, search
        As in `sarrus.load_urdf`. Meshes are searched next to the file or in its ``meshdir``, then in ``search``.
    ignore
        Elements to leave out although they change the motion. Not supported are "actuators" (delays, motors with
        states), "equalities" (of flexible bodies, of long tendons), "flex", "joints" (nonlinear springs), "tendons"
        (springs that yield) and "plugins"; "dynamics" leaves out springs, dampers, friction and armature of joints,
        "limits" their stops, "contacts" those of planes, "fluid" the forces of a fluid.
    controls
        Controls of actuators by name: a number, or a formula of the time, ``"0.3*sin(2*t)"``. The others are zero. They
        are inputs of the model, called like the actuators.

    Returns
    -------
    Robot
        Its ``notes`` list what was left out: contact, sensors, ...

    Raises
    ------
    ModelError
        For anything that is wrong or not supported.
    ImportError
        If ``mujoco`` is not installed.
    """
    read, missing = compiled(Path(path), search)
    given: Base = "file" if base == "floating" else base
    robot = build(
        with_base(_description(read, Path(path), ignore), base),
        ImportOptions(
            given, q0 or {}, lock, mimic, inertia, keep_fixed, ignore, controls or {}, meshes, search
        ),
    )
    between = [*closing_parts(read, robot), *(() if "contacts" in ignore else contacts_of(read, robot))]
    robot = robot.adding(*(part for part, _ in between))
    fluid = () if "fluid" in ignore else fluid_forces(read, robot)
    robot = robot.adding(*fluid).loaded_by({part.name: ends for part, ends in between})
    robot = replace(robot, keyframes=keyframes_of(read), notes=(*robot.notes, *missing))
    return close(robot, loops)


def _description(read: Any, path: Path, ignore: Sequence[str]) -> Description:
    links = links_of(read)
    return Description(
        name=_name(read) or path.stem,
        file=str(path),
        links=links,
        edges=edges_of(read),
        root=next(iter(links)),
        gravity=(0.0, 0.0, 0.0) if disabled(read, "GRAVITY") else triple(read.opt.gravity),
        limits=limits_of(read),
        mimics=mimics_of(read),
        dynamics=dynamics_of(read),
        stops={} if "limits" in ignore else stops_of(read),
        tendons={} if "tendons" in ignore else tendons_of(read, "limits" not in ignore),
        equalities=equalities_of(read),
        actuators=actuators_of(read),
        lifted=lifted_by(read),
        sensors=sensors_of(read),
        visuals=list(visuals_of(read)),
        notes=notes(read, ignore, str(path)),
        zero=zeros_of(read),
    )


def _name(read: Any) -> str:
    """Return the attribute ``model`` of the file, which begins the names; empty if the file has none."""
    name = str(read.names.partition(b"\0")[0].decode()).strip()
    return "" if name == UNNAMED else name
