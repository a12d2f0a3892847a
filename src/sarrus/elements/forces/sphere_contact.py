"""Contact of a sphere (a point, if its radius is zero) of body i with a plane of body j, with regularized friction.

The depth is δ = radius - n·(C - P_j), n the plane's normal. The normal force N is that of `contact_law`. Friction acts
against the velocity u of body i relative to body j along the plane, where they touch: T = -μ N u / sqrt(u·u +
creep²), which is Coulomb's law for |u| ≫ creep, and creeps below. Both act, on both bodies, at the point of the sphere
that is deepest in the plane, C - radius n: a sphere that rolls has its own radius, whatever the depth. The derivatives
are made by differentiating Q.
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.formulas.functions import sqrt
from ...algebra import Array, Row, cross
from ...euler import E, rotate
from ..element import Force, Pair, Scalar, Vec3
from ..force_outputs import Passive
from ..output import output
from .laws import contact_energy, contact_force


class Touch(NamedTuple):
    """The place where two bodies touch, and their relative velocity there."""

    place: Array
    slip: Array


class SphereContact(Passive, Force, derivatives="automatic", rare=True):
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

    @output("m/s")
    def rate(self, x: Pair, v: Pair) -> Scalar:
        """The rate of the depth."""
        return -(self._motion(x, v).slip @ rotate(x.p_j, self.n_j))

    @output("N")
    def normal_force(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """N."""
        return self._normal_force(x, self.rate(x, v))

    @output("N")
    def friction_force(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """μ N u / sqrt(u·u + creep²)."""
        return self.normal_force(x, v, t) * self._friction(x, v) * self.sliding_speed(x, v)

    @output("m/s")
    def sliding_speed(self, x: Pair, v: Pair) -> Scalar:
        """The size of u; its derivatives do not exist where it is zero."""
        u = self._sliding(x, v)
        return sqrt(u @ u)

    def stored_energy(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Energy stored by the normal force without damping."""
        return contact_energy(self.depth(x), self.k, self.exponent, self.width)

    def dissipated_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Power dissipated by the damping of the normal force and by friction."""
        rate, u = self.rate(x, v), self._sliding(x, v)
        N = self._normal_force(x, rate)
        return (N - self._normal_force(x, 0 * rate)) * rate + N * self._friction(x, v) * (u @ u)

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        touch = self._motion(x, v).place
        F = self.normal_force(x, v, t) * (
            rotate(x.p_j, self.n_j) - self._friction(x, v) * self._sliding(x, v)
        )
        torque_i, torque_j = cross(touch - x.r_i, F), cross(touch - x.r_j, F)
        return F, 2 * (torque_i @ E(x.p_i)), -F, -2 * (torque_j @ E(x.p_j))

    def _motion(self, x: Pair, v: Pair) -> Touch:
        """Where they touch, and the velocity of body i relative to body j there."""
        place = x.r_i + rotate(x.p_i, self.s_i) - self.radius * rotate(x.p_j, self.n_j)
        slip = velocity_at(place, x.r_i, x.p_i, v.r_i, v.p_i) - velocity_at(place, x.r_j, x.p_j, v.r_j, v.p_j)
        return Touch(place, slip)

    def _normal_force(self, x: Pair, rate: Scalar) -> Scalar:
        return contact_force(self.depth(x), rate, self.k, self.exponent, self.damping, self.width)

    def _sliding(self, x: Pair, v: Pair) -> Array:
        """u, the part of the relative velocity along the plane."""
        n, slip = rotate(x.p_j, self.n_j), self._motion(x, v).slip
        return slip - (slip @ n) * n

    def _friction(self, x: Pair, v: Pair) -> Scalar:
        """Friction over normal force and sliding velocity."""
        u = self._sliding(x, v)
        return self.mu / sqrt(u @ u + self.creep * self.creep)


def velocity_at(place: Array, r: Array, p: Array, v: Array, pd: Array) -> Array:
    """Velocity of a body where it is at a global place."""
    return v + cross(2 * (E(p) @ pd), place - r)
