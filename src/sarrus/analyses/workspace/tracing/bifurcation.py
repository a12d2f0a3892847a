"""At a point where candidate curves cross: all their tangents, from the algebraic bifurcation equation.

Where the rank of the outputs' gradients drops by two, as with two legs stretched at once, any normal will do at this
position; curves with the normals c begin where the second-order form on the free directions is singular, a generalized
eigenvalue problem. With two null vectors t of G_x and the left null vector psi: c11 a² + 2 c12 a b + c22 b² = 0,
c_ij = psi·G_xx[t_i, t_j], with exact second derivatives of G, which hold third derivatives of Φ.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigvals

from ....algebra import Array
from ....linalg.svd import singular
from .stratum import Linear, Stratum

DROPS = 1e-6  # of a singular value, relative to the largest, that counts as zero
FLAT = 1e-9  # of a coefficient, relative to the largest
AT_REST = 1e-8  # of a direction in which only multipliers change


def directions(stratum: Stratum, x: Array, linear: Linear) -> list[Array]:
    """Unit tangents (size,) of the curves through x, each in one of its two senses."""
    left, _, right = singular(linear.G_x)
    psi, one, other = left[:, -1], right[-1], right[-2]
    c = [float(psi @ stratum.second(x, s, t)) for s, t in ((one, one), (one, other), (other, other))]
    found = [a * one + b * other for a, b in _roots(*c)]
    return [
        t / np.linalg.norm(t) for t in found if np.linalg.norm(t[: stratum.n]) > AT_REST * np.linalg.norm(t)
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
    if size == 0 or discriminant < -FLAT * size * size:
        return []
    root = max(discriminant, 0.0) ** 0.5
    if max(abs(c11), abs(c22)) <= FLAT * size:
        return [(1.0, 0.0), (0.0, 1.0)]
    if abs(c11) >= abs(c22):
        return [(-c12 + root, c11), (-c12 - root, c11)]
    return [(c22, -c12 + root), (c22, -c12 - root)]
