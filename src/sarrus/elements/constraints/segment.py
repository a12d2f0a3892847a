"""The line from a point of body i to a point of body j, and its derivatives; what distance and TSDA are made of."""

from __future__ import annotations

from ...algebra import I3, Array
from ...euler import B, D, rotate
from ..element import Pair, Vec3


class Segment:
    """Geometry of d = r_j + s_j - r_i - s_i for elements with the fields `s_i` and `s_j`."""

    s_i: Vec3
    s_j: Vec3

    def d(self, x: Pair) -> Array:
        """The vector from P_i to P_j."""
        return x.r_j + rotate(x.p_j, self.s_j) - x.r_i - rotate(x.p_i, self.s_i)

    def d_q(self, x: Pair) -> tuple[Array, Array, Array, Array]:
        """Its Jacobian. Eq. (35)."""
        return -I3, -B(x.p_i, self.s_i), I3, B(x.p_j, self.s_j)

    def d_xi(self, x: Pair, xi: Pair) -> Array:
        """Its derivative along ξ. Eqs. (97), (98), with the opposite sign."""
        return xi.r_j + B(x.p_j, self.s_j) @ xi.p_j - xi.r_i - B(x.p_i, self.s_i) @ xi.p_i

    def d_xi_q(self, xi: Pair) -> tuple[Array, Array]:
        """The two blocks (p_i and p_j) of the derivative of `d_xi` to q; those of r vanish. Eq. (38)."""
        return -B(xi.p_i, self.s_i), B(xi.p_j, self.s_j)

    def d_xi_eta(self, xi: Pair, eta: Pair) -> Array:
        """Its second derivative along ξ and η. Eq. (39)."""
        return B(xi.p_j, self.s_j) @ eta.p_j - B(xi.p_i, self.s_i) @ eta.p_i

    def curvature(self, y: Array) -> dict[tuple[int, int], Array]:
        """The two blocks of the derivative of d_qᵀ y to q for a fixed y. Eq. (44)."""
        return {(1, 1): -D(self.s_i, y), (3, 3): D(self.s_j, y)}
