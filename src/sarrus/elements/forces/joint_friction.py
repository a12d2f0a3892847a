"""Dry friction in joints, after Stribeck, for a given constant load; see `friction_law`.

The load is a number, not the joint's reaction: an element knows coordinates and velocities, no multipliers. Where
reactions vary much, friction is wrong in proportion. The derivatives are made by differentiating Q.
"""

from __future__ import annotations

import numpy as np

from ...algebra import Array, Row, present
from ...euler import E, rotate
from ..constraints.dot2 import Dot2
from ..element import Force, Pair, Scalar, Vec3
from ..force_outputs import Dissipative
from ..output import output
from .laws import friction_force

ORIGIN = np.zeros(3, dtype=int)


class Sliding(Dissipative):
    """The fields that both share, and their force."""

    load: Scalar
    mu: Scalar
    mu_static: Scalar
    stribeck: Scalar
    creep: Scalar
    viscous: Scalar

    def resistance(self, speed: Scalar) -> Scalar:
        """The force against a sliding speed."""
        numbers = self.load, self.mu, self.mu_static, self.stribeck, self.creep, self.viscous
        return friction_force(speed, *numbers)


class AngleFriction(Sliding, Force, derivatives="automatic", rare=True):
    """Friction of a pin in a revolute joint. The sliding speed is radius times h·(ω_j - ω_i)."""

    h_i: Vec3  # [-] unit vector along the axis in body i
    radius: Scalar  # [m] at which friction acts
    load: Scalar  # [N]
    mu: Scalar  # [-]
    mu_static: Scalar  # [-]
    stribeck: Scalar  # [m/s]
    creep: Scalar  # [m/s]
    viscous: Scalar  # [N s/m]

    @output("m/s")
    def sliding_speed(self, x: Pair, v: Pair) -> Scalar:
        """radius h·(ω_j - ω_i), with its sign."""
        return self.radius * (rotate(x.p_i, self.h_i) @ (spin(x.p_j, v.p_j) - spin(x.p_i, v.p_i)))

    @output("N m")
    def friction_torque(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """About the axis on body i, opposed on body j: against the rotation of body j."""
        return self.radius * self.resistance(self.sliding_speed(x, v))

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        torque = self.friction_torque(x, v, t) * rotate(x.p_i, self.h_i)
        return None, 2 * (torque @ E(x.p_i)), None, -2 * (torque @ E(x.p_j))


class DisplacementFriction(Sliding, Force, derivatives="automatic", rare=True):
    """Friction of a slider in a translational or cylindrical joint. The sliding speed is the rate of h_i·d_ij."""

    h_i: Vec3  # [-] unit vector along the joint in body i
    s_j: Vec3  # [m] P_j in body j
    load: Scalar  # [N]
    mu: Scalar  # [-]
    mu_static: Scalar  # [-]
    stribeck: Scalar  # [m/s]
    creep: Scalar  # [m/s]
    viscous: Scalar  # [N s/m]

    def _along(self) -> Dot2:
        return Dot2(self.h_i, ORIGIN, self.s_j)  # P_i does not matter to its rate

    @output("m/s")
    def sliding_speed(self, x: Pair, v: Pair) -> Scalar:
        """The rate of h_i·d_ij."""
        return present(self._along().Phi_q_xi(x, v))[0]

    @output("N")
    def friction_force(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Along the axis on body i, opposed on body j: against the displacement of body j."""
        return self.resistance(self.sliding_speed(x, v))

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        f = self.friction_force(x, v, t)
        return tuple(-f * present(block)[0] for block in self._along().Phi_q(x))


def spin(p: Array, pd: Array) -> Array:
    """Angular velocity in global axes."""
    return 2 * (E(p) @ pd)
