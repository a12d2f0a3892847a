"""Vertices of candidate curves: the curves that begin there, and their directions.

At the end of a curve with the limits S active, limit i is reached: curves with S + {i} go both ways. Where a multiplier
vanishes, it is the other way round: three half curves meet, one of S, two of S + {i}. Where no freedom is left with
S + {i}, each of its limits can be left instead.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import eigvals

from ....algebra import Array
from ....linalg.svd import singular
from .event import Event, Own
from .point import Point, point_at, point_with
from .stratum import SAME, Active, Limit, NoPoint, Stratum, Tangent, Tangents, apart, body_signs

DROPS = 1e-6  # of a singular value, relative to the largest, that counts as zero


def directions(stratum: Stratum, x: Array, linear: Tangents) -> list[Array]:
    """Unit tangents (size,) of the curves through x, each in one of its two senses."""
    left, _, right = singular(linear.G_x)
    psi, pair = left[:, -1], right[-2:]
    form = np.array([[psi @ stratum.second(x, s, t) for s in pair] for t in pair])
    found = [zero @ pair for zero in _zeros(form)]
    return [t for t in found if np.linalg.norm(t[: stratum.n]) > DROPS]


def normals(stratum: Stratum, q: Array) -> list[Array]:
    """Unknowns x with the normals of all curves through a position at which the rank drops by two; or none."""
    p = stratum.problem
    J = p.jacobian(q)
    gradients = np.concatenate([J[stratum.rows], J[stratum.normal]])
    left, sizes, right = singular(gradients)
    rank = len(sizes) - 2
    if sizes[rank] > DROPS * sizes[0]:
        return []
    Z, pair = right[rank:].T, left[:, rank:]
    forms = []
    for weights in pair.T:
        spread = np.zeros(p.rows)
        spread[stratum.rows], spread[stratum.normal] = weights[: stratum.count], weights[stratum.count :]
        forms.append(Z.T @ p.curvature(q, spread) @ Z)
    found = [a * pair[:, 0] + b * pair[:, 1] for a, b in _singular(forms[0], forms[1])]
    return [np.concatenate([q, both / np.linalg.norm(both)]) for both in found]


def _singular(A: Array, B: Array) -> list[tuple[float, float]]:
    """(a, b) with a A + b B singular: homogeneous generalized eigenvalues that are real."""
    alpha, beta = eigvals(A, -B, homogeneous_eigvals=True)
    size = np.hypot(abs(alpha), abs(beta))
    real = (size > 1e-12) & (abs((alpha * np.conj(beta)).imag) <= 1e-8 * size**2)
    turn = np.exp(-1j * np.angle(np.where(abs(beta) > abs(alpha), beta, alpha)))
    pairs = [
        ((b * w).real, (a * w).real) for a, b, w in zip(alpha[real], beta[real], turn[real], strict=True)
    ]
    return [(x, y) for x, y in pairs]


def _zeros(form: Array) -> list[Array]:
    """Unit directions in which a quadratic form of two variables vanishes."""
    (low, high), axes = np.linalg.eigh(form)
    size = max(abs(low), abs(high))
    if size == 0 or low * high > DROPS * size * size:
        return []
    a, b = np.sqrt(np.maximum([high, -low], 0.0) / (max(high, 0.0) + max(-low, 0.0)))
    return [a * axes[:, 0] + b * axes[:, 1], a * axes[:, 0] - b * axes[:, 1]]


Strata = Callable[[Active], Stratum]


@dataclass(eq=False)
class Half:
    """A curve that begins at a vertex: its active limits, its first point with the tangent into it."""

    key: Active
    point: Point
    own: Own
    done: bool = False


@dataclass(eq=False)
class Vertex:
    """A position at which curves begin, end or meet.

    `kind` is "limit", "corner", "cusp", "branch", "seed", "end" at a limit of singularities of the inputs, or "loose",
    where a curve was lost.
    """

    kind: str
    q: Array
    key: Active
    limit: Limit | None
    u: Array
    halves: list[Half] = field(default_factory=list)

    def is_same(self, other: Vertex, c: Array) -> bool:
        """Whether this is the vertex of an event, with its normal c or -c."""
        mine, its = (self.kind, self.key, self.limit), (other.kind, other.key, other.limit)
        if mine != its or apart(other.q, self.q) > SAME:
            return False
        return self.kind in ("corner", "branch") or any(_parallel(half.point.c, c) for half in self.halves)

    def half(self, key: Active, q: Array, into: Array) -> Half | None:
        """The half curve with these active limits that leaves in a direction (n,) of the position."""
        best, found = 0.5, None
        for half in self.halves:
            if half.key != key or half.done:
                continue
            n = len(q)
            flip = body_signs(half.point.x[:n], q)
            mine = half.point.t[:n] * flip
            sizes = float(np.linalg.norm(mine) * np.linalg.norm(into))
            cosine = float(mine @ into) / sizes if sizes > 0 else 0.0
            if cosine > best:
                best, found = cosine, half
        return found


def _parallel(a: Array, b: Array) -> bool:
    return min(float(np.linalg.norm(a - b)), float(np.linalg.norm(a + b))) < 1e-4


def vertex_of(stratum: Stratum, event: Event) -> Vertex:
    """The vertex of an event, without the curves that begin there."""
    p, key, limit = stratum.problem, stratum.key, event.limit
    kind = event.kind
    if limit is not None and not p.of_outputs:
        kind = "end"
    elif limit is not None:
        key = key | {limit}
        kind = "limit" if p.freedoms - len(key) >= len(p.normal) - 1 else "corner"
    kept = None if kind == "corner" else limit
    return Vertex(kind, event.point.x[: stratum.n], key, kept, event.point.u)


def halves(strata: Strata, stratum: Stratum, point: Point, vertex: Vertex) -> Iterator[Half]:
    """The curves that begin at a vertex, which a curve with a stratum reaches at a point."""
    if vertex.kind == "end":
        yield Half(vertex.key, turned(point), ("limit", vertex.limit))
    elif vertex.kind == "limit" and vertex.limit is not None:
        yield from _at_limit(strata, stratum, point, vertex.limit)
    elif vertex.kind == "corner":
        yield from _at_corner(strata, stratum, point, vertex.key)
    elif vertex.kind == "cusp":
        yield from _both(stratum, point, ("cusp", None))
    elif vertex.kind == "branch":
        yield from _at_branch(stratum, point)


def loses_rank(stratum: Stratum, q: Array) -> bool:
    """Whether constraints, held functions and active limits are dependent: motion is not determined to first order."""
    sizes = singular(stratum.problem.jacobian(q)[stratum.rows])[1]
    return bool(sizes[-1] < DROPS * sizes[0])


def seed(stratum: Stratum, x: Array) -> Vertex:
    """A vertex at a regular point of a curve, from which both ways begin.

    Raises
    ------
    NoPoint
        If the position does not move along the curve, but only its normal, or if it is on no single curve.
    """
    point = _point_on(stratum, x, isolated=True)
    if np.linalg.norm(point.t[: stratum.n]) < DROPS:
        raise NoPoint("the position does not move along this curve")
    return Vertex("seed", x[: stratum.n], stratum.key, None, point.u, list(_both(stratum, point, None)))


def _point_on(stratum: Stratum, x: Array, *, isolated: bool = False) -> Point:
    """A regular point; `isolated` refuses one of several curves.

    Raises
    ------
    NoPoint
        If any normal will do, as where the tip of a folded arm lies on its first axis: the outputs stand still there.
    """
    linear = stratum.linear(x)
    _, sizes, along = singular(linear.G_x)
    free = along[np.count_nonzero(sizes >= DROPS * sizes[0]) :, : stratum.n]
    outputs = linear.J[stratum.problem.m + stratum.problem.outputs]
    if isolated and len(free) > 1 and np.linalg.norm(outputs @ free.T) < DROPS:
        raise NoPoint("the outputs stand still along this curve")
    return point_at(stratum, x, linear, along[-1])


def _both(stratum: Stratum, point: Point, own: Own) -> Iterator[Half]:
    yield Half(stratum.key, point, own)
    yield Half(stratum.key, turned(point), own)


def turned(point: Point) -> Point:
    """The same point with the curve run through the other way."""
    t = point.tangent
    other = t._replace(t=-t.t, sign=-t.sign)
    return replace(point, tangent=other, u_s=-point.u_s, margins_s=-point.margins_s)


def _at_limit(strata: Strata, stratum: Stratum, point: Point, limit: Limit) -> Iterator[Half]:
    whole = stratum.key | {limit}
    wide, narrow = strata(whole - {limit}), strata(whole)
    inner = along = point
    if stratum is narrow:
        inner = _point_on(wide, np.delete(point.x, narrow.multiplier(limit)))
    else:
        along = _point_on(narrow, np.insert(point.x, narrow.multiplier(limit), 0.0))
    yield from _inwards(wide, inner, limit)
    yield from _both(narrow, along, ("limit", limit))


def _inwards(stratum: Stratum, point: Point, limit: Limit) -> Iterator[Half]:
    """The curve through a point in the direction that leaves a limit inwards."""
    rate = point.margins_s[limit]
    if rate:
        yield Half(stratum.key, point if rate > 0 else turned(point), ("limit", limit))


def _at_corner(strata: Strata, stratum: Stratum, point: Point, key: Active) -> Iterator[Half]:
    for limit in sorted(key):
        other = strata(key - {limit})
        with suppress(NoPoint):
            x = point.x if other is stratum else balanced(other, point.x[: stratum.n])
            here = point if other is stratum else _point_on(other, x, isolated=True)
            yield from _inwards(other, here, limit)


def balanced(stratum: Stratum, q: Array) -> Array:
    """q with multipliers that balance: the left null vector of all gradients."""
    J = stratum.problem.jacobian(q)
    gradients = np.concatenate([J[stratum.rows], J[stratum.normal]])
    null = singular(gradients.T)[2][-1]
    return np.concatenate([q, null])


def _at_branch(stratum: Stratum, point: Point) -> Iterator[Half]:
    several = normals(stratum, point.x[: stratum.n]) if stratum.problem.of_outputs else []
    for x in several or [point.x]:
        linear = stratum.linear(x)
        for t in directions(stratum, x, linear):
            here = point_with(stratum, x, linear, Tangent(t, np.zeros_like(t), 0.0, False))
            yield from _both(stratum, here, ("branch", None))
