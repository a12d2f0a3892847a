"""Distance: point P_i of body i and P_j of body j keep a distance, given or driven. Eqs. (28), (95)-(103)."""

from __future__ import annotations

from ...algebra import Array, Block, Row, row
from ..element import Curve, Grid, Pair, Primitive, Scalar, Time, Vec3
from .segment import Segment


class Distance(Segment, Primitive, rows=1, derivatives="automatic"):
    """Φ = dᵀd - C² [m²], d from P_i to P_j. Singular at C = 0: use a spherical constraint there."""

    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j
    length: Scalar  # [m] C

    def Phi(self, x: Pair) -> Array:  # Eqs. (28), (95)
        return row(self.d(x)) @ self.d(x) - self.length * self.length

    def Phi_q(self, x: Pair) -> Row:  # Eq. (96)
        d = 2 * self.d(x)
        return tuple(row(d @ block) for block in self.d_q(x))

    def Phi_q_xi_q(self, x: Pair, xi: Pair) -> Row:  # Eq. (99)
        d, (turn_i, turn_j) = 2 * self.d(x), self.d_xi_q(xi)
        by_r_i, by_p_i, by_r_j, by_p_j = self._along(x, 2 * self.d_xi(x, xi))
        return row(by_r_i), row(by_p_i + d @ turn_i), row(by_r_j), row(by_p_j + d @ turn_j)

    def Phi_q_xi_q_eta_q(self, x: Pair, xi: Pair, eta: Pair) -> Row:  # Eq. (100)
        d_xi, d_eta = 2 * self.d_xi(x, xi), 2 * self.d_xi(x, eta)
        (xi_i, xi_j), (eta_i, eta_j) = self.d_xi_q(xi), self.d_xi_q(eta)
        by_r_i, by_p_i, by_r_j, by_p_j = self._along(x, 2 * self.d_xi_eta(xi, eta))
        by_p_i = by_p_i + d_xi @ eta_i + d_eta @ xi_i
        by_p_j = by_p_j + d_xi @ eta_j + d_eta @ xi_j
        return row(by_r_i), row(by_p_i), row(by_r_j), row(by_p_j)

    def _along(self, x: Pair, y: Array) -> list[Array]:
        return [y @ block for block in self.d_q(x)]

    def Phi_qT_lam_q(self, x: Pair, lam: Array) -> Grid:  # Eq. (103)
        d_q, curvature, factor = self.d_q(x), self.curvature(self.d(x)), 2 * lam[0]
        return tuple(
            tuple(factor * (d_q[m].T @ d_q[n] + curvature.get((m, n), 0)) for n in range(4)) for m in range(4)
        )

    def Phi_qT_lam_q_xi_q(self, x: Pair, lam: Array, xi: Pair) -> Grid:
        d_q, curvature, factor = self.d_q(x), self.curvature(self.d_xi(x, xi)), 2 * lam[0]
        turn_i, turn_j = self.d_xi_q(xi)
        turn = {1: turn_i, 3: turn_j}

        def block(m: int, n: int) -> Block:
            terms = [curvature[m, n]] if (m, n) in curvature else []
            terms += [turn[m].T @ d_q[n]] if m in turn else []
            terms += [d_q[m].T @ turn[n]] if n in turn else []
            return factor * sum(terms[1:], terms[0]) if terms else None

        return tuple(tuple(block(m, n) for n in range(4)) for m in range(4))


class DistanceDriver(Distance, rows=1, derivatives="automatic", rare=True):
    """Φ = dᵀd - (length f(t))² [m²]. Singular where the distance vanishes.

    All derivatives to q are those of the distance constraint.
    """

    motion: Curve  # f(t) [-]
    t: Time

    def _length(self) -> Array:
        return self.length * self.motion(self.t)

    def Phi(self, x: Pair) -> Array:  # the distance with C(t)
        return Distance(self.s_i, self.s_j, self._length()).Phi(x)
