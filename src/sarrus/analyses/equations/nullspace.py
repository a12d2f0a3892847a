"""A constraint Jacobian of any rank: the motions it leaves free and their inertia, the least change, multipliers."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import eigh, qr
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.rank import DEPENDENT, TOLERANCE, inverse_if_regular
from ...model import ModelError
from ...system import System
from .length import LEAST_LEVER, extent, units


class NullSpace:
    """Rank of J (m, n), its rows scaled to unit length. Dense: for up to about a thousand coordinates.

    By singular values, unless a QR decomposition shows that all rows are independent.

    Parameters
    ----------
    J : (m, n) sparse
    unit : of each coordinate (n,), a length for displacements, see `Layout.scales`
    tolerance : a singular value relative to the largest that counts as zero

    Attributes
    ----------
    rank : number of independent rows
    regular : whether all rows are, with all singular values above `rank.TOLERANCE`
    lengths : of the rows (m,), where displacements are measured in `length`
    Z : (n, n - rank) basis of the directions ξ with J ξ = 0, orthonormal where displacements are measured in `length`
    share : (n - rank, n) with share Z = I, zero for what `change` returns
    """

    def __init__(self, J: Any, unit: Array, tolerance: float = DEPENDENT) -> None:
        self._unit, (rows, self.lengths) = unit, scaled_rows(J, unit)
        basis, triangle = np.linalg.qr(rows.T, mode="complete")
        inverse = inverse_if_regular(triangle, max(tolerance, TOLERANCE))
        # first-order states, which have units of their own, are in no equation
        if inverse is not None and rows.any(axis=0).all():
            self.rank, self.regular, self._other_left, self._inverse = len(rows), True, rows[:, :0], inverse.T
        else:
            left, sizes, right = np.linalg.svd(rows, full_matrices=True)
            ratios, basis = sizes / (sizes.max(initial=0.0) or 1.0), right.T
            self.rank, regular = (int(np.count_nonzero(ratios > x)) for x in (tolerance, TOLERANCE))
            self.regular, self._other_left = regular == len(left), left[:, self.rank :]
            self._inverse = (left[:, : self.rank] / sizes[: self.rank]).T
        self._right, free = basis[:, : self.rank], basis[:, self.rank :]
        self.Z, self.share = unit[:, None] * free, free.T / unit

    @cached_property
    def null(self) -> Array:
        """(m, m - rank) orthonormal basis of the y with Jᵀ y = 0."""
        return np.asarray(np.linalg.qr(self._other_left / self.lengths[:, None])[0])

    def change(self, g: Array) -> Array:
        """The shortest x with J x = g, for a vector or columns; the nearest to it where there is none."""
        return np.asarray((self._unit * (self._right @ (self._inverse @ (g.T / self.lengths).T)).T).T)

    def multipliers(self, f: Array) -> Array:
        """Return a y with Jᵀ y = f, up to the part of f along Z; the other ones differ by combinations of `null`."""
        return np.asarray(self._inverse.T @ (self._right.T @ (self._unit * f)) / self.lengths)


def scaled_rows(J: Any, unit: Array) -> tuple[Array, Array]:
    """The rows of J for coordinates in these units, scaled to unit length; the rows' lengths."""
    dense = J.toarray() * unit
    lengths = np.sqrt((dense * dense).sum(axis=1))
    lengths[lengths == 0] = 1.0
    return dense / lengths[:, None], lengths


def pivoted_rows(J: Array, sizes: Array | None = None) -> Array:
    """Places of as many independent rows as there are, in rising order, by a QR decomposition with pivoting (rank,).

    Rows that are round-off of larger vectors, of which they are projections with given `sizes` (rows,), are zero.
    """
    if not J.size:
        return np.zeros(0, dtype=np.int64)
    if sizes is not None:
        J = np.where(np.linalg.norm(J, axis=1) > DEPENDENT * sizes, J.T, 0.0).T
    triangle, order = qr(J.T, mode="r", pivoting=True)
    diagonal = abs(np.diag(triangle))
    return np.sort(order[: np.count_nonzero(diagonal > DEPENDENT * diagonal.max(initial=0.0))])


LEAST = 1e-14  # of the largest inertia along a free motion: what cannot be distinguished from none
DENSE_UP_TO = 1500  # coordinates, for which possible velocities and free motions are computed


def missing_inertia(system: System, q: Array, t: float, b: Array) -> str | None:
    """A message that names the body, or None where all free motions have inertia."""
    if system.nq > DENSE_UP_TO or not np.all(np.isfinite(q)):
        return None
    J = system.Phi_q(q, t, b=b)
    Z = NullSpace(J, units(system, q, J)).Z
    return along(system, q, Z, system.M(q, b=b))


def along(system: System, q: Array, Z: Array, M: csr_array) -> str | None:
    """The same, for the motions Z (nq, d) and the mass matrix M.

    Displacements are measured by the largest radius of gyration, so that masses compare with moments of inertia.
    """
    if not Z.shape[1]:
        return None
    layout = system.layout
    mass, turning = (M.diagonal()[place].max() for place in (layout.positions, layout.bodies.rotations))
    gyration = float(np.sqrt(turning / mass)) if mass > 0 else 0.0
    unit = layout.scales(max(gyration, LEAST_LEVER * extent(system, q)))
    motions = unit[:, None] * np.linalg.qr(Z / unit[:, None])[0]
    sizes, shapes = eigh(motions.T @ (M @ motions))
    if sizes[0] > LEAST * sizes[-1]:
        return None
    moved = (motions @ shapes[:, 0]) ** 2
    moved[layout.positions] = 0.0
    owner = layout.owners[int(np.argmax(np.add.reduceat(moved, layout.firsts)))]
    return (
        f"{'body ' * (owner in system.bodies)}{owner}: it has no inertia along a motion that "
        "its joints allow, or less than 1e-14 of the largest in the model. Give it mass and inertia about all axes."
    )


def refuse_missing_inertia(system: System, q: Array, Z: Array, M: csr_array) -> None:
    """Refuse a system whose accelerations along Z are not determined.

    Raises
    ------
    ModelError
    """
    message = along(system, q, Z, M)
    if message is not None:
        raise ModelError(f"{system.name}: {message}")


def normalizations(system: System) -> Array:
    """Mark the equations of the Euler parameters (m,)."""
    mark = np.ones(system.m, dtype=bool)
    for rows in system.rows.values():
        mark[rows] = False
    return mark
