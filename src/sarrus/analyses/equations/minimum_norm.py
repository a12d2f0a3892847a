"""Multipliers of minimum norm, where constraints are redundant: the one answer that runs report and derivatives have.

Φ_qᵀλ fixes λ up to the left null space of Φ_q. Of all λ with the same constraint forces the reported one has the least
norm λᵀG λ of the joints' forces and moments, see `joint_wrenches`: λ - N NᵀGλ with a basis N of that null space for
which NᵀGN = I.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import qr, svd
from scipy.sparse import csr_array

from ..._jit.linking.link import compiled
from ...algebra import Array
from ...linalg.factors import DENSE_BELOW
from ...linalg.rank import DEPENDENT
from ...model.coordinates import POSITION
from ...system import System
from .block_matrix import UNIT
from .joint_wrenches import Supports, Wrenches, supports
from .motion import KKTMatrix
from .nullspace import NullSpace

ROUNDING = np.finfo(float).eps


class MinimumNorm:
    """The left null space of Φ_q at one position after another, for one choice of independent equations.

    Parameters
    ----------
    system : System
    rows : places in Φ of independent equations

    Attributes
    ----------
    dropped : places of the others
    """

    def __init__(self, system: System, rows: Array) -> None:
        self._nq, self._m = system.nq, system.m
        self._kkt = KKTMatrix(system, UNIT, rows)
        self.dropped = np.setdiff1d(np.arange(system.m), rows)
        self._small = system.nq < DENSE_BELOW

    def combinations(self, J: csr_array) -> Array:
        """For every equation left out, itself less what it follows from (m, k): nᵀΦ_q = 0.

        Raises
        ------
        SingularSystem
            If the equations chosen are dependent there.
        """
        self._kkt.factor_with(J.data)
        found = -self.forces(J.toarray()[self.dropped].T if self._small else J[self.dropped].toarray().T)
        found[self.dropped, np.arange(len(self.dropped))] = 1
        return found

    def null(self, J: csr_array) -> Array:
        """An orthonormal basis (m, k) of the left null space; what follows is at the same position."""
        return np.asarray(qr(self.combinations(J), mode="economic")[0])

    def least(self, system: System, J: csr_array, q: Array, b: Array) -> MinimumNormChoice:
        """The multipliers of least norm at a position; what follows is there, too."""
        return MinimumNormChoice.of(Wrenches(system, J, q, b), self.null(J))

    def forces(self, f: Array) -> Array:
        """Multipliers of the equations chosen whose constraint forces come nearest to f, (nq, k) -> (m, k)."""
        return self._kkt.solve_pair(f, np.zeros((self._m, f.shape[1])))[1]

    def motions(self, g: Array) -> Array:
        """The least ξ with Φ_q ξ = g in the equations chosen, (m, k) -> (nq, k)."""
        return self._kkt.solve_pair(np.zeros((self._nq, g.shape[1])), g)[0]


class MinimumNormChoice(NamedTuple):
    """The choice of multipliers of least norm at one position.

    Attributes
    ----------
    null : (m, k) basis N of the left null space, of norm 1; without combinations in which no joint has a force
    dual : (m, k) GN
    """

    null: Array
    dual: Array

    @classmethod
    def of(cls, wrenches: Wrenches, null: Array) -> MinimumNormChoice:
        """From an orthonormal basis of the left null space."""
        _, sizes, right = svd(wrenches.of_multipliers(null), full_matrices=False)
        acting = sizes > DEPENDENT * wrenches.terms(null)
        basis = null @ (right[acting].T / sizes[acting])
        dual = [wrenches.J @ wrenches.deflections(column) for column in basis.T]
        return cls(basis, np.reshape(dual, basis.T.shape).T)

    def choose(self, lam: Array) -> Array:
        """The least of all multipliers (m,) or (m, k) with the same constraint forces."""
        return np.asarray(lam - self.null @ (self.dual.T @ lam))

    def transposed(self, bar: Array) -> Array:
        """The gradient by multipliers from that by the least ones."""
        return np.asarray(bar - self.dual @ (self.null.T @ bar))


def least_multipliers(
    system: System, space: NullSpace, J: csr_array, q: Array, b: Array | None, f: Array
) -> Array:
    """The multipliers of least norm with Φ_qᵀλ = f, up to the part of f along free directions."""
    lam = space.multipliers(f)
    if space.rank == len(lam):
        return lam
    return MinimumNormChoice.of(Wrenches(system, J, q, system.b if b is None else b), space.null).choose(lam)


def multipliers_of(system: System, rows: Array, lam: Array, q: Array, t: float, b: Array) -> Array:
    """The multipliers (m,) of independent equations, at places `rows`, with the constraint forces of `lam` (m,)."""
    J = system.Phi_q(q, t, b=b)
    minimum = MinimumNorm(system, rows)
    minimum.null(J)
    return minimum.forces((J.T @ lam)[:, None])[:, 0]


def left_out(system: System, rows: Array | None) -> Omissions:
    """The equations that are not among the independent `rows` (None: all are), for compiled code."""
    others = np.delete(np.arange(system.m), slice(None) if rows is None else rows)
    pattern, whole = system.pattern("Phi_q"), np.int64
    of: Supports = supports(system)
    numbers = np.zeros(pattern.size), np.zeros((len(others), system.m))
    places = pattern.indptr.astype(whole), pattern.indices.astype(whole)
    force, wrenches = of.forces(), np.zeros((len(others) + 1, 6 * len(of.body)))
    apart = np.column_stack(np.unravel_index(of.columns, force.shape))
    sizes, weight = np.array([of.least, of.otherwise]), np.zeros(len(force))
    weight[: len(of.weight)] = of.weight
    return Omissions(others, *places, *numbers, apart, of.body, of.point, weight, sizes, force, wrenches)


class Omissions(NamedTuple):
    """Equations that are left out because others imply them.

    Attributes
    ----------
    rows : (k,) their places in Φ
    first : (m + 1,) where the numbers of each equation begin in Φ_q, and their end
    columns : the coordinate that each number of Φ_q belongs to
    Phi_q : numbers of all equations at a state
    null : (k, m) combinations of equations that vanish there
    apart : for each number of Φ_q its place in `force`
    body, point : see `Supports`
    weight : that of bodies in `Supports`, and 0 for other owners of coordinates
    lengths : `least` and `otherwise`
    force, wrenches : work arrays, see `Supports.forces`, and (k + 1, 6 c)
    """

    rows: Array
    first: Array
    columns: Array
    Phi_q: Array
    null: Array
    apart: Array
    body: Array
    point: Array
    weight: Array
    lengths: Array
    force: Array
    wrenches: Array


@compiled
def gradient(others: Omissions, row: int, force: Array) -> None:
    """Add the gradient of one equation to a force."""
    for entry in range(others.first[row], others.first[row + 1]):
        force[others.columns[entry]] += others.Phi_q[entry]


@compiled
def shorten(others: Omissions, b: Array, q: Array, lam: Array) -> None:
    """Subtract the part of the multipliers along the combinations, which are made orthonormal (Gram and Schmidt).

    Combinations in which no joint has a force are left out.
    """
    null, wrenches, count, length = others.null, others.wrenches, len(others.null), length_of(others, b)
    for k in range(count):
        size = wrench(others, length, b, q, null[k], wrenches[k])
        own, before = dot(wrenches[k], wrenches[k]), np.inf
        while DEPENDENT**2 * size < own < 0.5 * before:  # again if much was subtracted (Daniel, Gragg et al.)
            before = own
            for other in range(k):
                subtract(wrenches[other], null[other], own, wrenches[k], null[k])
            own = dot(wrenches[k], wrenches[k])
        scale = own**-0.5 if own > DEPENDENT**2 * size else 0.0
        for n in range(len(wrenches[k])):
            wrenches[k, n] *= scale
        for row in range(len(lam)):
            null[k, row] *= scale
    wrench(others, length, b, q, lam, wrenches[count])
    for k in range(count):
        subtract(wrenches[k], null[k], 0.0, wrenches[count], lam)


@compiled
def subtract(unit: Array, null: Array, own: float, of: Array, lam: Array) -> None:
    """Subtract from `lam`, whose forces and moments are `of`, its part along a combination of unit norm.

    A part that is lost in the rounding of `own`, the square of all parts, is left.
    """
    along = dot(unit, of)
    if along * along > ROUNDING**2 * own:
        for k in range(len(of)):
            of[k] -= along * unit[k]
        for row in range(len(lam)):
            lam[row] -= along * null[row]


@compiled
def dot(x: Array, y: Array) -> float:
    """xᵀy of forces and moments, in two sums side by side."""
    a, b = 0.0, 0.0
    for k in range(0, len(x), 6):
        a += x[k] * y[k] + x[k + 1] * y[k + 1] + x[k + 2] * y[k + 2]
        b += x[k + 3] * y[k + 3] + x[k + 4] * y[k + 4] + x[k + 5] * y[k + 5]
    return a + b


@compiled
def length_of(others: Omissions, b: Array) -> float:
    """The length of the mechanism, see `Supports.length_2`."""
    total, count = 0.0, 0
    for at in others.point:
        if at >= 0:
            total, count = total + b[at] ** 2 + b[at + 1] ** 2 + b[at + 2] ** 2, count + 1
    if total > count * others.lengths[0] ** 2:
        return float((total / count) ** 0.5)
    return float(others.lengths[1])


@compiled
def wrench(others: Omissions, length: float, b: Array, q: Array, lam: Array, found: Array) -> float:
    """Fill in √w (L F, M) of all joints on their bodies, see `Wrenches`; returns the sum of squares of their terms."""
    size = 0.0
    others.force[:] = 0.0
    for row in range(len(lam)):
        for entry in range(others.first[row], others.first[row + 1]):
            k, at, x = others.apart[entry, 0], others.apart[entry, 1], others.Phi_q[entry] * lam[row]
            others.force[k, at] += x
            size += others.weight[k] * (x * (length if at < POSITION else 0.5)) ** 2
    for k in range(len(others.body)):
        p, y, at = others.body[k] + POSITION, others.force[k], others.point[k]
        e0, e1, e2, e3 = q[p], q[p + 1], q[p + 2], q[p + 3]
        Fx, Fy, Fz, y0, y1, y2, y3 = y[0], y[1], y[2], y[3], y[4], y[5], y[6]
        sx, sy, sz = (b[at], b[at + 1], b[at + 2]) if at >= 0 else (0.0, 0.0, 0.0)
        dx, dy, dz = e2 * sz - e3 * sy, e3 * sx - e1 * sz, e1 * sy - e2 * sx
        ax = sx + 2 * (e2 * dz - e3 * dy + e0 * dx)
        ay = sy + 2 * (e3 * dx - e1 * dz + e0 * dy)
        az = sz + 2 * (e1 * dy - e2 * dx + e0 * dz)
        root, m = others.weight[k] ** 0.5, 6 * k
        found[m], found[m + 1], found[m + 2] = root * length * Fx, root * length * Fy, root * length * Fz
        found[m + 3] = root * (0.5 * (e2 * y3 - e3 * y2 + e0 * y1 - e1 * y0) - (ay * Fz - az * Fy))
        found[m + 4] = root * (0.5 * (e3 * y1 - e1 * y3 + e0 * y2 - e2 * y0) - (az * Fx - ax * Fz))
        found[m + 5] = root * (0.5 * (e1 * y2 - e2 * y1 + e0 * y3 - e3 * y0) - (ax * Fy - ay * Fx))
    return size
