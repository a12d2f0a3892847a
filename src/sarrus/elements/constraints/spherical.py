"""Spherical constraint: point P_i of body i and point P_j of body j coincide. Eqs. (29), (34)-(44)."""

from __future__ import annotations

from ...algebra import I3, Array, Row
from ...euler import B, D, rotate
from ..element import Grid, Pair, Primitive, Vec3


class Spherical(Primitive, rows=3, derivatives="automatic"):
    """Φ = r_j + s_j - r_i - s_i [m]."""

    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j

    def Phi(self, x: Pair) -> Array:  # Eq. (29)
        return x.r_j + rotate(x.p_j, self.s_j) - x.r_i - rotate(x.p_i, self.s_i)

    def Phi_q(self, x: Pair) -> Row:  # Eqs. (34), (35)
        return -I3, -B(x.p_i, self.s_i), I3, B(x.p_j, self.s_j)

    def Phi_q_xi_q(self, x: Pair, xi: Pair) -> Row:  # Eq. (38)
        return None, -B(xi.p_i, self.s_i), None, B(xi.p_j, self.s_j)

    def Phi_q_xi_q_eta_q(self, x: Pair, xi: Pair, eta: Pair) -> Row:  # Eq. (40)
        return None, None, None, None

    def Phi_qT_lam_q(self, x: Pair, lam: Array) -> Grid:  # Eq. (44)
        zero: Row = (None, None, None, None)
        return zero, (None, -D(self.s_i, lam), None, None), zero, (None, None, None, D(self.s_j, lam))

    def Phi_qT_lam_q_xi_q(self, x: Pair, lam: Array, xi: Pair) -> Grid:
        return ((None, None, None, None),) * 4
