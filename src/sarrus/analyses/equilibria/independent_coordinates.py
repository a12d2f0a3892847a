"""Independent coordinates of a mechanism: those that are named, or coordinates of joints and bodies that are chosen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import qr

from ...algebra import Array
from ...linalg.rank import DEPENDENT
from ...model.coordinates import WIDTH
from ...outputs.measure import placed_of
from ...outputs.output import Level, Output, find_output, outputs_of
from ...system import System
from ...system.operators.joints import JointCoordinates
from ..equations.length import lever, units
from ..equations.nullspace import NullSpace
from ..equations.states_at_rest import without_states

WHERE = "an independent coordinate"


class Independent(NamedTuple):
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
        at = self.row >= 0
        c, rates = q[self.place], v[self.place]
        if self.measured.m:
            c[at], rates[at] = self.measured.Phi(q)[self.row[at]], self.measured.Phi_q_xi(q, v)[self.row[at]]
        return c, rates

    def rate_names(self) -> tuple[str, ...]:
        """Names of their rates."""
        return tuple(f"{one.name}.rate" if one.place is None else f"d({one.name})/dt" for one in self.outputs)


def of_names(system: System, names: Sequence[str]) -> Independent:
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
    return Independent(every, measured, row, place)


def chosen(system: System, q: Array, t: float, b: Array) -> list[str]:
    """Names of independent coordinates at a position: of joints as far as they are independent, then of bodies."""
    J, joints = system.Phi_q(q, t, b=b), list(system.joint_coordinates.names)
    length = lever(system, q, J)
    space = NullSpace(J, length)
    Z, _ = without_states(system, space.Z, space.share)
    bodies = [one.name for one in outputs_of(system) if one.place is not None and one.place < system.moving]
    found, scale = list[str](), units(system.nq, length)
    Z = np.linalg.qr(Z / scale[:, None])[0] if Z.shape[1] else Z
    for names in (joints, bodies):
        rows = of_names(system, names).gradients(q) * scale @ Z
        best = _largest(rows)
        found += [names[k] for k in sorted(best)]
        if len(best):
            Z = Z @ np.linalg.svd(rows[best])[2][len(best) :].T
    return found


def _largest(rows: Array) -> Any:
    """Places of as many independent rows as there are, large ones first."""
    if not rows.size:
        return np.zeros(0, dtype=np.int64)
    triangle, order = qr(rows.T, mode="r", pivoting=True)
    sizes = abs(np.diag(triangle))
    return order[: np.count_nonzero(sizes > DEPENDENT * max(sizes.max(initial=0.0), 1.0))]
