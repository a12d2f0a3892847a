"""The rotational inertia terms that both inertia elements share. Eqs. (5), (51)-(58) with their factors 4 and 8."""

from __future__ import annotations

import numpy as np

from ..algebra import Array
from ..euler import G, bar


def tensor(inertia: Array) -> Array:
    """The symmetric tensor J of (xx, yy, zz, xy, xz, yz)."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def J_b(w: Array) -> Array:
    """Derivative of J w to the six entries of the tensor (3x6)."""
    x, y, z = w
    return np.array([[x, 0, 0, y, z, 0], [0, y, 0, x, 0, z], [0, 0, z, 0, x, y]])


def rotational_mass(inertia: Array, p: Array) -> Array:
    """4 GᵀJG. Eqs. (5), (51)."""
    return 4 * (G(p).T @ tensor(inertia) @ G(p))


def rotational_mass_a_p(inertia: Array, p: Array, a: Array) -> Array:
    """(4 GᵀJG a)_p. Eq. (56), four times."""
    J = tensor(inertia)
    return 4 * (bar(J @ (G(p) @ a)) - G(p).T @ (J @ G(a)))


def gyroscopic(inertia: Array, p: Array, pd: Array) -> Array:
    """8 ĠᵀJĠ p. Eq. (5)."""
    return 8 * (G(pd).T @ (tensor(inertia) @ (G(pd) @ p)))


def gyroscopic_p(inertia: Array, pd: Array) -> Array:
    """(8 ĠᵀJĠ p)_p. Eq. (57), eight times."""
    return 8 * (G(pd).T @ tensor(inertia) @ G(pd))


def gyroscopic_v(inertia: Array, p: Array, pd: Array) -> Array:
    """(8 ĠᵀJĠ p)_ṗ. Eq. (58), eight times, with its sign corrected (see the errata)."""
    J = tensor(inertia)
    return 8 * (bar(J @ (G(pd) @ p)) - G(pd).T @ (J @ G(p)))
