"""Equalities of an MJCF model: connect and weld are joints that close loops, joint is one that follows another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model import Fixed, Joint, Spherical
from ...model.errors import ModelError
from ...model.geometry.motion import unit
from ...model.geometry.rotation import matrix
from ...model.quantity import Array, Vector
from ...model.show import quote
from ..robot import Mimic, Robot
from ..robot.description import legal
from .bodies import joint_names, names_of
from .compiled import mujoco

CONNECT, WELD, JOINT = range(3)  # mjtEq
BODY = 1  # mjtObj


def closing_joints(compiled: Any, robot: Robot) -> Iterator[Joint]:
    """Yield a joint for every active connect and weld."""
    taken = {part.name for parts in robot.sections().values() for part in parts}
    active = [k for k in _active(compiled) if compiled.eq_type[k] != JOINT]
    names = legal([_name(compiled, k) for k in active], taken, "_loop")
    for k, name in zip(active, names.values(), strict=True):
        yield (
            _spherical(compiled, k, name, robot)
            if _is(compiled, k, CONNECT)
            else _fixed(compiled, k, name, robot)
        )


def mimics_of(compiled: Any, file: str) -> dict[str, Mimic]:
    """Return the joints that follow another, linearly.

    Raises
    ------
    ModelError
        For an equality that is none of connect, weld and a linear joint.
    """
    names, found = joint_names(compiled), {}
    for k in _active(compiled):
        _refuse_others(compiled, k, file)
        if _is(compiled, k, JOINT):
            offset, multiplier = (float(x) for x in compiled.eq_data[k, :2])
            found[names[compiled.eq_obj1id[k]]] = Mimic(names[compiled.eq_obj2id[k]], multiplier, offset)
    return found


def _refuse_others(compiled: Any, k: int, file: str) -> None:
    kind, message = int(compiled.eq_type[k]), ""
    if kind > JOINT:
        message = "is neither connect, weld nor joint. Take it out of the file."
    elif kind == JOINT and compiled.eq_obj2id[k] < 0:
        message = "holds one joint. Take it out of the file and use lock."
    elif kind == JOINT and any(compiled.eq_data[k, 2:5]):
        message = "is no linear relation of two joints. Take it out of the file."
    if message:
        raise ModelError(message, part=f"equality {quote(_name(compiled, k))}", where=file)


def _spherical(compiled: Any, k: int, name: str, robot: Robot) -> Joint:
    data = compiled.eq_data[k]
    (link_i, s_i), (link_j, s_j) = _ends(compiled, k, data[0:3], data[3:6])
    return Spherical(name, point_i=robot.point(link_i, s_i), point_j=robot.point(link_j, s_j))


def _fixed(compiled: Any, k: int, name: str, robot: Robot) -> Joint:
    data, sites = compiled.eq_data[k], compiled.eq_objtype[k] != BODY
    (link_i, s_i), (link_j, s_j) = _ends(compiled, k, data[3:6], data[0:3])
    A_i = matrix(unit(_site_quat(compiled, k, 1) if sites else data[6:10]))
    A_j = matrix(unit(_site_quat(compiled, k, 2))) if sites else np.eye(3)
    frame_i = robot.frame(link_i, s_i, x=A_i[:, 0], z=A_i[:, 2])
    return Fixed(name, frame_i=frame_i, frame_j=robot.frame(link_j, s_j, x=A_j[:, 0], z=A_j[:, 2]))


def _ends(compiled: Any, k: int, s_i: Array, s_j: Array) -> list[tuple[str, Vector]]:
    """Return body name and point in body axes of both ends."""
    names, ids = names_of(compiled), (int(compiled.eq_obj1id[k]), int(compiled.eq_obj2id[k]))
    if compiled.eq_objtype[k] == BODY:
        return [(names[n], np.array(s)) for n, s in zip(ids, (s_i, s_j), strict=True)]
    return [(names[compiled.site_bodyid[n]], np.array(compiled.site_pos[n])) for n in ids]


def _site_quat(compiled: Any, k: int, end: int) -> Array:
    return np.array(compiled.site_quat[int((compiled.eq_obj1id if end == 1 else compiled.eq_obj2id)[k])])


def _active(compiled: Any) -> list[int]:
    return [k for k in range(compiled.neq) if compiled.eq_active0[k]]


def _is(compiled: Any, k: int, kind: int) -> bool:
    return int(compiled.eq_type[k]) == kind


def _name(compiled: Any, k: int) -> str:
    given = mujoco().mj_id2name(compiled, mujoco().mjtObj.mjOBJ_EQUALITY, k)
    return given or f"{['connect', 'weld', 'joint'][min(int(compiled.eq_type[k]), JOINT)]}{k}"
