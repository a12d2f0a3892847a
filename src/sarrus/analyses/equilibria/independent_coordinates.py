"""Independent coordinates of a mechanism: those that are named, or coordinates of joints and bodies that are chosen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import qr
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...algebra import Array
from ...elements import Normalization
from ...linalg.rank import DEPENDENT
from ...model.coordinates import WIDTH
from ...outputs.measure import placed_of
from ...outputs.output import Level, Output, find_output, short
from ...system import System
from ...system.cached import once_alike
from ...system.operators.joints import JointCoordinates
from ..equations.length import lever, units
from ..equations.nullspace import NullSpace
from ..equations.states_at_rest import without_states

WHERE = "an independent coordinate"


class CoordinateSet(NamedTuple):
    """Coordinates c(q).

    Attributes
    ----------
    outputs : as outputs of the system
    measured : those that elements measure, with all derivatives
    row, place : (n,) row in `measured`, or -1 and the place in q
    """

    outputs: tuple[Output, ...]
    measured: JointCoordinates
    row: Array
    place: Array

    def gradients(self, q: Array) -> Array:
        """c_q (n, nq)."""
        found = np.zeros((len(self.row), len(q)))
        elements = self.measured.Phi_q(q).toarray() if self.measured.m else found
        for k, (row, place) in enumerate(zip(self.row, self.place, strict=True)):
            if row >= 0:
                found[k] = elements[row]
            else:
                found[k, place] = 1.0
        return found

    def values(self, q: Array, v: Array) -> tuple[Array, Array]:
        """c and ċ (n,)."""
        at, c, rates = self.row >= 0, q[self.place], v[self.place]
        of = self.measured
        if of.m:
            found, moved = np.zeros((2, of.m))
            of.group("Phi").run(of.b, 0.0, q, found)
            of.group("Phi_q_xi").run(of.b, 0.0, q, v, moved)
            c[at], rates[at] = found[self.row[at]], moved[self.row[at]]
        return c, rates

    def labels(self) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
        """Names of the coordinates, names of their rates, and units of the coordinates."""
        names = tuple(one.name for one in self.outputs)
        rates = tuple(
            f"{one.name}.rate" if one.place is None else f"d({one.name})/dt" for one in self.outputs
        )
        return names, rates, tuple(one.unit for one in self.outputs)


def of_names(system: System, names: Sequence[str]) -> CoordinateSet:
    """The coordinates of some names.

    Raises
    ------
    UnknownOutput
        If one is no output of the position, or no element measures it.
    """
    every = tuple(find_output(system, name, Level.POSITION, WHERE) for name in names)
    elements = [one for one in every if one.place is None]
    measured = JointCoordinates([placed_of(system, one, WHERE) for one in elements], system.nq // WIDTH)
    row = np.array([elements.index(one) if one.place is None else -1 for one in every], dtype=np.int64)
    place = np.array([one.place or 0 for one in every], dtype=np.int64)
    return CoordinateSet(every, measured, row, place)


def of_joints(system: System, q: Array) -> tuple[str, ...]:
    """Names of all coordinates of joints, and of six of a body of each group that no joint connects with the ground.

    These are the position of the first body of the group, and its Euler parameters without the largest.
    """
    names, bodies = list(system.joint_coordinates.names), _of_bodies(system)
    for body in _floating(system):
        parameters = range(body + 3, body + WIDTH)
        largest_one = max(parameters, key=lambda place: abs(q[place]))
        names += [bodies[place] for place in range(body, body + WIDTH) if place != largest_one]
    return tuple(names)


@once_alike
def _floating(system: System) -> tuple[int, ...]:
    """The first coordinates of the first body of each group of bodies that no constraint connects with the ground."""
    # Bodies come before the blocks of first-order states, which connect nothing.
    count = system.moving // WIDTH
    nodes, members, elements = count + 1, [np.array([count])], [np.array([count])]
    for one in system.populations:
        if one.kind.rows and one.kind is not Normalization and one.count:
            ends = one.bodies // WIDTH
            ground = np.full((one.count, 1), count)
            every = np.hstack((ends, ground)) if -1 in one.variant.slots else ends
            own = np.broadcast_to(nodes + np.arange(one.count)[:, None], every.shape)
            inside = (every < count) | (np.arange(every.shape[1]) == ends.shape[1])
            members.append(every[inside])
            elements.append(own[inside])
            nodes += one.count
    row, column = np.concatenate(members), np.concatenate(elements)
    graph = coo_array((np.ones(len(row)), (row, column)), shape=(nodes, nodes))
    groups = connected_components(graph, directed=False)[1]
    firsts = np.unique(groups[:count], return_index=True)[1]
    return tuple(WIDTH * int(first) for first in np.sort(firsts) if groups[first] != groups[count])


def _of_bodies(system: System) -> list[str]:
    """Names of the coordinates of all bodies as outputs."""
    return [short(name) for name in system.coordinate_names[: system.moving]]


def chosen(system: System, q: Array, t: float, b: Array) -> tuple[str, ...]:
    """Names of independent coordinates at a position: of joints as far as they are independent, then of bodies."""
    J, joints = system.Phi_q(q, t, b=b), system.joint_coordinates
    length = lever(system, q, J)
    space = NullSpace(J, length)
    Z, _ = without_states(system, space.Z, space.share)
    bodies = _of_bodies(system)
    gradients = (
        joints.Phi_q(q).toarray() if joints.m else np.zeros((0, system.nq)),
        np.eye(len(bodies), system.nq),
    )
    found, scale = list[str](), units(system.nq, length)
    Z = np.linalg.qr(Z / scale[:, None])[0] if Z.shape[1] else Z
    for names, rows in zip((joints.names, bodies), gradients, strict=True):
        along = rows * scale @ Z
        best = largest(along)
        found += [names[k] for k in best]
        if len(best):
            Z = Z @ np.linalg.svd(along[best])[2][len(best) :].T
    return tuple(found)


def largest(rows: Array) -> Array:
    """Places of as many independent rows as there are, those that are left largest, in rising order."""
    if not rows.size:
        return np.zeros(0, dtype=np.int64)
    triangle, order = qr(rows.T, mode="r", pivoting=True)
    sizes = abs(np.diag(triangle))
    return np.sort(order[: np.count_nonzero(sizes > DEPENDENT * sizes.max(initial=0.0))])
