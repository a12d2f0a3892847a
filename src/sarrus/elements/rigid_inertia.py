"""Inertia of a rigid body whose frame sits at the centre of mass. Eqs. (5), (51)-(58).

    M = diag(m I, 4 GᵀJG),    S = [0; 8 ĠᵀJĠ p],  Ġ = G(ṗ)

J about the centre of mass in body axes. Exactly Lagrange's equations for any p.
"""

from __future__ import annotations

from ..algebra import I3, Row, column
from ..euler import G
from .element import Grid, Inertia, InertiaElement, Scalar, Single
from .rotation import J_b, gyroscopic, gyroscopic_p, gyroscopic_v, rotational_mass, rotational_mass_a_p


class RigidInertia(InertiaElement):
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

    def S_b(self, x: Single, v: Single) -> Grid:
        return (None, None), (None, 8 * (G(v.p).T @ J_b(G(v.p) @ x.p)))
