"""One-sided stops: on the distance of two points, on a joint's displacement, on a joint's angle.

Each resists a coordinate beyond its limit with the force of `contact_law`; `sign` is 1 for an upper and -1 for a lower
limit, and the depth sign (coordinate - limit). The derivatives are made by differentiating Q.
"""

from __future__ import annotations

from ..._jit.formulas.functions import sqrt
from ...algebra import Row, present
from ..constraints.dot2 import Dot2
from ..constraints.segment import Segment
from ..element import Force, Memory, Pair, Scalar, Vec3
from .angle import AngleGeometry
from .laws import contact_force


class Limit:
    """Base of all stops: their common fields, and their force."""

    limit: Scalar
    sign: Scalar
    k: Scalar
    exponent: Scalar
    damping: Scalar
    width: Scalar

    def resistance(self, coordinate: Scalar, rate: Scalar) -> Scalar:
        """The force against the coordinate."""
        depth, approach = self.sign * (coordinate - self.limit), self.sign * rate
        return self.sign * contact_force(depth, approach, self.k, self.exponent, self.damping, self.width)


class LengthStop(Segment, Limit, Force, derivatives="automatic", rare=True):
    """A limit of the distance l of two points: Q = -f l_qᵀ. Singular at l = 0."""

    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j
    limit: Scalar  # [m]
    sign: Scalar  # [-] 1 or -1
    k: Scalar  # [N/m^exponent]
    exponent: Scalar  # [-] at least 1
    damping: Scalar  # [s/m]
    width: Scalar  # [m] of the rounding

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        d = self.d(x)
        l = sqrt(d @ d)
        f = self.resistance(l, (d @ self.d_xi(x, v)) / l)
        return tuple(-(f / l) * (d @ block) for block in self.d_q(x))


class DisplacementStop(Limit, Force, derivatives="automatic", rare=True):
    """A limit of the displacement h_i·d_ij of a translational or cylindrical joint: Q = -f (h_i·d_ij)_qᵀ."""

    h_i: Vec3  # [-] unit vector along the joint in body i
    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j
    limit: Scalar  # [m]
    sign: Scalar  # [-] 1 or -1
    k: Scalar  # [N/m^exponent]
    exponent: Scalar  # [-] at least 1
    damping: Scalar  # [s/m]
    width: Scalar  # [m] of the rounding

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        displacement = Dot2(self.h_i, self.s_i, self.s_j)
        f = self.resistance(displacement.Phi(x)[0], present(displacement.Phi_q_xi(x, v))[0])
        return tuple(-f * present(block)[0] for block in displacement.Phi_q(x))


class AngleStop(AngleGeometry, Limit, Force, derivatives="automatic", rare=True):
    """A limit of the angle θ of a revolute or cylindrical joint, including revolutions, as `RSDA` measures it."""

    f_i: Vec3  # [-] fixed in body i; f_i, g_i, h_i right-handed
    g_i: Vec3  # [-]
    h_i: Vec3  # [-] the axis in body i
    f_j: Vec3  # [-] fixed in body j
    h_j: Vec3  # [-] the axis in body j
    limit: Scalar  # [rad]
    sign: Scalar  # [-] 1 or -1
    k: Scalar  # [N m/rad^exponent]
    exponent: Scalar  # [-] at least 1
    damping: Scalar  # [s/rad]
    width: Scalar  # [rad] of the rounding
    reference: Memory  # [rad]

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        n, (w_i, w_j) = self.resistance(self.angle_of(x), self.turn(x, v).rate), self.w(x)
        return None, n * w_i, None, n * w_j
