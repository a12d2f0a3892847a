"""The functions that are differentiated, from their definitions, for any number: CasADi's symbols, JAX's tracers.

Vectors are lists of scalars. Nothing here is taken from Sarrus's kernels, so that equal derivatives also check them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Vector = Sequence[Any]


def dot(a: Vector, b: Vector) -> Any:
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rotate(p: Vector, a: Vector) -> list[Any]:
    """A(p) a, Eq. (9)."""
    e0, e = p[0], p[1:4]
    k, m, c = 2 * e0 * e0 - 1, 2 * dot(e, a), cross(e, a)
    return [k * a[n] + m * e[n] + 2 * e0 * c[n] for n in range(3)]


def point(x: Vector, s: Vector) -> list[Any]:
    return [r + d for r, d in zip(x[:3], rotate(x[3:7], s), strict=True)]


def separation(x: Vector, s_i: Vector, s_j: Vector) -> list[Any]:
    """From P_i to P_j, for the coordinates of two bodies."""
    return [b - a for a, b in zip(point(x[:7], s_i), point(x[7:], s_j), strict=True)]


def spherical(x: Vector, n: Vector) -> list[Any]:
    return separation(x, n[:3], n[3:])


def dot1(x: Vector, n: Vector) -> list[Any]:
    return [dot(rotate(x[3:7], n[:3]), rotate(x[10:], n[3:]))]


def dot2(x: Vector, n: Vector) -> list[Any]:
    """The reduced form, Eq. (88)."""
    h = [b - a for a, b in zip(x[:3], point(x[7:], n[6:9]), strict=True)]
    return [dot(rotate(x[3:7], n[:3]), h) - dot(n[:3], n[3:6])]


def distance(x: Vector, n: Vector) -> list[Any]:
    d = separation(x, n[:3], n[3:6])
    return [dot(d, d) - n[6] * n[6]]


def normalization(x: Vector, n: Vector) -> list[Any]:
    return [dot(x[3:7], x[3:7]) - 1]


def turn(p: Vector, pd: Vector) -> list[Any]:
    """G(p) ṗ."""
    c = cross(p[1:], pd[1:])
    return [-pd[0] * p[1 + n] - c[n] + p[0] * pd[1 + n] for n in range(3)]


def turn_T(p: Vector, y: Vector) -> list[Any]:
    """Gᵀ(p) y."""
    c = cross(p[1:], y)
    return [-dot(p[1:], y), *(c[n] + p[0] * y[n] for n in range(3))]


def momentum_rate(x: Vector, n: Vector, a: Vector) -> list[Any]:
    """M a of a rigid body, Eq. (5): [m a_r; 4 GᵀJG a_p]."""
    xx, yy, zz, xy, xz, yz = (n[k] for k in range(1, 7))
    w = turn(x[3:7], a[3:7])
    y = [dot(line, w) for line in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))]
    return [*(n[0] * a[k] for k in range(3)), *(4 * u for u in turn_T(x[3:7], y))]


def tsda(x: Vector, v: Vector, n: Vector, sqrt: Any, gradient: Any, along: Any) -> list[Any]:
    """Q = -f l_qᵀ, Eq. (63), with l_q and l̇ by the backend's differentiation."""

    def length(y: Vector) -> list[Any]:
        d = separation(y, n[:3], n[3:6])
        return [sqrt(dot(d, d))]

    size, l_dot = length(x)[0], along(length, x, v)[0]
    f = n[6] * (size - n[8]) + n[7] * l_dot + n[9]
    return [-f * part for part in gradient(length, x)]


def tyre(x: Vector, v: Vector, n: Vector, sqrt: Any, gradient: Any, along: Any) -> list[Any]:
    """F = k (R - z) - c ż upwards at the wheel centre."""

    def height(y: Vector) -> list[Any]:
        return [point(y, n[:3])[2]]

    force = n[3] * (n[5] - (height(x)[0] - n[6])) - n[4] * along(height, x, v)[0]
    return [force * part for part in gradient(height, x)]


CONSTRAINTS = {
    "Spherical": spherical,
    "Dot1": dot1,
    "Dot2": dot2,
    "Distance": distance,
    "Normalization": normalization,
}
FORCES = {"TSDA": tsda, "Tyre": tyre}
