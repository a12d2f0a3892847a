"""Vertices of candidate curves: the curves that begin there, and their directions.

At the end of a curve with the limits S active, limit i is reached: curves with S + {i} go both ways. Where a multiplier
vanishes, it is the other way round: three half curves meet, one of S, two of S + {i}. Where no freedom is left with
S + {i}, each of its limits can be left instead.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from ....algebra import Array
from ....linalg.svd import singular
from .bifurcation import DROPS, directions, normals
from .event import Event
from .newton import NoPoint, Tally, Tangent, tangent
from .point import Point, point_with
from .same_point import SAME, apart, body_signs
from .stratum import Active, Stratum

Strata = Callable[[Active], Stratum]
AT_REST = 1e-6
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


def vertex_of(strata: Strata, stratum: Stratum, event: Event, tally: Tally) -> Vertex:
    """The vertex of an event, with all that begins there."""
    kind, key, limit = describe(stratum, event)
    x, u = event.point.x, event.point.u
    vertex = Vertex(kind, x[: stratum.n], key, limit, u)
    if kind == "end":
        vertex.halves = [Half(key, turned(event.point), ("limit", limit))]
    elif kind == "limit":
        assert limit is not None
        vertex.halves = list(_at_limit(strata, stratum, event.point, limit, tally))
    elif kind == "corner":
        vertex.halves = list(_at_corner(strata, stratum, event.point, key, tally))
    elif kind == "cusp":
        vertex.halves = list(_both(stratum, event.point, ("cusp", None)))
    elif kind == "branch":
        vertex.halves = list(_at_branch(stratum, event.point, tally))
    return vertex


def loses_rank(stratum: Stratum, q: Array) -> bool:
    """Whether constraints, held functions and active limits are dependent: motion is not determined to first order."""
    sizes = singular(stratum.problem.jacobian(q)[stratum.rows])[1]
    return bool(sizes[-1] < DROPS * sizes[0])


def seed(stratum: Stratum, x: Array, tally: Tally) -> Vertex:
    """A vertex at a regular point of a curve, from which both ways begin.

    Raises
    ------
    NoPoint
        If the position does not move along the curve, but only its normal, or if it is on no single curve.
    """
    point = _isolated(stratum, x, tally)
    if np.linalg.norm(point.t[: stratum.n]) < AT_REST:
        raise NoPoint("the position does not move along this curve")
    return Vertex("seed", x[: stratum.n], stratum.key, None, point.u, list(_both(stratum, point, None)))


def _regular(stratum: Stratum, x: Array, tally: Tally) -> Point:
    linear = stratum.linear(x)
    along = singular(linear.G_x)[2][-1]
    return point_with(stratum, x, linear, tangent(stratum, x, linear, along, tally), tally)


def _isolated(stratum: Stratum, x: Array, tally: Tally) -> Point:
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
    if len(free) > 1 and np.linalg.norm(outputs @ free.T) < AT_REST:
        raise NoPoint("the outputs stand still along this curve")
    return _regular(stratum, x, tally)


def _both(stratum: Stratum, point: Point, own: Own) -> Iterator[Half]:
    yield Half(stratum.key, point, own)
    yield Half(stratum.key, turned(point), own)


def turned(point: Point) -> Point:
    """The same point with the curve run through the other way."""
    t = point.tangent
    other = t._replace(t=-t.t, sign=-t.sign)
    return replace(point, tangent=other, u_s=-point.u_s, margins_s=-point.margins_s)


def _at_limit(
    strata: Strata, stratum: Stratum, point: Point, limit: tuple[int, int], tally: Tally
) -> Iterator[Half]:
    whole = stratum.key | {limit}
    wide, narrow = strata(whole - {limit}), strata(whole)
    own: Own = ("limit", limit)
    if stratum.key == whole:
        inner = _regular(wide, _without(stratum, point.x, limit), tally)
        along = point
    else:
        inner = point
        along = _regular(narrow, _with(narrow, stratum, point.x, limit), tally)
    rate = inner.margins_s[limit]
    if rate:
        yield Half(wide.key, inner if rate > 0 else turned(inner), own)
    yield from _both(narrow, along, own)


def _without(stratum: Stratum, x: Array, limit: tuple[int, int]) -> Array:
    return np.delete(x, stratum.multiplier(limit))


def _with(narrow: Stratum, stratum: Stratum, x: Array, limit: tuple[int, int]) -> Array:
    return np.insert(x, narrow.multiplier(limit), 0.0)


def _at_corner(strata: Strata, stratum: Stratum, point: Point, key: Active, tally: Tally) -> Iterator[Half]:
    for limit in sorted(key):
        other = strata(key - {limit})
        x = point.x if other.key == stratum.key else balanced(other, point.x[: stratum.n])
        try:
            here = point if other.key == stratum.key else _isolated(other, x, tally)
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


def _at_branch(stratum: Stratum, point: Point, tally: Tally) -> Iterator[Half]:
    several = normals(stratum, point.x[: stratum.n]) if stratum.problem.of_outputs else []
    for x in several or [point.x]:
        linear = stratum.linear(x)
        for t in directions(stratum, x, linear):
            here = point_with(stratum, x, linear, Tangent(t, np.zeros_like(t), 0.0, False), tally)
            yield from _both(stratum, here, ("branch", None))
