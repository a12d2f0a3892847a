"""The choice of independent coordinates: those of joints, and those of bodies where these are not enough."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...algebra import Array
from ...elements import Normalization
from ...outputs.output import short
from ...system import System
from ...system.cached import once_alike
from ..equations.length import units
from ..equations.nullspace import NullSpace, pivoted_rows
from ..equations.states_at_rest import without_states


def of_joints(system: System, q: Array) -> tuple[str, ...]:
    """Names of all coordinates of joints, and of six of a body of each group that no joint connects with the ground.

    These are the position of the first body of the group, and its Euler parameters without the largest.
    """
    names, bodies, layout = list(system.joint_coordinates.names), _of_bodies(system), system.layout
    for body in _floating(system):
        parameters = layout.rotations[body]
        largest_one = parameters[np.argmax(abs(q[parameters]))]
        names += [bodies[place] for place in (*layout.positions[body], *parameters) if place != largest_one]
    return tuple(names)


@once_alike
def _floating(system: System) -> tuple[int, ...]:
    """The number of the first body of each group of bodies that no constraint connects with the ground."""
    # Bodies come before the blocks of first-order states, which connect nothing.
    count, layout = len(system.bodies), system.layout
    nodes, members, elements = count + 1, [np.array([count])], [np.array([count])]
    for p in system.populations:
        if p.kind.rows and p.kind is not Normalization and p.count:
            ends = layout.owner_of[p.bodies]
            ground = np.full((p.count, 1), count)
            every = np.hstack((ends, ground)) if -1 in p.variant.slots else ends
            numbers = np.broadcast_to(nodes + np.arange(p.count)[:, None], every.shape)
            inside = (every < count) | (np.arange(every.shape[1]) == ends.shape[1])
            members.append(every[inside])
            elements.append(numbers[inside])
            nodes += p.count
    row, column = np.concatenate(members), np.concatenate(elements)
    graph = coo_array((np.ones(len(row)), (row, column)), shape=(nodes, nodes))
    groups = connected_components(graph, directed=False)[1]
    firsts = np.unique(groups[:count], return_index=True)[1]
    return tuple(int(first) for first in np.sort(firsts) if groups[first] != groups[count])


def _of_bodies(system: System) -> list[str]:
    """Names of the coordinates of all bodies as outputs."""
    return [short(name) for name in system.coordinate_names[: system.moving]]


def chosen(system: System, q: Array, t: float, b: Array) -> tuple[str, ...]:
    """Names of independent coordinates at a position: of joints as far as they are independent, then of bodies."""
    J, joints = system.Phi_q(q, t, b=b), system.joint_coordinates
    scale = units(system, q, J)
    space = NullSpace(J, scale)
    Z, _ = without_states(system, space.Z, space.share)
    bodies = _of_bodies(system)
    gradients = (
        joints.Phi_q(q).toarray() if joints.m else np.zeros((0, system.nq)),
        np.eye(len(bodies), system.nq),
    )
    chosen_names = list[str]()
    Z = np.linalg.qr(Z / scale[:, None])[0] if Z.shape[1] else Z
    for names, rows in zip((joints.names, bodies), gradients, strict=True):
        along = rows * scale @ Z
        best = pivoted_rows(along, np.linalg.norm(rows * scale, axis=1))
        chosen_names += [names[k] for k in best]
        if len(best):
            Z = Z @ np.linalg.svd(along[best])[2][len(best) :].T
    return tuple(chosen_names)
