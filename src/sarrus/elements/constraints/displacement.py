"""Displacement: how far P_j of body j lies from P_i of body i along a direction fixed in body i; given, or driven."""

from __future__ import annotations

from ...algebra import Array, Row, single
from ..element import Curve, Grid, Pair, Scalar, Time
from .dot2 import Dot2


class Displacement(Dot2, rows=1, rare=True):
    """Φ = a_iᵀ d - displacement [m for a unit vector] in the reduced form of DOT-2, whose derivatives it has."""

    displacement: Scalar  # [m]

    def Phi(self, x: Pair) -> Array:  # DOT-2 and a constant
        return super().Phi(x) - self.displacement

    def Phi_b(self, x: Pair) -> Row:
        return *super().Phi_b(x), single(-1)

    def Phi_q_xi_b(self, x: Pair, xi: Pair) -> Row:
        return *super().Phi_q_xi_b(x, xi), None

    def Phi_q_xi_q_eta_b(self, x: Pair, xi: Pair, eta: Pair) -> Row:
        return *super().Phi_q_xi_q_eta_b(x, xi, eta), None

    def Phi_qT_lam_b(self, x: Pair, lam: Array) -> Grid:
        return tuple((*line, None) for line in super().Phi_qT_lam_b(x, lam))


class DisplacementDriver(Dot2, rows=1, rare=True):
    """Φ = a_iᵀ d - scale f(t) [m for a unit vector]; the path of a point, one component each, where i is the ground."""

    scale: Scalar  # of the motion
    motion: Curve  # f(t) [m]
    t: Time

    def Phi(self, x: Pair) -> Array:  # DOT-2 and a function of time
        return super().Phi(x) - self.scale * self.motion(self.t)

    def Phi_b(self, x: Pair) -> Row:
        return *super().Phi_b(x), single(-self.motion(self.t)), None, None

    def Phi_q_xi_b(self, x: Pair, xi: Pair) -> Row:
        return *super().Phi_q_xi_b(x, xi), None, None, None

    def Phi_q_xi_q_eta_b(self, x: Pair, xi: Pair, eta: Pair) -> Row:
        return *super().Phi_q_xi_q_eta_b(x, xi, eta), None, None, None

    def Phi_qT_lam_b(self, x: Pair, lam: Array) -> Grid:
        return tuple((*line, None, None, None) for line in super().Phi_qT_lam_b(x, lam))
