"""The force and torque with which a joint or driver acts on its body j. Joint reactions of Eq. (1), with its sign."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..algebra import Array
from ..euler import A, E
from ..model.marker import Marker

GROUND = np.array([0.0, 0, 0, 1, 0, 0, 0])


class Wrench(NamedTuple):
    """A joint's action on its body j, in global axes.

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
    """The share of some rows of Φ_qᵀ lam as force and torque; on the ground, the opposite of that on body i."""
    share = np.zeros(system.m)
    share[rows] = np.asarray(lam, dtype=float)[rows]
    Q = -system.Phi_qT_lam(q, share, t)
    i, j = (_coordinates(system, body, q) for body in (marker.body_i, marker.body_j))
    point = j[:3] + A(j[3:]) @ marker.s_j
    if marker.body_j in system.bodies:
        force, torque = _about(j, Q[system.coordinates_of(marker.body_j)], point)
    else:
        force, torque = (-x for x in _about(i, Q[system.coordinates_of(marker.body_i)], point))
    return Wrench(point, force, torque, A(i[3:]) @ marker.axes_i)


def _coordinates(system: Any, body: str, q: Array) -> Array:
    return np.asarray(q)[system.coordinates_of(body)] if body in system.bodies else GROUND


def _about(x: Array, Q: Array, point: Array) -> tuple[Array, Array]:
    """Force Q_r; torque about the origin n = A n', n' = ½ G Q_p, that is ½ E Q_p; moved to a point."""
    force = Q[:3]
    return force, 0.5 * E(x[3:]) @ Q[3:] - np.cross(point - x[:3], force)
