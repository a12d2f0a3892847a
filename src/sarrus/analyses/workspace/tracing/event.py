"""Events between two points of a candidate curve, and their exact location."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import comb
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ..problem.settle import CLOSE
from .point import Point, Step, point_at
from .stratum import Limit, NoPoint, Row, Stratum, Tangents, bordered, correct, plane, signs

Own = tuple[str, Limit | None] | None  # the event at which a curve begins
STILL = (("cusp", None), ("branch", None))  # where the outputs may stand still at the beginning
NEAR = 1e-9  # of a step: so near to a crossing, where the equations are singular, it is located
SLACK = 1e-10  # of a limit that counts as satisfied, free of units
POWERS = np.arange(6)
# Coefficients of a quintic in Bernstein's form, between whose least and largest it stays, from those of its powers
BERNSTEIN = np.array([[comb(n, k) / comb(5, k) for k in POWERS] for n in POWERS])


class Event(NamedTuple):
    """An event at a point between two others, at tau = 0 ... 1.

    `kind` is "hit" (a limit is reached), "release" (its multiplier vanishes), "cusp" (the outputs stand still),
    "branch" (curves cross) or "closed"; `limit` which limit is meant.
    """

    tau: float
    kind: str
    limit: Limit | None
    point: Point


def first_event(stratum: Stratum, step: Step, own: Own, start: Point | None) -> Event | None:
    """The first event of a step; `own` is the event at which the curve began, which its first step leaves.

    Raises
    ------
    NoPoint
        If something happens that cannot be located: the step is too long.
    """
    found = [*_hits(stratum, step, own), *_releases(stratum, step, own), *_turns(stratum, step, own)]
    closed = None if start is None else _closing(stratum, step, start)
    found += [] if closed is None else [closed]
    return min(found, key=lambda event: event.tau, default=None)


def _turns(stratum: Stratum, step: Step, own: Own) -> Iterator[Event]:
    """Crossings of curves, and cusps."""
    reverses = _reverses(stratum, step)
    if step.a.tangent.sign * step.b.tangent.sign < 0 and own != STILL[1]:
        yield _by_bracket(stratum, step, "branch", _speed if reverses else _determinant(stratum))
    elif reverses and own not in STILL:
        yield _by_bracket(stratum, step, "cusp", _speed)


def _reverses(stratum: Stratum, step: Step) -> bool:
    """Whether the outputs turn back; where they stand still all along, signs of their speed mean nothing."""
    a, b = step.a.speed, step.b.speed
    return stratum.problem.has_cusps and a * b < 0 and max(abs(a), abs(b)) > SLACK


def _hits(stratum: Stratum, step: Step, own: Own) -> Iterator[Event]:
    a, b = step.a, step.b
    if not a.margins.size:
        return
    margins = step.margins()
    for i, end in zip(*np.nonzero(_may_sink(margins)), strict=True):
        limit = (int(i), int(end))
        if limit in stratum.key or (int(i), 1 - int(end)) in stratum.key:
            continue
        mine = own == ("limit", limit)
        if mine and b.margins[limit] < -SLACK:
            raise NoPoint("a limit is reached at once")
        tau = _sinks(margins[:, i, end], mine)
        if tau is not None:
            yield _by_newton(stratum, step, tau, "hit", limit)


def _releases(stratum: Stratum, step: Step, own: Own) -> Iterator[Event]:
    unknowns = step.unknowns() if stratum.active else np.zeros((6, 0))
    for limit in stratum.active:
        k, mine = stratum.multiplier(limit), own == ("limit", limit)
        a, b = step.a.x[k], step.b.x[k]
        if max(abs(a), abs(b)) <= SLACK:  # at a singular configuration: it vanishes all along
            continue
        begins_at_zero = mine or abs(a) <= SLACK
        if mine and b * step.a.t[k] < 0:
            raise NoPoint("a multiplier vanishes at once")
        tau = _sinks(unknowns[:, k] * np.sign(step.a.t[k] if begins_at_zero else a), begins_at_zero)
        if tau is None and a * b < 0 and not begins_at_zero:
            tau = a / (a - b)
        if tau is not None:
            yield _by_newton(stratum, step, tau, "release", limit)


def _may_sink(polynomials: Array) -> Array:
    """Which polynomials (6, ...) may become negative in 0 ... 1."""
    return np.asarray(np.tensordot(BERNSTEIN, polynomials, axes=1).min(axis=0) < -SLACK)


def _sinks(polynomial: Array, from_zero: bool) -> float | None:
    """Where in 0 ... 1 a polynomial (6,) becomes negative, after its zero at 0 if it begins there."""
    if not _may_sink(polynomial):
        return None
    slope = polynomial[1:] * np.arange(1, 6)
    extremes = [tau for tau in _zeros(slope) if 0 < tau < 1]
    if min(float(tau**POWERS @ polynomial) for tau in (*extremes, 1.0)) >= -SLACK:
        return None
    zeros = _zeros(polynomial[1:] if from_zero else polynomial)
    return min((tau for tau in zeros if tau ** POWERS[:5] @ slope <= 0), default=0.5)


def _zeros(polynomial: Array) -> list[float]:
    """Real zeros of a polynomial in 0 ... 1."""
    roots = np.roots(polynomial[::-1])
    return [r.real for r in roots if abs(r.imag) < 1e-6 and -1e-9 <= r.real <= 1 + 1e-9]


def _by_newton(stratum: Stratum, step: Step, tau: float, kind: str, limit: Limit) -> Event:
    """The point near tau at which a limit is reached, or its multiplier vanishes."""
    row = _limit_row(stratum, limit) if kind == "hit" else _multiplier_row(stratum, limit)
    x, linear = correct(stratum, step.x(tau), row)
    tau = float(step.a.t @ (x - step.a.x)) / step.length
    away = np.linalg.norm(x - step.x(min(max(tau, 0.0), 1.0)))
    if not -1e-6 <= tau <= 1 + 1e-6 or away > 0.3 * step.length:
        raise NoPoint("the event lies on another curve")
    return Event(tau, kind, limit, point_at(stratum, x, linear, step.a.t))


def _limit_row(stratum: Stratum, limit: Limit) -> Row:
    p, (i, end) = stratum.problem, limit
    at = p.m + p.limited[i]

    def row(x: Array, linear: Tangents) -> tuple[float, Array]:
        gradient = np.append(linear.J[at], np.zeros(stratum.size - stratum.n))
        return float(linear.values[at] - p.bounds[i, end]), gradient

    return row


def _multiplier_row(stratum: Stratum, limit: Limit) -> Row:
    unit = np.zeros(stratum.size)
    unit[stratum.multiplier(limit)] = 1.0
    return lambda x, linear: (float(unit @ x), unit)


def _speed(point: Point) -> float:
    return point.speed


def _determinant(stratum: Stratum) -> Callable[[Point], float]:
    """A smooth function with the sign of det [G_x; t], from a bordered system with fixed borders."""
    column, last = np.random.default_rng(1).normal(size=(2, stratum.size + 1))

    def value(point: Point) -> float:
        square = bordered(stratum.linear(point.x).G_x, point.t)
        whole = np.block([[square, column[:-1, None]], [last]])
        return float(np.linalg.solve(whole, np.append(np.zeros(len(square)), 1.0))[-1])

    return value


def _by_bracket(stratum: Stratum, step: Step, kind: str, value: Callable[[Point], float]) -> Event:
    """The zero of a function of the points between the ends, by Brent's method."""
    from scipy.optimize import brentq  # 0.2 s to import, and only some curves need it

    found = {0.0: step.a, 1.0: step.b}

    def at(tau: float) -> float:
        if tau not in found:
            through = plane(step.a.x + tau * step.length * step.a.t, step.a.t)
            x, linear = correct(stratum, step.x(tau), through)
            found[tau] = point_at(stratum, x, linear, step.a.t)
        return value(found[tau])

    if at(0.0) * at(1.0) > 0:
        raise NoPoint("no change of sign")
    try:
        tau = brentq(at, 0.0, 1.0, xtol=NEAR if kind == "branch" else CLOSE)
        at(tau)
    except NoPoint:
        inner = [one for one in found if 0 < one < 1]
        if kind != "branch" or not inner:
            raise
        tau = inner[-1]  # so near to a crossing the equations are singular
    return Event(tau, kind, None, found[tau])


def _closing(stratum: Stratum, step: Step, start: Point) -> Event | None:
    """Back at the start, with the same or turned signs."""
    flip = signs(stratum, start.x, step.b.x)
    back = flip * start.x
    tau = float(step.a.t @ (back - step.a.x)) / step.length
    if not -1e-9 <= tau <= 1 + 1e-9 or np.linalg.norm(back - step.x(tau)) > 0.02 * step.length:
        return None
    x, linear = correct(stratum, step.x(tau), plane(back, step.a.t))
    if np.linalg.norm(x - back) > 1e-6:
        return None
    return Event(tau, "closed", None, point_at(stratum, x, linear, step.a.t))
