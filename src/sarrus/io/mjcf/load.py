"""``load_mjcf``: from an MJCF file to a model, by way of the ``mujoco`` package.

Forces of the fluid around the bodies of an MJCF model, by their boxes of equal inertia or by their shapes.

On a body one of whose shapes has coefficients of lift (`fluidshape`), forces act on its shapes that have them, and not
on the box.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...model import BoxDrag, EllipsoidDrag, Force
from ...model.checks.arguments import checked
from ...model.geometry.motion import Free, pose, unit
from ...model.geometry.points import GROUND
from ...model.geometry.pose import GROUND_POSE
from ...model.quantity import Array, Vec3, triple
from ..by_ending import importer
from ..loops import close
from ..robot import Description, ImportOptions, Keyframe, Robot, activation_name, build
from ..robot.options import Base, InertiaOption, MeshOption, MimicOption, check_floating
from ..robot.tree.coordinates import BASE
from .bodies import BALL, edges_of, joint_names, links_of, names_of, placed, visuals_of, zeros_of
from .compiled import Shape, compiled, disabled, name_of, no_passive_forces
from .left_out import notes
from .loads.actuators import actuators_of, control_of, count, lifted_by
from .loads.contacts import contacts_of, frame_at
from .loads.joints import dynamics_of, limits_of, stops_of
from .loads.tendons import tendons_of
from .loops import closing_parts, equalities_of, mimics_of
from .sensors import sensors_of

UNNAMED = "MuJoCo Model"  # MuJoCo's name of a model without one
WIDTHS = ((7, 6), (4, 3), (1, 1), (1, 1))  # of coordinates and velocities, by mjtJoint
SMALLEST = 1e-15  # MuJoCo's least moment of inertia


def fluid_forces(compiled: Any, robot: Robot) -> Iterator[Force]:
    """Yield the forces on all moving bodies with mass: on shapes with coefficients of lift, or else on the box."""
    if not _has_fluid(compiled):
        return
    links = names_of(compiled)
    parts = list[tuple[str, Callable[[str], Force]]]()
    law: dict[str, Any] = {"density": float(compiled.opt.density), "viscosity": float(compiled.opt.viscosity)}
    law["wind"] = triple(compiled.opt.wind)
    for k, link in enumerate(links):
        if not compiled.body_mass[k] or link not in robot.links or robot.link(link).body.name == GROUND:
            continue
        first, count = compiled.body_geomadr[k], compiled.body_geomnum[k]
        shapes = [n for n in range(first, first + count) if compiled.geom_fluid[n, 0]]
        for n in shapes:
            place = placed(compiled.geom_pos[n], compiled.geom_quat[n])
            fields: dict[str, Any] = {
                "frame": frame_at(robot, link, place),
                "semiaxes": _semiaxes(compiled, n),
            }
            fields |= _coefficients(compiled, n)
            parts.append((f"{name_of(compiled, 'geom', n)}_fluid", partial(EllipsoidDrag, **fields, **law)))
        if not shapes:
            place = placed(compiled.body_ipos[k], compiled.body_iquat[k])
            box = triple(_box(compiled.body_mass[k], compiled.body_inertia[k]))
            fields = {"frame": frame_at(robot, link, place), "box": box}
            parts.append((f"{link}_fluid", partial(BoxDrag, **fields, **law)))
    names = robot.free_names([name for name, _ in parts], "_force")
    yield from (force(name) for name, (_, force) in zip(names, parts, strict=True))


def _has_fluid(compiled: Any) -> bool:
    some = compiled.opt.density > 0 or compiled.opt.viscosity > 0
    return bool(some and compiled.nv and not no_passive_forces(compiled))


def _semiaxes(compiled: Any, shape: int) -> Vec3:
    """Return the semi-axes of MuJoCo's ellipsoid for a shape."""
    a, b, c = (float(value) for value in compiled.geom_size[shape])
    kind = compiled.geom_type[shape]
    if kind == Shape.SPHERE:
        return a, a, a
    if kind == Shape.CAPSULE:
        return a, a, b + a
    return (a, a, b) if kind == Shape.CYLINDER else (a, b, c)


def _coefficients(compiled: Any, shape: int) -> dict[str, Any]:
    """Return the coefficients of drag, lift and added mass of a shape."""
    _, *given = (float(value) for value in compiled.geom_fluid[shape])
    names = "blunt_drag", "slender_drag", "angular_drag", "kutta_lift", "magnus_lift"
    density = float(compiled.opt.density)
    virtual = [density * value for value in given[len(names) :]]
    return dict(zip(names, given, strict=False)) | {"added_mass": virtual[:3], "added_inertia": virtual[3:]}


def _box(mass: Any, moments: Any) -> Array:
    """Return the sides of the box with a mass and moments of inertia."""
    sums = moments.sum() - 2 * moments
    return np.asarray(np.sqrt(np.maximum(sums, SMALLEST) / mass * 6))


def keyframes_of(compiled: Any) -> dict[str, Keyframe]:
    """Return the keyframes by name."""
    return {name_of(compiled, "key", k): _keyframe(compiled, k) for k in range(compiled.nkey)}


def _keyframe(compiled: Any, k: int) -> Keyframe:
    values, rates = dict[str, Any](), dict[str, Any]()
    for joint, name in enumerate(joint_names(compiled)):
        kind = int(compiled.jnt_type[joint])
        at, first = int(compiled.jnt_qposadr[joint]), int(compiled.jnt_dofadr[joint])
        width, freedoms = WIDTHS[kind]
        start = compiled.qpos0[at : at + width] if kind > BALL else np.zeros(width)
        values[name] = np.array(compiled.key_qpos[k, at : at + width] - start)
        rates[name] = np.array(compiled.key_qvel[k, first : first + freedoms])
    return Keyframe(values, rates, *_of_actuators(compiled, k), float(compiled.key_time[k]))


def _of_actuators(compiled: Any, k: int) -> tuple[dict[str, float], dict[str, float]]:
    """Return activations and controls."""
    states, controls = dict[str, float](), dict[str, float]()
    for n in range(count(compiled)):
        name, at = name_of(compiled, "actuator", n), int(compiled.actuator_actadr[n])
        if at >= 0:
            states[activation_name(name)] = float(compiled.key_act[k, at])
        controls[name] = float(compiled.key_ctrl[k, control_of(compiled, n)])
    return states, controls


def with_base(description: Description, base: Base) -> Description:
    """Return a description whose free bodies are fixed, or whose first fixed body is free."""
    edges, zero = list(description.edges), dict(description.zero)
    free = [n for n, edge in enumerate(edges) if edge.motions and isinstance(edge.motions[0], Free)]
    if base == "fixed":
        for n in free:
            values: Array = np.array(zero.pop(edges[n].motions[0].name))
            edges[n] = replace(edges[n], pose=pose(values[:3], unit(values[3:])), motions=())
    roots = [n for n, edge in enumerate(edges) if edge.parent == description.root and not edge.motions]
    if base == "floating" and not free and roots:
        there = edges[roots[0]].pose
        zero[BASE] = [*map(float, there.r), *map(float, there.p)]
        edges[roots[0]] = replace(edges[roots[0]], name=BASE, pose=GROUND_POSE, motions=(Free(BASE),))
    check_floating(base, edges)
    return replace(description, edges=edges, zero=zero)


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
