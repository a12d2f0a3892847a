"""Forces and moments of all joints on all bodies that they touch, and their norm, which chooses redundant multipliers.

Of all multipliers with the same constraint forces Φ_qᵀλ, those reported have the least sum over all joints of

    w Σ_bodies L² |F|² + |M|²

with the force F and the moment M about the joint's point on each body, w = 1 over the number of bodies that the joint
touches besides the ground, and the length L, the root mean square of the distances of these points from the bodies'
origins. It is the distribution of equal bushings in all joints, and depends neither on units nor on axes.
"""

from __future__ import annotations

from collections import Counter
from copy import copy
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...model.coordinates import WIDTH, by_body, slice_of
from ...system import System
from ...system.cached import once
from ...system.layout import Layout
from ...system.structure.population import Population, firsts
from ...system.structure.structure import structure_of
from .length import POINTS, SMALL, radius_of_gyration

SIDES = POINTS | {"s_k": 2, "s_l": 3}


class Supports(NamedTuple):
    """The bodies that parts with constraint equations act on: one entry for each part and body.

    Attributes
    ----------
    body : (c,) first coordinate of the body
    point : (c,) place in b of the first coordinate of the part's point on the body; -1 at the body's origin
    weight : (c,) 1 over the number of bodies of the part; 0 for normalizations, and blocks of states
    columns : for each number of Φ_q its column in the Jacobian by the coordinates that each part has for itself
    least, otherwise : a length L below the first is replaced by the second
    """

    body: Array
    point: Array
    weight: Array
    columns: Array
    least: float
    otherwise: float

    def length_2(self, b: Array) -> tuple[Array, Array]:
        """L², and its gradient (len(b),)."""
        at = self.point[self.point >= 0, None] + np.arange(3)
        mean, gradient = np.sum(b[at] ** 2) / max(len(at), 1), np.zeros_like(b)
        if not mean.real > self.least**2:
            return np.asarray(self.otherwise**2), gradient
        gradient[at] = 2 * b[at] / len(at)
        return mean, gradient

    def forces(self) -> Array:
        """Generalized forces of each part on each of its bodies, all zero (c, 7)."""
        return by_body(np.zeros(slice_of(len(self.body)).start))

    def arms(self, b: Array) -> Array:
        """The points in body axes (c, 3)."""
        at, found = self.point >= 0, np.zeros((len(self.point), 3), b.dtype)
        found[at] = b[self.point[at, None] + np.arange(3)]
        return found

    def copies(self, q: Array) -> Array:
        """Coordinates that each part has for itself, from those of the bodies (nq,) or (nq, k)."""
        return np.asarray(q[(self.body[:, None] + np.arange(WIDTH)).ravel()])

    def collected(self, bar: Array, nq: int) -> Array:
        """Gradients by the coordinates of bodies from those by `copies` (7 c, k)."""
        found = np.zeros((nq, *bar.shape[1:]))
        np.add.at(found, (self.body[:, None] + np.arange(WIDTH)).ravel(), bar)
        return found


@once
def supports(system: System) -> Supports:
    """Where the constraints of a system act."""
    index, rows = _numbered(system), np.empty(system.m, dtype=object)
    point = np.full(len(index), -1)
    for p in system.populations if system.m else ():
        at = dict(zip(p.kind.fields, np.cumsum([0, *p.kind.widths()]), strict=False))
        for k in range(p.count if p.kind.rows else 0):
            rows[int(p.rows[k]) : int(p.rows[k]) + p.kind.rows] = p.owners[k]
            for name, side in SIDES.items():
                if p.kind.fields.get(name) == "Vec3" and (first := firsts(p, k)[side]) >= 0:
                    one = index[p.owners[k], first]
                    point[one] = point[one] if point[one] >= 0 else p.at + k * p.kind.size() + at[name]
    count = Counter(owner for owner, _ in index)
    weight = [float(bool(owner) and first < system.moving) / count[owner] for owner, first in index]
    pattern, radius = system.pattern("Phi_q"), radius_of_gyration(system)
    of = np.repeat(rows, np.diff(pattern.indptr))
    firsts_of = system.layout.firsts[system.layout.owner_of[pattern.indices]].tolist()
    columns = [
        slice_of(index[owner, first]).start + c - first
        for owner, c, first in zip(of, pattern.indices.tolist(), firsts_of, strict=True)
    ]
    return Supports(
        np.array([first for _, first in index], dtype=np.int64), point, np.array(weight), np.array(columns, np.int64),
        SMALL * radius, radius or 1.0,
    )  # fmt: skip


def _numbered(system: System) -> dict[tuple[str, int], int]:
    """The parts with equations and their bodies, numbered."""
    found: dict[tuple[str, int], int] = {}
    for p in system.populations:
        for k in range(p.count if p.kind.rows else 0):
            for first in firsts(p, k):
                if first >= 0:
                    found.setdefault((p.owners[k], first), len(found))
    return found


@once
def separated(system: System) -> System:
    """The constraints alone, each part's with bodies of its own; parameters and equations have the same places."""
    index, found = _numbered(system), copy(system)

    def moved(p: Population) -> Population:
        pairs = [
            [slice_of(index[owner, int(first)]).start for first in row]
            for owner, row in zip(p.owners, p.bodies, strict=True)
        ]
        return replace(p, bodies=np.array(pairs, dtype=np.int64).reshape(p.bodies.shape))

    found.populations = [moved(p) for p in system.populations if p.kind.rows]
    found.layout = Layout.of([f"{owner}.{first}" for owner, first in index])
    found.nq = found.layout.size
    found.structure = structure_of(found.populations, found.layout.widths, system.m, system.nb)
    return found


class Wrenches:
    """The forces and moments of all joints at one position, as linear functions of multipliers.

    Parameters
    ----------
    system : System
    J : Φ_q there
    q, b : (nq,), (len(b),)
    """

    def __init__(self, system: System, J: csr_array, q: Array, b: Array) -> None:
        self.of = supports(system)
        shape = system.m, self.of.forces().size
        self.J = csr_array((J.data, self.of.columns, J.indptr), shape=shape)
        self._q, self._b = self.of.copies(q), b

    def forces(self, lam: Array) -> Array:
        """Generalized forces of each part on each of its bodies (7 c, ...)."""
        return np.asarray(self.J.T @ lam)

    def of_multipliers(self, lam: Array) -> Array:
        """√w (L F, M) of multipliers (m, k), whose square is the norm (6 c, k)."""
        y = self.forces(lam)
        root, length = np.sqrt(self.of.weight[:, None]), np.sqrt(self.of.length_2(self._b)[0])
        parts = [_parts(self.of, self._q, self._b, column) for column in y.T]
        return np.array([(root * np.hstack([length * F, M])).ravel() for F, M in parts]).T

    def terms(self, lam: Array) -> float:
        """The size of the norm's terms, which may cancel."""
        units = np.sqrt(np.append(np.repeat(self.of.length_2(self._b)[0], 3), [0.25] * 4))
        scale = (np.sqrt(self.of.weight)[:, None] * units).ravel()
        return float(np.linalg.norm(scale[:, None] * (abs(self.J).T @ abs(lam))))

    def deflections(self, lam: Array) -> Array:
        """K Φ̂_qᵀλ, the gradient of half the norm by the generalized forces of λ (m,) (7 c,)."""
        return deflections(self.of, self._q, self._b, self.forces(lam))

    def gradients(self, y1: Array, y2: Array) -> tuple[Array, Array]:
        """Gradients of y1ᵀ K y2 by q (7 c,) and b."""
        return norm_gradients(self.of, self._q, self._b, y1, y2)


def _parts(of: Supports, q: Array, b: Array, y: Array) -> tuple[Array, Array]:
    """F and M = ½ E(p) y_p - A s × F of generalized forces (7 c,), (c, 3) each."""
    p, y, s = by_body(q)[:, 3:], by_body(y), of.arms(b)
    (e0, e), (y0, ye), F = (p[:, :1], p[:, 1:]), (y[:, 3:4], y[:, 4:]), y[:, :3]
    a = s + 2 * np.cross(e, np.cross(e, s) + e0 * s)
    return F, 0.5 * (np.cross(e, ye) + e0 * ye - y0 * e) - np.cross(a, F)


def deflections(of: Supports, q: Array, b: Array, y: Array) -> Array:
    """K y, the gradient of ½ w (L² |F|² + |M|²) by y (7 c,)."""
    p, s, (F, M) = by_body(q)[:, 3:], of.arms(b), _parts(of, q, b, y)
    e0, e = p[:, :1], p[:, 1:]
    a = s + 2 * np.cross(e, np.cross(e, s) + e0 * s)
    by_F = of.length_2(b)[0] * F + np.cross(a, M)
    by_y = -0.5 * np.sum(e * M, axis=1, keepdims=True), 0.5 * (np.cross(M, e) + e0 * M)
    return np.asarray((of.weight[:, None] * np.hstack([by_F, *by_y])).ravel())


def norm_gradients(of: Supports, q: Array, b: Array, y1: Array, y2: Array) -> tuple[Array, Array]:
    """Gradients of y1ᵀ K(q, b) y2 by q (7 c,) and b."""
    p, s, w = by_body(q)[:, 3:], of.arms(b), of.weight[:, None]
    e0, e = p[:, :1], p[:, 1:]
    (F1, M1), (F2, M2) = (_parts(of, q, b, y) for y in (y1, y2))
    g = w * (np.cross(M2, F1) + np.cross(M1, F2))  # by A s
    by_e0 = 2 * _dot(g, np.cross(e, s))
    by_e = 2 * (e0 * np.cross(s, g) + s * _dot(e, g) + g * _dot(e, s) - 2 * e * _dot(s, g))
    for y, M in ((y1, w * M2), (y2, w * M1)):
        y0, ye = (x := by_body(y))[:, 3:4], x[:, 4:]
        by_e0, by_e = by_e0 + 0.5 * _dot(ye, M), by_e + 0.5 * (np.cross(ye, M) - y0 * M)
    by_s = g + 2 * (e0 * np.cross(g, e) + e * _dot(e, g) - g * _dot(e, e))
    by_b = of.length_2(b)[1] * np.sum(w * F1 * F2)
    known = of.point >= 0
    np.add.at(by_b, of.point[known, None] + np.arange(3), by_s[known])
    return np.hstack([0 * g, by_e0, by_e]).ravel(), by_b


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=1, keepdims=True))
