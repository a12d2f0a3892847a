"""The force and torque of a joint or driver on its body j. Joint reactions of Eq. (1), with its sign."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array, cross
from ...elements.evaluation import element_from, partition
from ...euler import A, E
from ...model.coordinates import POSITION
from ...model.expansion.marker import Marker
from ..structure.population import GROUND, firsts, local


class Wrench(NamedTuple):
    """The action of a joint on its body j, in global axes.

    Attributes
    ----------
    point : where, the joint's point on body j (3,) [m]
    force : (3,) [N]
    torque : about that point (3,) [N m]
    axes : the joint's axes f, g, h on body i, as columns (3, 3)
    """

    point: Array
    force: Array
    torque: Array
    axes: Array


def wrench(system: Any, marker: Marker, rows: Array, q: Array, lam: Array, t: float) -> Wrench:
    """The contribution of some rows of Φ_qᵀ lam as force and torque; on the ground, the opposite of that on body i."""
    for name, vector, size in (("q", q, system.nq), ("lam", lam, system.m)):
        if vector.shape != (size,):
            raise ValueError(
                f"{name} must have shape ({size},), got {vector.shape}. Pass an array of this shape."
            )
    share = np.zeros(system.m)
    share[rows] = np.asarray(lam, dtype=float)[rows]
    i, j = (_coordinates(system, body, q) for body in (marker.body_i, marker.body_j))
    point, axes = j[:3] + A(j[3:]) @ marker.s_j, A(i[3:]) @ marker.axes_i
    if marker.coupled:
        return Wrench(point, *_about(j, -_of_coupling(system, marker.body_j, rows, q, share), point), axes)
    Q = -system.Phi_qT_lam(q, share, t)
    if marker.body_j in system.bodies:
        force, torque = _about(j, Q[system.coordinates_of(marker.body_j)], point)
    else:
        force, torque = (-x for x in _about(i, Q[system.coordinates_of(marker.body_i)], point))
    return Wrench(point, force, torque, axes)


def _of_coupling(system: Any, body: str, rows: Array, q: Array, lam: Array) -> Array:
    """Φ_qᵀ lam (7,) of a coupling on a body, also on the ground, through all joints that it couples."""
    found, place = np.zeros_like(GROUND), system.coordinates_of(body).start if body in system.bodies else -1
    parts = found[:POSITION], found[POSITION:]
    for p in system.populations:
        for k in np.flatnonzero(np.isin(p.rows, rows)).tolist() if p.kind.rows else ():
            at, own = p.at + k * p.kind.size(), p.rows[k] + np.arange(p.kind.rows)
            element: Any = element_from(p.kind, system.b[at : at + p.kind.size()], system.b)
            blocks = element.Phi_qT_lam(partition(p.kind, local(p, k, q, GROUND)), lam[own])
            for first, blocks_there in zip(firsts(p, k), p.kind.by_owner(blocks), strict=True):
                for part, block in zip(parts, blocks_there if first == place else (), strict=False):
                    if block is not None:
                        part += block
    return found


def _coordinates(system: Any, body: str, q: Array) -> Array:
    return np.asarray(q)[system.coordinates_of(body)] if body in system.bodies else GROUND


def _about(x: Array, Q: Array, point: Array) -> tuple[Array, Array]:
    """Force Q_r; torque about the origin n = A n', n' = ½ G Q_p, that is ½ E Q_p; moved to a point."""
    force = Q[:3]
    return force, 0.5 * E(x[3:]) @ Q[3:] - cross(point - x[:3], force)
