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

from ...algebra import Array
from ...linalg.factors import DENSE_BELOW
from ...linalg.rank import DEPENDENT
from ...system import System
from .joint_wrenches import Supports, Wrenches, supports
from .minimum_norm_loop import LeftOut
from .nullspace import NullSpace
from .saddle_point import Saddle


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
        self._saddle = Saddle(system, "I", rows)
        self.dropped = np.setdiff1d(np.arange(system.m), rows)
        self._small = system.nq < DENSE_BELOW

    def combinations(self, J: csr_array) -> Array:
        """For every equation left out, itself less what it follows from (m, k): nᵀΦ_q = 0.

        Raises
        ------
        SingularSystem
            If the equations chosen are dependent there.
        """
        self._saddle.factor(np.ones(self._nq), J.data)
        found = -self.forces(J.toarray()[self.dropped].T if self._small else J[self.dropped].toarray().T)
        found[self.dropped, np.arange(len(self.dropped))] = 1
        return found

    def null(self, J: csr_array) -> Array:
        """An orthonormal basis (m, k) of the left null space; what follows is at the same position."""
        return np.asarray(qr(self.combinations(J), mode="economic")[0])

    def least(self, system: System, J: csr_array, q: Array, b: Array) -> Least:
        """The multipliers of least norm at a position; what follows is there, too."""
        return Least.of(Wrenches(system, J, q, b), self.null(J))

    def forces(self, f: Array) -> Array:
        """Multipliers of the equations chosen whose constraint forces come nearest to f, (nq, k) -> (m, k)."""
        return self._saddle.solve(f, np.zeros((self._m, f.shape[1])))[1]

    def motions(self, g: Array) -> Array:
        """The least ξ with Φ_q ξ = g in the equations chosen, (m, k) -> (nq, k)."""
        return self._saddle.solve(np.zeros((self._nq, g.shape[1])), g)[0]


class Least(NamedTuple):
    """The choice of multipliers of least norm at one position.

    Attributes
    ----------
    null : (m, k) basis N of the left null space, of norm 1; without combinations in which no joint has a force
    dual : (m, k) GN
    """

    null: Array
    dual: Array

    @classmethod
    def of(cls, wrenches: Wrenches, null: Array) -> Least:
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
    if not space.null.size:
        return lam
    return Least.of(Wrenches(system, J, q, system.b if b is None else b), space.null).choose(lam)


def multipliers_of(system: System, rows: Array, lam: Array, q: Array, t: float, b: Array) -> Array:
    """The multipliers (m,) of independent equations, at places `rows`, with the constraint forces of `lam` (m,)."""
    J = system.Phi_q(q, t, b=b)
    minimum = MinimumNorm(system, rows)
    minimum.null(J)
    return minimum.forces((J.T @ lam)[:, None])[:, 0]


def left_out(system: System, rows: Array | None) -> LeftOut:
    """The equations that are not among the independent `rows` (None: all are), for compiled code."""
    others = np.delete(np.arange(system.m), slice(None) if rows is None else rows)
    pattern, whole = system.pattern("Phi_q"), np.int64
    of: Supports = supports(system)
    numbers = np.zeros(pattern.size), np.zeros((len(others), system.m))
    places = pattern.indptr.astype(whole), pattern.indices.astype(whole)
    wrenches = np.zeros(7 * len(of.body)), np.zeros((len(others) + 1, 6 * len(of.body)))
    sizes = np.array([of.least, of.otherwise])
    return LeftOut(others, *places, *numbers, of.columns, of.body, of.point, of.weight, sizes, *wrenches)
