"""Distance driver: the distance of two points is a function of time."""

from __future__ import annotations

from ..algebra import Array, Row, single
from .distance import Distance
from .element import Curve, Grid, Pair, Time


class DistanceDriver(Distance, rows=1, rare=True):
    """Φ = dᵀd - (length f(t))² [m²]. Singular where the distance vanishes.

    All derivatives to q are those of the distance constraint.
    """

    motion: Curve  # f(t) [-]
    t: Time

    def _length(self) -> Array:
        return self.length * self.motion(self.t)

    def Phi(self, x: Pair) -> Array:  # the distance with C(t)
        return Distance(self.s_i, self.s_j, self._length()).Phi(x)

    def Phi_b(self, x: Pair) -> Row:
        by_i, by_j, _ = super().Phi_b(x)
        return by_i, by_j, single(-2 * self._length() * self.motion(self.t)), None, None

    def Phi_q_xi_b(self, x: Pair, xi: Pair) -> Row:
        return *super().Phi_q_xi_b(x, xi), None, None

    def Phi_q_xi_q_eta_b(self, x: Pair, xi: Pair, eta: Pair) -> Row:
        return *super().Phi_q_xi_q_eta_b(x, xi, eta), None, None

    def Phi_qT_lam_b(self, x: Pair, lam: Array) -> Grid:
        return tuple((*line, None, None) for line in super().Phi_qT_lam_b(x, lam))
