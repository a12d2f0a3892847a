"""Constant angle: a vector fixed in body i and one fixed in body j keep the angle α between them."""

from __future__ import annotations

from ...algebra import Array, Row, single
from ..element import Grid, Pair, Scalar
from .dot1 import Dot1


class ConstantAngle(Dot1, rows=1, rare=True):
    """Φ = a_iᵀ a_j - cos α [1 for unit vectors]. Singular at α = 0 and π: parallel is two DOT-1 constraints.

    All derivatives to q are those of DOT-1; the paper has no such constraint.
    """

    cosine: Scalar  # [-] cos α

    def Phi(self, x: Pair) -> Array:
        return super().Phi(x) - self.cosine

    def Phi_b(self, x: Pair) -> Row:
        return *super().Phi_b(x), single(-1)

    def Phi_q_xi_b(self, x: Pair, xi: Pair) -> Row:
        return *super().Phi_q_xi_b(x, xi), None

    def Phi_q_xi_q_eta_b(self, x: Pair, xi: Pair, eta: Pair) -> Row:
        return *super().Phi_q_xi_q_eta_b(x, xi, eta), None

    def Phi_qT_lam_b(self, x: Pair, lam: Array) -> Grid:
        return tuple((*line, None) for line in super().Phi_qT_lam_b(x, lam))
