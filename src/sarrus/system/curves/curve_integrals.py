"""Integrals of stored curves from a point on, exact to round-off also for laws with narrow features.

Outwards from the point the argument is divided into cells, each as wide as all that are nearer. These are halved until
Gauss's rule agrees with that of both halves, and until every function in a formula is resolved: its own argument
hardly changes within a panel, so that no peak, however narrow, is passed over. The panels do not depend on the upper
limits of the integrals, of which many have their whole panels in common.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..._jit.formulas import curves
from ...algebra import Array
from ...model.laws.curve import in_period, repeated

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
PLACES, SHARES = (NODES + 1) / 2, WEIGHTS / 2  # within a panel
SEEN = np.concatenate([[0.0], PLACES, [1.0]])  # where arguments of functions are looked at
NEAREST = 2.0**-80  # length of the first cell, below any deflection
PRECISION = 1e-11  # between one panel and its halves, of the integral over a cell of the law without its sign
LEVELS = 46  # halvings of a cell
MOST = 2**14  # panels
KNOWN = 256  # divisions that are stored
BINARY = {curves.ADD: np.add, curves.SUB: np.subtract, curves.MUL: np.multiply, curves.DIV: np.divide}
UNARY: dict[int, Callable[[Array], Array]] = {
    curves.NEG: np.negative, curves.SQRT: np.sqrt, curves.SIN: np.sin, curves.COS: np.cos, curves.TAN: np.tan,
    curves.ASIN: np.arcsin, curves.ACOS: np.arccos, curves.ATAN: np.arctan, curves.EXP: np.exp, curves.LOG: np.log,
    curves.TANH: np.tanh, curves.POSITIVE: lambda x: np.where(x > 0, 1.0, 0.0),
    curves.NEAREST: lambda x: np.floor(x + 0.5),
}  # fmt: skip
CHANGE = {
    **dict.fromkeys((curves.SIN, curves.COS, curves.EXP, curves.TANH), 4.0), curves.ATAN: 1.0, curves.TAN: 0.5
}  # fmt: skip
# Of the largest to the smallest argument of a root, a logarithm, an inverse tangent; of a divisor
RATIO = 4.0
SCALED = (curves.SQRT, curves.LOG, curves.ATAN, curves.DIV)
CONSTANT = {curves.EXP: (-80.0, np.inf), curves.TANH: (-20.0, 20.0)}  # below and above these arguments

Law = tuple[float, ...]  # a curve as it is stored


def law_at(numbers: Array, at: int) -> Law:
    """The curve that is stored from ``numbers[at]`` on."""
    n = int(numbers[at])
    return tuple(numbers[at : at + (5 * n + 2 if n > 0 else 1 - 3 * n)].tolist())


def moments(law: Law, a: Any, b: Any, power: int) -> Array:
    """The integrals from a to b of a curve times (x - a)ᵖ, for arrays of limits of one shape."""
    a, b = np.broadcast_arrays(np.asarray(a, dtype=float), np.asarray(b, dtype=float))
    rule = Quadrature(law, a.ravel(), b.ravel())
    return rule(_value(law, rule.x) * rule.arm**power).reshape(a.shape)


class _Group(NamedTuple):
    """Limits with the same lower one on the same side of it: their places, and the last panel of each."""

    places: Array
    last: Array
    points: slice
    panels: int


class Quadrature:
    """Points at which a law is evaluated, and weights for its integrals from a to b (nt,).

    Attributes
    ----------
    x, arm : (n,) the points, and x - a
    """

    def __init__(self, law: Law, a: Array, b: Array) -> None:
        self._count, self._groups, begin = len(a), list[_Group](), 0
        x, arms, weights = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
        for start in np.unique(a):
            for side in (-1.0, 1.0):
                places = np.flatnonzero((a == start) & ((b < start) if side < 0 else (b >= start)))
                if not len(places):
                    continue
                reach = abs(b[places] - start)
                ends = panels(law, float(start), side, float(reach.max()))
                last = np.clip(np.searchsorted(ends, reach, side="right") - 1, 0, len(ends) - 2)
                whole = int(last.max())
                low = np.concatenate([ends[:whole], ends[last]])
                width = np.concatenate([np.diff(ends[: whole + 1]), reach - ends[last]])
                u = (low[:, None] + width[:, None] * PLACES).ravel()
                x, arms = [*x, start + side * u], [*arms, side * u]
                weights.append(side * (width[:, None] * SHARES).ravel())
                self._groups.append(_Group(places, last, slice(begin, begin + len(u)), whole))
                begin += len(u)
        self.x, self.arm, self._weights = map(np.concatenate, (x, arms, weights))

    def __call__(self, values: Array) -> Array:
        """The integrals (..., nt) of values at the points (..., n)."""
        weighed, found = values * self._weights, np.zeros((*values.shape[:-1], self._count))
        for places, last, points, whole in self._groups:
            sums = weighed[..., points].reshape(*values.shape[:-1], -1, len(PLACES)).sum(axis=-1)
            nearer = np.zeros((*values.shape[:-1], whole + 1))
            np.cumsum(sums[..., :whole], axis=-1, out=nearer[..., 1:])
            found[..., places] = nearer[..., last] + sums[..., whole:]
        return found


def panels(law: Law, start: float, side: float, reach: float) -> Array:
    """Distances from `start` to one side, rising from zero on, at which panels end; the last one is beyond `reach`."""
    if law[0] > 0:
        knots = np.array(law[2 : 1 + int(law[0])])  # but for the first and the last
        if law[0] > int(law[0]):
            knots = repeated(np.array(law[1 : 2 + int(law[0])]), *sorted((start, start + side * reach)))
        knots = side * (knots - start)
        return np.unique(np.concatenate([[0.0], knots[knots > 0], [2 * max(reach, NEAREST)]]))
    return _of_formula(law, start, side, int(np.ceil(np.log2(max(reach, NEAREST) / NEAREST))) + 1)


@lru_cache(KNOWN)
def _of_formula(law: Law, start: float, side: float, cells: int) -> Array:
    low = np.concatenate([[0.0], NEAREST * 2.0 ** np.arange(cells - 1)])
    high, cell = NEAREST * 2.0 ** np.arange(cells), np.arange(cells)
    done, sizes, ends = np.zeros(cells), np.zeros(cells), [low[:1]]
    for level in range(LEVELS + 1):
        seen, one, both, size = _looked_at(law, start, side, low, high)
        sizes = done + np.bincount(cell, size, cells)
        divided = ~seen | (abs(one - both) > PRECISION * sizes[cell])
        if level == LEVELS or 2 * int(divided.sum()) + sum(map(len, ends)) > MOST:
            divided[:] = False
        ready, middle = ~divided, 0.5 * (low + high)
        done += np.bincount(cell[ready], size[ready], cells)
        ends += [middle[ready], high[ready]]
        low, high = (
            np.concatenate([low[divided], middle[divided]]),
            np.concatenate([middle[divided], high[divided]]),
        )
        cell = np.tile(cell[divided], 2)
        if not len(low):
            break
    return np.sort(np.concatenate(ends))


def _looked_at(
    law: Law, start: float, side: float, low: Array, high: Array
) -> tuple[Array, Array, Array, Array]:
    """Of each panel: whether it is resolved, its integral by one rule and by two, and that without sign."""
    width = (high - low)[:, None]
    steps = _steps(law, start + side * (low[:, None] + width * SEEN))
    seen, one = _resolved(law, steps), width[:, 0] * (steps[-1][:, 1:-1] @ SHARES)
    halves = np.concatenate([0.5 * PLACES, 0.5 + 0.5 * PLACES])
    values = _finite(_value(law, start + side * (low[:, None] + width * halves)))
    both, size = (0.5 * width[:, 0] * (x @ np.tile(SHARES, 2)) for x in (values, abs(values)))
    return seen, _finite(one), both, size


def _finite(x: Array) -> Array:
    return np.where(np.isfinite(x), x, 0.0)


def _resolved(law: Law, steps: list[Array]) -> Array:
    """Whether all functions of a formula change little in panels, of its steps at the points seen (n, 10)."""
    known = np.isfinite(steps[-1])
    found = known.all(axis=1) | ~known.any(axis=1)  # an end of where it is defined is approached
    for k in range(len(steps)):
        code, first, second = (int(x) for x in law[1 + 3 * k : 4 + 3 * k]) if law[1 + 3 * k] else (0, 0, 0)
        if code not in CHANGE and code not in SCALED and code not in (curves.POSITIVE, curves.NEAREST):
            continue
        u = steps[second if code == curves.DIV else first]
        least, most = u.min(axis=1), u.max(axis=1)
        alike = (least > 0) & (most <= RATIO * least) | (most < 0) & (least >= RATIO * most)
        own = most - least <= CHANGE.get(code, 0.0)
        if code in (curves.POSITIVE, curves.NEAREST):
            own = UNARY[code](least) == UNARY[code](most)
        if code in SCALED:
            own |= alike
        elif code in CONSTANT:
            below, above = CONSTANT[code]
            own |= alike & ((most < below) | (least > above))
        found &= own | ~known.any(axis=1)
    return np.asarray(found)


def _value(law: Law, x: Array) -> Array:
    """A curve's values (n,) or of any shape."""
    if law[0] < 0:
        return _steps(law, x)[-1]
    n = int(law[0])
    knots, cubics = np.array(law[1 : n + 2]), np.array(law[n + 2 :]).reshape(n, 4)
    x = in_period(knots, x) if law[0] > n else x
    piece = np.searchsorted(knots[1:-1], x, side="right")
    c3, c2, c1, c0 = cubics[piece].T
    u = x - knots[piece]
    return np.asarray(((c3 * u + c2) * u + c1) * u + c0)


def _steps(law: Law, x: Array) -> list[Array]:
    """The result of each step of a formula, of the shape of x."""
    found: list[Array] = []
    with np.errstate(all="ignore"):
        for k in range(-int(law[0])):
            code, first, second = law[1 + 3 * k : 4 + 3 * k]
            if code == curves.CONSTANT:
                value: Any = first
            elif code == curves.INPUT:
                value = x
            elif code in BINARY:
                value = BINARY[int(code)](found[int(first)], found[int(second)])
            else:
                value = UNARY[int(code)](found[int(first)])
            found.append(np.broadcast_to(np.asarray(value, dtype=float), np.shape(x)))
    return found
