"""Forces and moments of all joints on all bodies that they touch, and their norm, which chooses redundant multipliers.

Of all multipliers with the same constraint forces Φ_qᵀλ, those reported have the least sum over all joints of

    w Σ_bodies L² |F|² + |M|²

with the force F and the moment M about the joint's point on each body, w = 1 over the number of bodies that the joint
touches besides the ground, and the length L, the root mean square of the distances of these points from the bodies'
origins. It is the distribution of equal bushings in all joints, and depends neither on units nor on axes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...elements.element import Kind
from ...model.coordinates import by_body, slice_of
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
    places : for each coordinate that parts have for themselves, its place in q: 7 c of bodies, then those of others
    point : (c,) place in b of the first coordinate of the part's point on the body; -1 at the body's origin
    weight : (c,) 1 over the number of bodies of the part; 0 for normalizations
    columns : for each number of Φ_q its column in the Jacobian by the coordinates that each part has for itself
    least, otherwise : a length L below the first is replaced by the second
    """

    body: Array
    places: Array
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
        """Generalized forces of each part on each of its bodies, all zero (c, 7), and behind them on all others."""
        return by_body(np.zeros(slice_of(-(-len(self.places) // slice_of(1).start)).start))

    def of_bodies(self, x: Array) -> Array:
        """Coordinates of the bodies, or generalized forces on them, (c, 7)."""
        return by_body(x[: slice_of(len(self.body)).start])

    def whole(self, parts: Sequence[Array]) -> Array:
        """Columns of (c, 7) as coordinates that parts have for themselves, with zeros for those of others."""
        found = np.hstack(parts).ravel()
        return np.append(found, np.zeros(len(self.places) - len(found)))

    def arms(self, b: Array) -> Array:
        """The points in body axes (c, 3)."""
        at, found = self.point >= 0, np.zeros((len(self.point), 3), b.dtype)
        found[at] = b[self.point[at, None] + np.arange(3)]
        return found

    def copies(self, q: Array) -> Array:
        """Coordinates that each part has for itself, from those of the bodies (nq,) or (nq, k)."""
        return np.asarray(q[self.places])

    def collected(self, bar: Array, nq: int) -> Array:
        """Gradients by the coordinates of bodies from those by `copies`."""
        found = np.zeros((nq, *bar.shape[1:]))
        np.add.at(found, self.places, bar)
        return found


@once
def supports(system: System) -> Supports:
    """Where the constraints of a system act."""
    index, rows = _numbered(system), np.empty(system.m, dtype=object)
    layout, bodies = system.layout, [(owner, first) for owner, first in index if _of_body(system, first)]
    point, starts = np.full(len(bodies), -1), _starts(system, index)
    for p in system.populations if system.m else ():
        at = dict(zip(p.kind.fields, np.cumsum([0, *p.kind.widths()]), strict=False))
        for k in range(p.count if p.kind.rows else 0):
            rows[int(p.rows[k]) : int(p.rows[k]) + p.kind.rows] = p.owners[k]
            on = [first for first in firsts(p, k) if _of_body(system, first)]  # or the ground
            for name, side in SIDES.items():
                if p.kind.fields.get(name) == "Vec3" and side < len(on) and on[side] >= 0:
                    one = index[p.owners[k], on[side]]
                    point[one] = point[one] if point[one] >= 0 else p.at + k * p.kind.size() + at[name]
    count = Counter(owner for owner, _ in bodies)
    weight = [float(bool(owner)) / count[owner] for owner, _ in bodies]
    pattern, radius = system.pattern("Phi_q"), radius_of_gyration(system)
    of = np.repeat(rows, np.diff(pattern.indptr))
    firsts_of = layout.firsts[layout.owner_of[pattern.indices]].tolist()
    columns = [
        starts[index[owner, first]] + c - first
        for owner, c, first in zip(of, pattern.indices.tolist(), firsts_of, strict=True)
    ]
    places = [n for _, first in index for n in np.flatnonzero(layout.owner_of == layout.owner_of[first])]
    of_bodies = np.array([first for _, first in bodies], dtype=np.int64)
    return Supports(
        of_bodies, np.array(places, np.int64), point, np.array(weight), np.array(columns, np.int64),
        SMALL * radius, radius or 1.0,
    )  # fmt: skip


def _of_body(system: System, first: int) -> bool:
    """Whether it is the first coordinate of a body, or -1."""
    return first < system.layout.bodies.size


def _numbered(system: System) -> dict[tuple[str, int], int]:
    """The parts with equations and their bodies, numbered; other owners of coordinates are behind bodies."""
    found: dict[tuple[str, int], None] = {}
    for p in system.populations:
        for k in range(p.count if p.kind.rows else 0):
            found |= {(p.owners[k], first): None for first in firsts(p, k) if first >= 0}
    ordered = sorted(found, key=lambda one: not _of_body(system, one[1]))
    return {one: n for n, one in enumerate(ordered)}


def _starts(system: System, index: Iterable[tuple[str, int]]) -> list[int]:
    """Where the coordinates of each part and body begin among those that parts have for themselves."""
    layout = system.layout
    sizes = np.bincount(layout.owner_of)[[layout.owner_of[first] for _, first in index]]
    return [*map(int, np.cumsum(sizes) - sizes)]


@once
def separated(system: System) -> System:
    """The constraints alone, each part's with bodies of its own; parameters and equations have the same places."""
    index, found, layout = _numbered(system), copy(system), system.layout
    starts, kinds = _starts(system, index), dict[str, tuple[Kind, ...]]()
    for block in layout.blocks:
        kinds[block.owner] = (*kinds.get(block.owner, ()), block.kind)

    def moved(p: Population) -> Population:
        pairs = [
            [starts[index[owner, int(first)]] for first in row]
            for owner, row in zip(p.owners, p.bodies, strict=True)
        ]
        return replace(p, bodies=np.array(pairs, dtype=np.int64).reshape(p.bodies.shape))

    found.populations = [moved(p) for p in system.populations if p.kind.rows]
    found.layout = Layout.of(
        {f"{owner}.{first}": kinds[layout.owners[layout.owner_of[first]]] for owner, first in index}
    )
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
        shape = system.m, len(self.of.places)
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
        scale = self.of.whole([np.sqrt(self.of.weight)[:, None] * units])
        return float(np.linalg.norm(scale[:, None] * (abs(self.J).T @ abs(lam))))

    def deflections(self, lam: Array) -> Array:
        """K Φ̂_qᵀλ, the gradient of half the norm by the generalized forces of λ (m,) (7 c,)."""
        return deflections(self.of, self._q, self._b, self.forces(lam))

    def gradients(self, y1: Array, y2: Array) -> tuple[Array, Array]:
        """Gradients of y1ᵀ K y2 by q (7 c,) and b."""
        return norm_gradients(self.of, self._q, self._b, y1, y2)


def _parts(of: Supports, q: Array, b: Array, y: Array) -> tuple[Array, Array]:
    """F and M = ½ E(p) y_p - A s × F of generalized forces (7 c,), (c, 3) each."""
    p, y, s = of.of_bodies(q)[:, 3:], of.of_bodies(y), of.arms(b)
    (e0, e), (y0, ye), F = (p[:, :1], p[:, 1:]), (y[:, 3:4], y[:, 4:]), y[:, :3]
    a = s + 2 * np.cross(e, np.cross(e, s) + e0 * s)
    return F, 0.5 * (np.cross(e, ye) + e0 * ye - y0 * e) - np.cross(a, F)


def deflections(of: Supports, q: Array, b: Array, y: Array) -> Array:
    """K y, the gradient of ½ w (L² |F|² + |M|²) by y (7 c,)."""
    p, s, (F, M) = of.of_bodies(q)[:, 3:], of.arms(b), _parts(of, q, b, y)
    e0, e = p[:, :1], p[:, 1:]
    a = s + 2 * np.cross(e, np.cross(e, s) + e0 * s)
    by_F = of.length_2(b)[0] * F + np.cross(a, M)
    by_y = -0.5 * np.sum(e * M, axis=1, keepdims=True), 0.5 * (np.cross(M, e) + e0 * M)
    return of.whole([of.weight[:, None] * by for by in (by_F, *by_y)])


def norm_gradients(of: Supports, q: Array, b: Array, y1: Array, y2: Array) -> tuple[Array, Array]:
    """Gradients of y1ᵀ K(q, b) y2 by q (7 c,) and b."""
    p, s, w = of.of_bodies(q)[:, 3:], of.arms(b), of.weight[:, None]
    e0, e = p[:, :1], p[:, 1:]
    (F1, M1), (F2, M2) = (_parts(of, q, b, y) for y in (y1, y2))
    g = w * (np.cross(M2, F1) + np.cross(M1, F2))  # by A s
    by_e0 = 2 * _dot(g, np.cross(e, s))
    by_e = 2 * (e0 * np.cross(s, g) + s * _dot(e, g) + g * _dot(e, s) - 2 * e * _dot(s, g))
    for y, M in ((y1, w * M2), (y2, w * M1)):
        y0, ye = (x := of.of_bodies(y))[:, 3:4], x[:, 4:]
        by_e0, by_e = by_e0 + 0.5 * _dot(ye, M), by_e + 0.5 * (np.cross(ye, M) - y0 * M)
    by_s = g + 2 * (e0 * np.cross(g, e) + e * _dot(e, g) - g * _dot(e, e))
    by_b = of.length_2(b)[1] * np.sum(w * F1 * F2)
    known = of.point >= 0
    np.add.at(by_b, of.point[known, None] + np.arange(3), by_s[known])
    return of.whole([0 * g, by_e0, by_e]), by_b


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=1, keepdims=True))
