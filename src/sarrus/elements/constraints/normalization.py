"""Normalization of a body's Euler parameters. Eqs. (33), (45)-(50)."""

from __future__ import annotations

from ...algebra import I4, Array, Row, row
from ..element import Grid, Primitive, Single


class Normalization(Primitive, rows=1, bodies=1, derivatives="automatic"):
    """Φ = pᵀp - 1 [-]; the system adds one for each body."""

    def Phi(self, x: Single) -> Array:  # Eqs. (33), (45)
        return row(x.p) @ x.p - 1

    def Phi_q(self, x: Single) -> Row:  # Eq. (46)
        return None, row(2 * x.p)

    def Phi_q_xi_q(self, x: Single, xi: Single) -> Row:  # Eq. (47)
        return None, row(2 * xi.p)

    def Phi_q_xi_q_eta_q(self, x: Single, xi: Single, eta: Single) -> Row:
        return None, None

    def Phi_qT_lam_q(self, x: Single, lam: Array) -> Grid:  # Eq. (48)
        return (None, None), (None, 2 * lam[0] * I4)

    def Phi_qT_lam_q_xi_q(self, x: Single, lam: Array, xi: Single) -> Grid:
        return (None, None), (None, None)
