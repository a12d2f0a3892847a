"""DOT-1: the product of a vector fixed in body i with one fixed in body j vanishes. Eqs. (26), (80)-(86)."""

from __future__ import annotations

from ...algebra import Array, Row, row
from ...euler import B, D, rotate
from ..element import Grid, Pair, Primitive, Vec3


class Dot1(Primitive, rows=1, derivatives="automatic"):
    """Φ = a_iᵀ a_j [1 for unit vectors]."""

    a_i: Vec3  # [-] fixed in body i
    a_j: Vec3  # [-] fixed in body j

    def Phi(self, x: Pair) -> Array:  # Eqs. (26), (80)
        return row(rotate(x.p_i, self.a_i)) @ rotate(x.p_j, self.a_j)

    def Phi_q(self, x: Pair) -> Row:  # Eq. (81)
        a_i, a_j = rotate(x.p_i, self.a_i), rotate(x.p_j, self.a_j)
        return None, row(a_j @ B(x.p_i, self.a_i)), None, row(a_i @ B(x.p_j, self.a_j))

    def Phi_q_xi_q(self, x: Pair, xi: Pair) -> Row:  # Eq. (82)
        a_i, a_j = rotate(x.p_i, self.a_i), rotate(x.p_j, self.a_j)
        B_i, B_j = B(x.p_i, self.a_i), B(x.p_j, self.a_j)
        by_i = a_j @ B(xi.p_i, self.a_i) + (B_j @ xi.p_j) @ B_i
        by_j = a_i @ B(xi.p_j, self.a_j) + (B_i @ xi.p_i) @ B_j
        return None, row(by_i), None, row(by_j)

    def Phi_q_xi_q_eta_q(self, x: Pair, xi: Pair, eta: Pair) -> Row:  # Eq. (83)
        B_i, B_j = B(x.p_i, self.a_i), B(x.p_j, self.a_j)
        Bxi_i, Bxi_j = B(xi.p_i, self.a_i), B(xi.p_j, self.a_j)
        Beta_i, Beta_j = B(eta.p_i, self.a_i), B(eta.p_j, self.a_j)
        by_i = (B_j @ xi.p_j) @ Beta_i + (Bxi_j @ eta.p_j) @ B_i + (B_j @ eta.p_j) @ Bxi_i
        by_j = (B_i @ eta.p_i) @ Bxi_j + (Bxi_i @ eta.p_i) @ B_j + (B_i @ xi.p_i) @ Beta_j
        return None, row(by_i), None, row(by_j)

    def Phi_qT_lam_q(self, x: Pair, lam: Array) -> Grid:  # Eq. (86)
        a_i, a_j = rotate(x.p_i, self.a_i), rotate(x.p_j, self.a_j)
        cross_term = lam[0] * (B(x.p_i, self.a_i).T @ B(x.p_j, self.a_j))
        return (
            (None, None, None, None),
            (None, lam[0] * D(self.a_i, a_j), None, cross_term),
            (None, None, None, None),
            (None, cross_term.T, None, lam[0] * D(self.a_j, a_i)),
        )

    def Phi_qT_lam_q_xi_q(self, x: Pair, lam: Array, xi: Pair) -> Grid:
        B_i, B_j = B(x.p_i, self.a_i), B(x.p_j, self.a_j)
        X = lam[0] * (B(xi.p_i, self.a_i).T @ B_j + B_i.T @ B(xi.p_j, self.a_j))
        return (
            (None, None, None, None),
            (None, lam[0] * D(self.a_i, B_j @ xi.p_j), None, X),
            (None, None, None, None),
            (None, X.T, None, lam[0] * D(self.a_j, B_i @ xi.p_i)),
        )
