"""Rotations in NumPy: Euler parameters, matrices, rates, perpendicular vectors."""

from __future__ import annotations

import numpy as np

from ...algebra import cross
from ..quantity import Array


def skew(e: Array) -> Array:
    """Return ẽ with ẽ x = e × x, Eq. (8). (3, 3)"""
    return np.array([[0.0, -e[2], e[1]], [e[2], 0.0, -e[0]], [-e[1], e[0], 0.0]])


def matrix(p: Array) -> Array:
    """Return A(p), body axes to global axes, Eq. (9). (3, 3) [-]"""
    e0, x, y, z = np.asarray(p).tolist()  # numbers, plain or traced
    one = 2 * e0 * e0 - 1
    rows = [
        [one + 2 * (x * x), 2 * (x * y - e0 * z), 2 * (x * z + e0 * y)],
        [2 * (x * y + e0 * z), one + 2 * (y * y), 2 * (y * z - e0 * x)],
        [2 * (x * z - e0 * y), 2 * (y * z + e0 * x), one + 2 * (z * z)],
    ]
    return np.array(rows)


def parameters(A: Array) -> Array:
    """Return the unit Euler parameters of a rotation matrix, the largest one positive. (4,) [-]

    The column of the largest diagonal entry of 4 p pᵀ is scaled to unit length: no division
    by a small number occurs for any rotation.
    """
    outer = _four_p_pT(A)
    column: Array = outer[:, int(np.argmax(np.diag(outer)))]
    return column / np.linalg.norm(column)


def product(p: Array, s: Array) -> Array:
    """Return the Euler parameters of A(p) A(s). (4,) [-]"""
    vector = p[0] * s[1:] + s[0] * p[1:] + cross(p[1:], s[1:])
    return np.array([p[0] * s[0] - p[1:] @ s[1:], *vector])


def rates(p: Array, omega: Array) -> Array:
    """Return ṗ = ½ Eᵀ(p) ω for the angular velocity ω in global axes. (4,) [1/s]"""
    e0, e = p[0], p[1:]
    return np.array([-(e @ omega), *(e0 * omega - skew(e) @ omega)]) / 2 + 0.0  # no -0


def perpendicular(h: Array) -> Array:
    """Return a unit vector perpendicular to the unit vector ``h``: the nearest to a coordinate axis. (3,)"""
    k = int(np.argmin(np.abs(h)))
    across: Array = np.eye(3)[k] - h[k] * h
    return across / np.linalg.norm(across)


def _four_p_pT(A: Array) -> Array:
    t = np.trace(A)
    w = np.array([A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]])
    lower = A + A.T + (1 - t) * np.eye(3)
    return np.block([[np.array([[1 + t]]), w[None, :]], [w[:, None], lower]])
