"""Multipliers of minimum norm in compiled code, see `minimum_norm`."""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.linking.link import compiled
from ...algebra import Array
from ...linalg.rank import DEPENDENT


class LeftOut(NamedTuple):
    """Equations that are left out because others imply them.

    Attributes
    ----------
    rows : (k,) their places in Φ
    first : (m + 1,) where the numbers of each equation begin in Φ_q, and their end
    columns : the coordinate that each number of Φ_q belongs to
    Phi_q : numbers of all equations at a state
    null : (k, m) combinations of equations that vanish there
    apart, body, point, weight : see `Supports`, where `apart` are the columns
    lengths : `least` and `otherwise`
    force, wrenches : work arrays (7 c,), (k + 1, 6 c)
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
def gradient(others: LeftOut, row: int, force: Array) -> None:
    """Add the gradient of one equation to a force."""
    for entry in range(others.first[row], others.first[row + 1]):
        force[others.columns[entry]] += others.Phi_q[entry]


@compiled
def shorten(others: LeftOut, b: Array, q: Array, lam: Array) -> None:
    """Subtract the part of the multipliers along the combinations, which are made orthonormal (Gram and Schmidt).

    Combinations in which no joint has a force are left out.
    """
    null, wrenches, count, length = others.null, others.wrenches, len(others.null), length_of(others, b)
    for k in range(count):
        size = wrench(others, length, b, q, null[k], wrenches[k])
        for before in range(2 * k):  # twice, for all digits
            subtract(wrenches[before % k], null[before % k], wrenches[k], null[k])
        own = 0.0
        for x in wrenches[k]:
            own += x * x
        scale = own**-0.5 if own > DEPENDENT**2 * size else 0.0
        for n in range(len(wrenches[k])):
            wrenches[k, n] *= scale
        for row in range(len(lam)):
            null[k, row] *= scale
    wrench(others, length, b, q, lam, wrenches[count])
    for k in range(count):
        subtract(wrenches[k], null[k], wrenches[count], lam)


@compiled
def subtract(unit: Array, null: Array, of: Array, lam: Array) -> None:
    """Subtract from `lam`, whose forces and moments are `of`, its part along a combination of unit norm."""
    along = 0.0
    for k in range(len(of)):
        along += unit[k] * of[k]
    for k in range(len(of)):
        of[k] -= along * unit[k]
    for row in range(len(lam)):
        lam[row] -= along * null[row]


@compiled
def length_of(others: LeftOut, b: Array) -> float:
    """The length of the mechanism, see `Supports.length_2`."""
    total, count = 0.0, 0
    for at in others.point:
        if at >= 0:
            total, count = total + b[at] ** 2 + b[at + 1] ** 2 + b[at + 2] ** 2, count + 1
    if total > count * others.lengths[0] ** 2:
        return float((total / count) ** 0.5)
    return float(others.lengths[1])


@compiled
def wrench(others: LeftOut, length: float, b: Array, q: Array, lam: Array, found: Array) -> float:
    """Fill in √w (L F, M) of all joints on their bodies, see `Wrenches`; returns the sum of squares of their terms."""
    y, size = others.force, 0.0
    for k in range(len(y)):
        y[k] = 0.0
    for row in range(len(lam)):
        for entry in range(others.first[row], others.first[row + 1]):
            at, x = others.apart[entry], others.Phi_q[entry] * lam[row]
            y[at] += x
            size += others.weight[at // 7] * (x * (length if at % 7 < 3 else 0.5)) ** 2
    for k in range(len(others.body)):
        p, n, at = others.body[k] + 3, 7 * k, others.point[k]
        e0, e1, e2, e3 = q[p], q[p + 1], q[p + 2], q[p + 3]
        Fx, Fy, Fz, y0, y1, y2, y3 = y[n], y[n + 1], y[n + 2], y[n + 3], y[n + 4], y[n + 5], y[n + 6]
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
