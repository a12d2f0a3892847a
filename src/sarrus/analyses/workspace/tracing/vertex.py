"""Vertices of candidate curves: the curves that begin there, and their directions.

At the end of a curve with the limits S active, limit i is reached: curves with S + {i} go both ways. Where a multiplier
vanishes, it is the other way round: three half curves meet, one of S, two of S + {i}. Where no freedom is left with
S + {i}, each of its limits can be left instead.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import eigvals

from ....algebra import Array
from ....linalg.svd import singular
from .event import Event
from .point import Point, point_with
from .stratum import SAME, Active, NoPoint, Stratum, Tangent, Tangents, apart, body_signs, tangent

DROPS = 1e-6  # of a singular value, relative to the largest, that counts as zero


def directions(stratum: Stratum, x: Array, linear: Tangents) -> list[Array]:
    """Unit tangents (size,) of the curves through x, each in one of its two senses."""
    left, _, right = singular(linear.G_x)
    psi, one, other = left[:, -1], right[-1], right[-2]
    c = [float(psi @ stratum.second(x, s, t)) for s, t in ((one, one), (one, other), (other, other))]
    found = [a * one + b * other for a, b in _roots(*c)]
    return [
        t / np.linalg.norm(t) for t in found if np.linalg.norm(t[: stratum.n]) > DROPS * np.linalg.norm(t)
    ]


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


def _roots(c11: float, c12: float, c22: float) -> list[tuple[float, float]]:
    """Real directions (a, b) of a quadratic form's zeros."""
    size = max(abs(c11), abs(c12), abs(c22))
    discriminant = c12 * c12 - c11 * c22
    if size == 0 or discriminant < -DROPS * size * size:
        return []
    root = max(discriminant, 0.0) ** 0.5
    if max(abs(c11), abs(c22)) <= DROPS * size:
        return [(1.0, 0.0), (0.0, 1.0)]
    if abs(c11) >= abs(c22):
        return [(-c12 + root, c11), (-c12 - root, c11)]
    return [(c22, -c12 + root), (c22, -c12 - root)]


Strata = Callable[[Active], Stratum]
Own = tuple[str, tuple[int, int] | None] | None


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
    limit: tuple[int, int] | None
    u: Array
    halves: list[Half] = field(default_factory=list)

    def is_at(self, kind: str, q: Array, key: Active, limit: tuple[int, int] | None, c: Array) -> bool:
        """Whether this is the vertex of an event; normals of either sign are the same."""
        if (kind, key, limit) != (self.kind, self.key, self.limit) or apart(q, self.q) > SAME:
            return False
        return kind in ("corner", "branch") or any(_parallel(half.point.c, c) for half in self.halves)

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


def describe(stratum: Stratum, event: Event) -> tuple[str, Active, tuple[int, int] | None]:
    """Kind, limits and limit of the vertex at which an event happens."""
    key = stratum.key
    if event.limit is None:
        return event.kind, key, None
    if not stratum.problem.of_outputs:
        return "end", key, event.limit
    whole = key | {event.limit}
    if stratum.problem.freedoms - len(whole) >= len(stratum.problem.normal) - 1:
        return "limit", whole, event.limit
    return "corner", whole, None


def vertex_of(strata: Strata, stratum: Stratum, event: Event) -> Vertex:
    """The vertex of an event, with all that begins there."""
    kind, key, limit = describe(stratum, event)
    x, u = event.point.x, event.point.u
    vertex = Vertex(kind, x[: stratum.n], key, limit, u)
    if kind == "end":
        vertex.halves = [Half(key, turned(event.point), ("limit", limit))]
    elif kind == "limit":
        assert limit is not None
        vertex.halves = list(_at_limit(strata, stratum, event.point, limit))
    elif kind == "corner":
        vertex.halves = list(_at_corner(strata, stratum, event.point, key))
    elif kind == "cusp":
        vertex.halves = list(_both(stratum, event.point, ("cusp", None)))
    elif kind == "branch":
        vertex.halves = list(_at_branch(stratum, event.point))
    return vertex


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
    point = _isolated(stratum, x)
    if np.linalg.norm(point.t[: stratum.n]) < DROPS:
        raise NoPoint("the position does not move along this curve")
    return Vertex("seed", x[: stratum.n], stratum.key, None, point.u, list(_both(stratum, point, None)))


def _regular(stratum: Stratum, x: Array) -> Point:
    linear = stratum.linear(x)
    along = singular(linear.G_x)[2][-1]
    return point_with(stratum, x, linear, tangent(stratum, x, linear, along))


def _isolated(stratum: Stratum, x: Array) -> Point:
    """A point of one curve only.

    Raises
    ------
    NoPoint
        If any normal will do, as where the tip of a folded arm lies on its first axis: the outputs stand still there.
    """
    linear = stratum.linear(x)
    _, sizes, along = singular(linear.G_x)
    free = along[np.count_nonzero(sizes >= DROPS * sizes[0]) :, : stratum.n]
    outputs = linear.J[stratum.problem.m + stratum.problem.outputs]
    if len(free) > 1 and np.linalg.norm(outputs @ free.T) < DROPS:
        raise NoPoint("the outputs stand still along this curve")
    return _regular(stratum, x)


def _both(stratum: Stratum, point: Point, own: Own) -> Iterator[Half]:
    yield Half(stratum.key, point, own)
    yield Half(stratum.key, turned(point), own)


def turned(point: Point) -> Point:
    """The same point with the curve run through the other way."""
    t = point.tangent
    other = t._replace(t=-t.t, sign=-t.sign)
    return replace(point, tangent=other, u_s=-point.u_s, margins_s=-point.margins_s)


def _at_limit(strata: Strata, stratum: Stratum, point: Point, limit: tuple[int, int]) -> Iterator[Half]:
    whole = stratum.key | {limit}
    wide, narrow = strata(whole - {limit}), strata(whole)
    own: Own = ("limit", limit)
    if stratum.key == whole:
        inner = _regular(wide, _without(stratum, point.x, limit))
        along = point
    else:
        inner = point
        along = _regular(narrow, _with(narrow, stratum, point.x, limit))
    rate = inner.margins_s[limit]
    if rate:
        yield Half(wide.key, inner if rate > 0 else turned(inner), own)
    yield from _both(narrow, along, own)


def _without(stratum: Stratum, x: Array, limit: tuple[int, int]) -> Array:
    return np.delete(x, stratum.multiplier(limit))


def _with(narrow: Stratum, stratum: Stratum, x: Array, limit: tuple[int, int]) -> Array:
    return np.insert(x, narrow.multiplier(limit), 0.0)


def _at_corner(strata: Strata, stratum: Stratum, point: Point, key: Active) -> Iterator[Half]:
    for limit in sorted(key):
        other = strata(key - {limit})
        x = point.x if other.key == stratum.key else balanced(other, point.x[: stratum.n])
        try:
            here = point if other.key == stratum.key else _isolated(other, x)
        except NoPoint:
            continue
        rate = here.margins_s[limit]
        if rate:
            yield Half(other.key, here if rate > 0 else turned(here), ("limit", limit))


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
