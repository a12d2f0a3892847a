"""Inertia of a rigid body, about its centre of mass or about another origin.

Eqs. (5), (51)-(58), with their factors 4 and 8. With the centre of mass at the origin of the frame:

    M = diag(m I, 4 GᵀJG),    S = [0; 8 ĠᵀJĠ p],  Ġ = G(ṗ)

with the centre of mass at r + A c:

    M = [m I, m B; m Bᵀ, m BᵀB + 4 GᵀJG],    S = [-m x; -m Bᵀx + 8 ĠᵀJĠp],  B = B(p, c), x = B(ṗ, c) ṗ

J about the centre of mass in body axes. Exactly Lagrange's equations for any p; c = 0 gives the first.
"""

from __future__ import annotations

import numpy as np

from ..algebra import I3, Array, Row, column
from ..euler import B, C, D, G, K, bar
from .element import Grid, Inertia, InertiaElement, Scalar, Single, Vec3


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


class EccentricInertia(InertiaElement, derivatives="automatic"):
    """Mass [kg], inertia tensor about the centre of mass [kg m²] and the centre of mass in the body [m]."""

    mass: Scalar  # [kg]
    inertia: Inertia  # [kg m²] about the centre of mass
    center: Vec3  # [m] centre of mass in body axes

    def _acceleration(self, x: Single, a: Single) -> Array:
        return a.r + B(x.p, self.center) @ a.p

    def M(self, x: Single) -> Grid:
        B_c = B(x.p, self.center)
        mB = self.mass * B_c
        return (self.mass * I3, mB), (mB.T, B_c.T @ mB + rotational_mass(self.inertia, x.p))

    def M_a_q(self, x: Single, a: Single) -> Grid:
        mBa = self.mass * B(a.p, self.center)
        pp = self.mass * D(self.center, self._acceleration(x, a)) + B(x.p, self.center).T @ mBa
        return (None, mBa), (None, pp + rotational_mass_a_p(self.inertia, x.p, a.p))

    def M_a_b(self, x: Single, a: Single) -> Grid:
        B_c, y, c = B(x.p, self.center), self._acceleration(x, a), C(x.p, a.p)
        by_center = self.mass * (K(x.p, y) + B_c.T @ c)
        by_inertia = 4 * (G(x.p).T @ J_b(G(x.p) @ a.p))
        return (column(y), None, self.mass * c), (column(B_c.T @ y), by_inertia, by_center)

    def S(self, x: Single, v: Single) -> Row:
        mx = self.mass * (B(v.p, self.center) @ v.p)
        return -mx, gyroscopic(self.inertia, x.p, v.p) - B(x.p, self.center).T @ mx

    def S_q(self, x: Single, v: Single) -> Grid:
        curvature = self.mass * D(self.center, B(v.p, self.center) @ v.p)
        return (None, None), (None, gyroscopic_p(self.inertia, v.p) - curvature)

    def S_v(self, x: Single, v: Single) -> Grid:
        mB = 2 * self.mass * B(v.p, self.center)
        return (None, -mB), (None, gyroscopic_v(self.inertia, x.p, v.p) - B(x.p, self.center).T @ mB)


class RigidInertia(InertiaElement, derivatives="automatic"):
    """Mass [kg] and inertia tensor (xx, yy, zz, xy, xz, yz) [kg m²] about the frame's origin, the centre of mass."""

    mass: Scalar  # [kg]
    inertia: Inertia  # [kg m²] entries of the tensor: xy is -∫xy dm

    def M(self, x: Single) -> Grid:  # Eq. (5)
        return (self.mass * I3, None), (None, rotational_mass(self.inertia, x.p))

    def M_a_q(self, x: Single, a: Single) -> Grid:  # Eq. (56), four times
        return (None, None), (None, rotational_mass_a_p(self.inertia, x.p, a.p))

    def M_a_b(self, x: Single, a: Single) -> Grid:
        return (column(a.r), None), (None, 4 * (G(x.p).T @ J_b(G(x.p) @ a.p)))

    def S(self, x: Single, v: Single) -> Row:  # Eq. (5)
        return None, gyroscopic(self.inertia, x.p, v.p)

    def S_q(self, x: Single, v: Single) -> Grid:  # Eq. (57), eight times
        return (None, None), (None, gyroscopic_p(self.inertia, v.p))

    def S_v(self, x: Single, v: Single) -> Grid:  # Eq. (58), eight times
        return (None, None), (None, gyroscopic_v(self.inertia, x.p, v.p))
