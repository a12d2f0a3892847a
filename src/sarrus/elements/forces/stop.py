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
from ..force_outputs import Passive
from ..output import output
from .angle import AngleGeometry
from .laws import contact_energy, contact_force


class Limit(Passive):
    """Base of all stops: their common fields, and their force."""

    limit: Scalar
    sign: Scalar
    k: Scalar
    exponent: Scalar
    damping: Scalar
    width: Scalar

    def coordinate(self, x: Pair) -> Scalar:
        """The coordinate that is limited."""
        raise NotImplementedError

    def coordinate_rate(self, x: Pair, v: Pair) -> Scalar:
        """Its rate."""
        raise NotImplementedError

    def depth_of(self, x: Pair) -> Scalar:
        """How far the coordinate is beyond the limit; negative within."""
        return self.sign * (self.coordinate(x) - self.limit)

    def resistance(self, x: Pair, v: Pair) -> Scalar:
        """The force against the coordinate."""
        return self.sign * self._contact(x, self.sign * self.coordinate_rate(x, v))

    def _contact(self, x: Pair, approach: Scalar) -> Scalar:
        return contact_force(self.depth_of(x), approach, self.k, self.exponent, self.damping, self.width)

    def stored_energy(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Energy stored by the contact without damping."""
        return contact_energy(self.depth_of(x), self.k, self.exponent, self.width)

    def dissipated_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Power that the damping dissipates."""
        approach = self.sign * self.coordinate_rate(x, v)
        return (self._contact(x, approach) - self._contact(x, 0 * approach)) * approach


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

    @output("m", "length")
    def coordinate(self, x: Pair) -> Scalar:
        """|d|."""
        d = self.d(x)
        return sqrt(d @ d)

    @output("m/s", "rate")
    def coordinate_rate(self, x: Pair, v: Pair) -> Scalar:
        """The rate of the length."""
        return (self.d(x) @ self.d_xi(x, v)) / self.coordinate(x)

    @output("m")
    def depth(self, x: Pair) -> Scalar:
        """How far the length is beyond the limit; negative within."""
        return self.depth_of(x)

    @output("N")
    def tension(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Positive where it pulls the points together."""
        return self.resistance(x, v)

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        d, f = self.d(x), self.resistance(x, v) / self.coordinate(x)
        return tuple(-f * (d @ block) for block in self.d_q(x))


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

    def _along(self) -> Dot2:
        return Dot2(self.h_i, self.s_i, self.s_j)

    @output("m", "displacement")
    def coordinate(self, x: Pair) -> Scalar:
        """h_i·d_ij."""
        return self._along().Phi(x)[0]

    @output("m/s", "rate")
    def coordinate_rate(self, x: Pair, v: Pair) -> Scalar:
        """The rate of the displacement."""
        return present(self._along().Phi_q_xi(x, v))[0]

    @output("m")
    def depth(self, x: Pair) -> Scalar:
        """How far the displacement is beyond the limit; negative within."""
        return self.depth_of(x)

    @output("N")
    def normal_force(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Along h_i on body i, opposed on body j: against the displacement."""
        return self.resistance(x, v)

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        f = self.resistance(x, v)
        return tuple(-f * present(block)[0] for block in self._along().Phi_q(x))


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

    @output("rad", "angle")
    def coordinate(self, x: Pair) -> Scalar:
        """θ, including revolutions."""
        return self.angle_of(x)

    @output("rad/s", "rate")
    def coordinate_rate(self, x: Pair, v: Pair) -> Scalar:
        """θ̇."""
        return self.turn(x, v).rate

    @output("rad")
    def depth(self, x: Pair) -> Scalar:
        """How far the angle is beyond the limit; negative within."""
        return self.depth_of(x)

    @output("N m", "torque")
    def exerted_torque(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """On body i about h_i, as that of an RSDA."""
        return self.resistance(x, v)

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        n, (w_i, w_j) = self.resistance(x, v), self.w(x)
        return None, n * w_i, None, n * w_j
