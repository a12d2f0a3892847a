"""DOT-2: a vector fixed in body i is orthogonal to the line from P_i to P_j. Eqs. (87)-(94).

The reduced form, Eq. (88), is used throughout: Φ = hᵀa_i - s_iᵀa_i with h = r_j + s_j - r_i. It equals Eq. (87) on
unit p only; the kernels below are exact derivatives of the reduced form for any p.
"""

from __future__ import annotations

from ...algebra import Array, Row, row
from ...euler import B, D, rotate
from ..element import Grid, Pair, Primitive, Vec3


class Dot2(Primitive, rows=1, derivatives="automatic"):
    """Φ = a_iᵀ (r_j + s_j - r_i) - a_i·s_i [m for a unit vector]."""

    a_i: Vec3  # [-] fixed in body i
    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j

    def _h(self, x: Pair) -> Array:
        return x.r_j + rotate(x.p_j, self.s_j) - x.r_i

    def _h_xi(self, x: Pair, xi: Pair) -> Array:
        return xi.r_j - xi.r_i + B(x.p_j, self.s_j) @ xi.p_j

    def Phi(self, x: Pair) -> Array:  # Eq. (88)
        return row(self._h(x)) @ rotate(x.p_i, self.a_i) - self.s_i @ self.a_i

    def Phi_q(self, x: Pair) -> Row:  # Eq. (89)
        a_i = rotate(x.p_i, self.a_i)
        return row(-a_i), row(self._h(x) @ B(x.p_i, self.a_i)), row(a_i), row(a_i @ B(x.p_j, self.s_j))

    def Phi_q_xi_q(self, x: Pair, xi: Pair) -> Row:  # Eq. (90)
        B_i, B_j, a_i = B(x.p_i, self.a_i), B(x.p_j, self.s_j), rotate(x.p_i, self.a_i)
        turn = B_i @ xi.p_i
        by_i = self._h_xi(x, xi) @ B_i + self._h(x) @ B(xi.p_i, self.a_i)
        return row(-turn), row(by_i), row(turn), row(turn @ B_j + a_i @ B(xi.p_j, self.s_j))

    def Phi_q_xi_q_eta_q(self, x: Pair, xi: Pair, eta: Pair) -> Row:  # Eq. (91)
        B_i, B_j = B(x.p_i, self.a_i), B(x.p_j, self.s_j)
        Bxi_i, Bxi_j = B(xi.p_i, self.a_i), B(xi.p_j, self.s_j)
        Beta_i, Beta_j = B(eta.p_i, self.a_i), B(eta.p_j, self.s_j)
        turn = Bxi_i @ eta.p_i
        by_i = self._h_xi(x, xi) @ Beta_i + self._h_xi(x, eta) @ Bxi_i + (Bxi_j @ eta.p_j) @ B_i
        by_j = turn @ B_j + (B_i @ eta.p_i) @ Bxi_j + (B_i @ xi.p_i) @ Beta_j
        return row(-turn), row(by_i), row(turn), row(by_j)

    def Phi_qT_lam_q(self, x: Pair, lam: Array) -> Grid:  # Eq. (94)
        B_i, B_j = lam[0] * B(x.p_i, self.a_i), B(x.p_j, self.s_j)
        ii, jj = lam[0] * D(self.a_i, self._h(x)), lam[0] * D(self.s_j, rotate(x.p_i, self.a_i))
        return (
            (None, -B_i, None, None),
            (-B_i.T, ii, B_i.T, B_i.T @ B_j),
            (None, B_i, None, None),
            (None, B_j.T @ B_i, None, jj),
        )

    def Phi_qT_lam_q_xi_q(self, x: Pair, lam: Array, xi: Pair) -> Grid:
        B_i, B_j = B(x.p_i, self.a_i), B(x.p_j, self.s_j)
        Bxi_i = lam[0] * B(xi.p_i, self.a_i)
        X = Bxi_i.T @ B_j + lam[0] * (B_i.T @ B(xi.p_j, self.s_j))
        ii = lam[0] * D(self.a_i, self._h_xi(x, xi))
        jj = lam[0] * D(self.s_j, B_i @ xi.p_i)
        return (
            (None, -Bxi_i, None, None),
            (-Bxi_i.T, ii, Bxi_i.T, X),
            (None, Bxi_i, None, None),
            (None, X.T, None, jj),
        )
