"""Equalities of an MJCF model: connect and weld are joints that close loops, joint makes one follow another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model import Fixed, Force, Joint, Spherical
from ...model.geometry.motion import unit
from ...model.geometry.rotation import matrix
from ...model.quantity import Array, Vector
from ..robot import Mimic, Robot, TendonEquality
from ..robot.interaction import Ends
from .bodies import joint_names
from .compiled import Object, disabled, mujoco, name_of
from .loads import tendons
from .loads.compliance import has_target, springs_in_place

CONNECT, WELD, JOINT, TENDON = range(4)  # mjtEq


def closing_parts(compiled: Any, robot: Robot) -> Iterator[tuple[Joint | Force, Ends]]:
    """Yield a joint and its links for every active connect and weld of two bodies, springs for one with a target.

    Within one body, MuJoCo's has no effect either.
    """
    loops = [k for k in active_equalities(compiled) if int(compiled.eq_type[k]) <= WELD]
    loops = [k for k in loops if not _is_within_a_body(compiled, k, robot)]
    names = robot.free_names([_name(compiled, k) for k in loops], "_loop")
    for k, name in zip(loops, names, strict=True):
        make = _spherical if _is(compiled, k, CONNECT) or not _holds_rotation(compiled, k) else _fixed
        i, j = (link for link, _ in _ends(compiled, k, np.zeros(3), np.zeros(3)))
        joint, bodies = make(compiled, k, name, robot), _bodies(compiled, k)
        held = has_target(compiled, bodies)
        parts = springs_in_place(compiled, k, joint, bodies) if held else [joint]
        yield from ((part, (i, j)) for part in parts)


def mimics_of(compiled: Any) -> dict[str, Mimic]:
    """Return the joints that follow another, by a polynomial, or are held at a value."""
    names, mimics = joint_names(compiled), {}
    for k in active_equalities(compiled):
        if _is(compiled, k, JOINT) and is_supported(compiled, k):
            offset, multiplier, *higher = (float(x) for x in compiled.eq_data[k, :5])
            leader, follower = int(compiled.eq_obj2id[k]), int(compiled.eq_obj1id[k])
            alone = leader < 0  # it is held at a value
            mimics[names[follower]] = (
                Mimic("", 0.0, offset) if alone else Mimic(names[leader], multiplier, offset, higher)
            )
    return mimics


def equalities_of(compiled: Any) -> dict[str, TendonEquality]:
    """Return the supported equalities of tendons."""
    active = (k for k in active_equalities(compiled) if _is(compiled, k, TENDON))
    return {_name(compiled, k): _of_tendons(compiled, k) for k in active if is_supported(compiled, k)}


def _of_tendons(compiled: Any, k: int) -> TendonEquality:
    first, second = int(compiled.eq_obj1id[k]), int(compiled.eq_obj2id[k])
    other = None if second < 0 else tendons.path_of(compiled, second)
    factors = tuple(float(x) for x in compiled.eq_data[k, : 1 if other is None else 5])
    start = float(compiled.tendon_length0[first])
    return TendonEquality(tendons.path_of(compiled, first), start, factors, other)


def active_equalities(compiled: Any) -> list[int]:
    """Return the equalities that hold from the start."""
    switched_off = disabled(compiled, "EQUALITY")
    return [k for k in range(compiled.neq) if compiled.eq_active0[k] and not switched_off]


def is_supported(compiled: Any, k: int) -> bool:
    """Return whether an equality is a connect, a weld, of joints, of tendons over joints, or of one like a rod."""
    if not _is(compiled, k, TENDON):
        return int(compiled.eq_type[k]) <= JOINT
    first, second = int(compiled.eq_obj1id[k]), int(compiled.eq_obj2id[k])
    ends = [tendon for tendon in (first, second) if tendon >= 0]
    paths = [tendons.path_of(compiled, tendon) for tendon in ends]
    if any(path.points for path in paths):
        return (
            len(paths) == 1 and len(paths[0].points) == 2 and not paths[0].around and paths[0].factors[0] == 1
        )
    return True


def _holds_rotation(compiled: Any, k: int) -> bool:
    """Return whether a weld holds the rotation, too: MuJoCo multiplies its equations by ``torquescale``."""
    return bool(compiled.eq_data[k, 10] != 0)


def _spherical(compiled: Any, k: int, name: str, robot: Robot) -> Joint:
    data = compiled.eq_data[k]
    first, second = (data[0:3], data[3:6]) if _is(compiled, k, CONNECT) else (data[3:6], data[0:3])
    (link_i, s_i), (link_j, s_j) = _ends(compiled, k, first, second)
    return Spherical(name, point_i=robot.point(link_i, s_i), point_j=robot.point(link_j, s_j))


def _fixed(compiled: Any, k: int, name: str, robot: Robot) -> Joint:
    data, sites = compiled.eq_data[k], compiled.eq_objtype[k] != Object.BODY
    (link_i, s_i), (link_j, s_j) = _ends(compiled, k, data[3:6], data[0:3])
    A_i = matrix(unit(_site_quat(compiled, k, 1) if sites else data[6:10]))
    A_j = matrix(unit(_site_quat(compiled, k, 2))) if sites else np.eye(3)
    frame_i = robot.frame(link_i, s_i, x=A_i[:, 0], z=A_i[:, 2])
    return Fixed(name, frame_i=frame_i, frame_j=robot.frame(link_j, s_j, x=A_j[:, 0], z=A_j[:, 2]))


def springs_of_targets(compiled: Any) -> int:
    """Return how many active equalities hold a body to one that a program moves."""
    some = (k for k in active_equalities(compiled) if int(compiled.eq_type[k]) <= WELD)
    return sum(has_target(compiled, _bodies(compiled, k)) for k in some)


def _bodies(compiled: Any, k: int) -> tuple[int, int]:
    ids = int(compiled.eq_obj1id[k]), int(compiled.eq_obj2id[k])
    if compiled.eq_objtype[k] == Object.BODY:
        return ids
    return int(compiled.site_bodyid[ids[0]]), int(compiled.site_bodyid[ids[1]])


def _ends(compiled: Any, k: int, s_i: Array, s_j: Array) -> list[tuple[str, Vector]]:
    """Return body name and point in body axes of both ends."""
    links = [name_of(compiled, "body", n) for n in _bodies(compiled, k)]
    if compiled.eq_objtype[k] == Object.BODY:
        return [(link, np.array(s)) for link, s in zip(links, (s_i, s_j), strict=True)]
    sites = (int(one[k]) for one in (compiled.eq_obj1id, compiled.eq_obj2id))
    return [(link, np.array(compiled.site_pos[n])) for link, n in zip(links, sites, strict=True)]


def _is_within_a_body(compiled: Any, k: int, robot: Robot) -> bool:
    links = [link for link, _ in _ends(compiled, k, np.zeros(3), np.zeros(3))]
    return robot.links.keys() >= {*links} and robot.link(links[0]).body is robot.link(links[1]).body


def _site_quat(compiled: Any, k: int, end: int) -> Array:
    return np.array(compiled.site_quat[int((compiled.eq_obj1id if end == 1 else compiled.eq_obj2id)[k])])


def _is(compiled: Any, k: int, kind: int) -> bool:
    return int(compiled.eq_type[k]) == kind


def _name(compiled: Any, k: int) -> str:
    name = mujoco().mj_id2name(compiled, mujoco().mjtObj.mjOBJ_EQUALITY, k)
    return name or f"{['connect', 'weld', 'joint', 'tendon'][min(int(compiled.eq_type[k]), TENDON)]}{k}"
