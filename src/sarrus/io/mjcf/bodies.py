"""The bodies and joints of an MJCF model as links and edges of a tree."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...model.geometry.motion import Ball, Free, Motion, Slide, Turn, compose, pose, relative, unit
from ...model.geometry.pose import GROUND_POSE, Pose
from ..robot import Edge, Inertia, Link, Visual
from .compiled import Shape, name_of

FREE, BALL, SLIDE, HINGE = range(4)  # mjtJoint
SHAPES = {one.value: one.name.lower() for one in Shape if one is not Shape.PLANE}


def links_of(compiled: Any) -> dict[str, Link]:
    """Return the bodies by name, the world first."""
    names = names_of(compiled)
    return {name: Link(name, _inertial(compiled, k)) for k, name in enumerate(names)}


def names_of(compiled: Any) -> list[str]:
    """Return the names of the bodies."""
    return [name_of(compiled, "body", k) for k in range(compiled.nbody)]


def edges_of(compiled: Any) -> list[Edge]:
    """Return how each body hangs on its parent; MuJoCo lists parents first."""
    names = names_of(compiled)
    return [_edge(compiled, k, names) for k in range(1, compiled.nbody)]


def visuals_of(compiled: Any) -> Iterator[Visual]:
    """Yield the shapes; the pose of a mesh is that of the axes of its file."""
    names = names_of(compiled)
    for k in range(compiled.ngeom):
        if int(compiled.geom_type[k]) in SHAPES:
            yield _visual(compiled, k, names[compiled.geom_bodyid[k]])


def placed(r: Any, p: Any) -> Pose:
    """Return the pose of MuJoCo's position and quaternion, which has its scalar first too."""
    return pose(np.array(r, dtype=float), unit(np.array(p, dtype=float)))


def _edge(compiled: Any, k: int, names: list[str]) -> Edge:
    motions = motions_of(compiled, k)
    free = bool(motions) and motions[0].freedoms == 6
    where = GROUND_POSE if free else placed(compiled.body_pos[k], compiled.body_quat[k])
    joint = motions[0].name if motions else f"{names[k]}_weld"
    return Edge(joint, names[compiled.body_parentid[k]], names[k], where, motions)


def _inertial(compiled: Any, k: int) -> Inertia | None:
    mass, moments = float(compiled.body_mass[k]), np.diag(compiled.body_inertia[k])
    frame = placed(compiled.body_ipos[k], compiled.body_iquat[k])
    return Inertia(mass, np.zeros(3), moments).seen_from(frame) if mass else None


def _visual(compiled: Any, k: int, link: str) -> Visual:
    shape, pose = SHAPES[int(compiled.geom_type[k])], placed(compiled.geom_pos[k], compiled.geom_quat[k])
    color = tuple(float(x) for x in compiled.geom_rgba[k])
    if shape != "mesh":
        return Visual(link, shape, _size(shape, [float(x) for x in compiled.geom_size[k]]), pose, "", color)
    mesh = int(compiled.geom_dataid[k])
    moved = placed(
        compiled.mesh_pos[mesh], compiled.mesh_quat[mesh]
    )  # from the file's axes to the centred copy
    pose = compose(pose, relative(moved, GROUND_POSE))
    scale = tuple(float(factor) for factor in compiled.mesh_scale[mesh])
    return Visual(link, shape, scale, pose, _file(compiled, mesh), color)


def _size(shape: str, size: list[float]) -> tuple[float, ...]:
    """Return MuJoCo's halves of lengths as sizes of a `Visual`: sides, radius and length, or radii."""
    if shape == "box":
        return tuple(2 * half for half in size)
    return {"sphere": (size[0],), "ellipsoid": tuple(size)}.get(shape, (size[0], 2 * size[1]))


def _file(compiled: Any, mesh: int) -> str:
    """Return the path of a mesh, "" where the file has its vertices."""
    first = int(compiled.mesh_pathadr[mesh])
    if first < 0:
        return ""
    return str(Path(bytes(compiled.paths)[first:].split(b"\0")[0].decode()).resolve())


def motions_of(compiled: Any, body: int) -> tuple[Motion, ...]:
    """Return the motions of a body in its parent, in their order."""
    first, count = int(compiled.body_jntadr[body]), int(compiled.body_jntnum[body])
    return tuple(_motion(compiled, k) for k in range(first, first + count))


def joint_names(compiled: Any) -> list[str]:
    """Return the names of the joints."""
    return [name_of(compiled, "joint", k) for k in range(compiled.njnt)]


def zeros_of(compiled: Any) -> dict[str, list[float]]:
    """Return where free bodies stand in the file: [r, p] by joint name."""
    names = joint_names(compiled)
    free = [k for k in range(compiled.njnt) if compiled.jnt_type[k] == FREE]
    places = {k: int(compiled.jnt_qposadr[k]) for k in free}
    return {names[k]: [float(x) for x in compiled.qpos0[at : at + 7]] for k, at in places.items()}


def _motion(compiled: Any, k: int) -> Motion:
    name, kind = name_of(compiled, "joint", k), int(compiled.jnt_type[k])
    axis, point = np.array(compiled.jnt_axis[k]), np.array(compiled.jnt_pos[k])
    if kind == FREE:
        return Free(name)
    if kind == BALL:
        return Ball(name, point)
    return Slide(name, axis) if kind == SLIDE else Turn(name, axis, point)
