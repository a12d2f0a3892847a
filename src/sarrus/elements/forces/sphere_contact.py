"""Contact of a sphere (a point, if its radius is zero) of body i with a plane of body j, with regularized friction.

The depth is δ = radius - n·(C - P_j), n the plane's normal. The normal force N is that of `contact_law`. Friction acts
against the velocity u of body i relative to body j along the plane, where they touch: T = -μ N u / sqrt(u·u +
creep²), which is Coulomb's law for |u| ≫ creep, and creeps below. Both act, on both bodies, at the point of the sphere
that is deepest in the plane, C - radius n: a sphere that rolls has its own radius, whatever the depth. The derivatives
are made by differentiating Q.
"""

from __future__ import annotations

from ..._jit.formulas.functions import sqrt
from ...algebra import Array, Row, cross
from ...euler import E, rotate
from ..element import Force, Pair, Scalar, Vec3
from ..output import output
from .laws import contact_force


class SphereContact(Force, derivatives="automatic", rare=True):
    """N = k δ₊ⁿ (1 + d δ̇)₊ along the normal of the plane, friction μ N along it."""

    s_i: Vec3  # [m] the sphere's centre C in body i
    s_j: Vec3  # [m] a point of the plane in body j
    n_j: Vec3  # [-] its normal in body j, towards the sphere
    radius: Scalar  # [m]
    k: Scalar  # [N/m^exponent]
    exponent: Scalar  # [-] at least 1
    damping: Scalar  # [s/m]
    width: Scalar  # [m] of the rounding
    mu: Scalar  # [-]
    creep: Scalar  # [m/s]

    @output("m")
    def depth(self, x: Pair) -> Scalar:
        """How deep the sphere is in the plane; negative where they are apart."""
        d = x.r_i + rotate(x.p_i, self.s_i) - x.r_j - rotate(x.p_j, self.s_j)
        return self.radius - rotate(x.p_j, self.n_j) @ d

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        n = rotate(x.p_j, self.n_j)
        arm_i = rotate(x.p_i, self.s_i)
        touch = x.r_i + arm_i - self.radius * n
        slip = velocity_at(touch, x.r_i, x.p_i, v.r_i, v.p_i) - velocity_at(touch, x.r_j, x.p_j, v.r_j, v.p_j)
        F = self._force(self.depth(x), n, slip)
        torque_i, torque_j = cross(touch - x.r_i, F), cross(touch - x.r_j, F)
        return F, 2 * (torque_i @ E(x.p_i)), -F, -2 * (torque_j @ E(x.p_j))

    def _force(self, depth: Scalar, n: Array, slip: Array) -> Array:
        """On body i, for the relative velocity where they touch."""
        normal = slip @ n
        N = contact_force(depth, -normal, self.k, self.exponent, self.damping, self.width)
        u = slip - normal * n
        return N * (n - self.mu / sqrt(u @ u + self.creep * self.creep) * u)


def velocity_at(place: Array, r: Array, p: Array, v: Array, pd: Array) -> Array:
    """Velocity of a body where it is at a global place."""
    return v + cross(2 * (E(p) @ pd), place - r)
