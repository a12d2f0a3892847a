"""Inertia of a rigid body whose centre of mass lies away from its frame, at r + A c.

    M = [m I, m B; m Bᵀ, m BᵀB + 4 GᵀJG],    S = [-m x; -m Bᵀx + 8 ĠᵀJĠp],  B = B(p, c), x = B(ṗ, c) ṗ

J about the centre of mass in body axes. Exactly Lagrange's equations for any p; c = 0 gives `RigidInertia`.
"""

from __future__ import annotations

from ..algebra import I3, Array, Row, column
from ..euler import B, C, D, G, K
from .element import Grid, Inertia, InertiaElement, Scalar, Single, Vec3
from .rotation import J_b, gyroscopic, gyroscopic_p, gyroscopic_v, rotational_mass, rotational_mass_a_p


class EccentricInertia(InertiaElement):
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

    def S_b(self, x: Single, v: Single) -> Grid:
        B_c, centripetal, c = B(x.p, self.center), B(v.p, self.center) @ v.p, C(v.p, v.p)
        by_center = -self.mass * (K(x.p, centripetal) + B_c.T @ c)
        by_inertia = 8 * (G(v.p).T @ J_b(G(v.p) @ x.p))
        return (
            (column(-centripetal), None, -self.mass * c),
            (column(-(B_c.T @ centripetal)), by_inertia, by_center),
        )
