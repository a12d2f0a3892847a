"""Rotational spring-damper-actuators about a common axis h of two bodies. Eqs. (104)-(116).

With the angle θ, its rate and any law n(θ, θ̇, t): Q = n w, Q_q = w n_q + n w_q, Q_v = w n_θ̇ θ_q, where w is of h alone.
The paper's k and c are n_θ and n_θ̇.
"""

from __future__ import annotations

from typing import NamedTuple

from ...algebra import Array, Row, outer
from ...euler import bar
from ..element import ZERO_PAIR, Curve, Force, Grid, Memory, Pair, Scalar, Vec3
from ..output import output
from .angle import AngleGeometry, Turn


class Law(NamedTuple):
    """Torque, and its derivatives to angle and rate."""

    n: Scalar
    n_angle: Scalar
    n_rate: Scalar


class TurningSpring(AngleGeometry):
    """Base of all RSDA: everything except the law."""

    def law(self, angle: Scalar, rate: Scalar, t: Scalar) -> Law:
        raise NotImplementedError

    def damper(self, rate: Scalar) -> Scalar:
        """The damper's share of the torque."""
        raise NotImplementedError

    def actuated(self, t: Scalar) -> Scalar:
        """The actuator's share of the torque."""
        raise NotImplementedError

    @output("rad", "angle")
    def present_angle(self, x: Pair) -> Scalar:
        """θ, with its revolutions."""
        return self.angle_of(x)

    @output("rad/s")
    def rate(self, x: Pair, v: Pair) -> Scalar:
        """θ̇."""
        return self.turn(x, v).rate

    @output("N m", "torque")
    def exerted_torque(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """n(θ, θ̇, t) on body i about h_i."""
        return self._law(x, self.turn(x, v), t).n

    def dissipated_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Power that the damper dissipates."""
        rate = self.rate(x, v)
        return self.damper(rate) * rate

    def supplied_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Power that the actuator supplies."""
        return -self.actuated(t) * self.rate(x, v)

    def _law(self, x: Pair, turn: Turn, t: Scalar) -> Law:  # Eq. (106)
        return self.law(self.angle_of(x), turn.rate, t)

    def _n_q(self, x: Pair, v: Pair, turn: Turn, law: Law) -> list[Array]:  # Eqs. (109)-(113)
        """n_q = n_θ θ_q + n_θ̇ (θ_q v)_q by the blocks p_i and p_j; those of r vanish."""
        pairs = zip(turn.im_q, self.rate_q(x, v, turn), strict=True)
        return [law.n_angle * angle_q + law.n_rate * rate_q for angle_q, rate_q in pairs]

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:  # Eqs. (104), (105)
        n, (w_i, w_j) = self._law(x, self.turn(x, v), t).n, self.w(x)
        return None, n * w_i, None, n * w_j

    def Q_q(self, x: Pair, v: Pair, t: Scalar) -> Grid:  # Eq. (107)
        turn = self.turn(x, v)
        law = self._law(x, turn, t)
        ii, ij, ji, jj = self._grid(x, self._n_q(x, v, turn, law))
        own = 2 * law.n * bar(self.h_i), -2 * law.n * bar(self.h_j)
        none = ZERO_PAIR[0]
        return none, (None, ii + own[0], None, ij), none, (None, ji, None, jj + own[1])

    def _grid(self, x: Pair, n_q: list[Array]) -> list[Array]:
        return [outer(w, part) for w in self.w(x) for part in n_q]

    def Q_v(self, x: Pair, v: Pair, t: Scalar) -> Grid:  # Eqs. (108), (114)-(116)
        turn = self.turn(x, v)
        n_rate = self._law(x, turn, t).n_rate
        ii, ij, ji, jj = self._grid(x, [n_rate * angle_q for angle_q in turn.im_q])
        none = ZERO_PAIR[0]
        return none, (None, ii, None, ij), none, (None, ji, None, jj)


class RSDA(TurningSpring, Force, derivatives="automatic"):
    """Torque n = k (θ - angle) + c θ̇ + torque on body i about h_i, opposed on body j about h_j; θ includes revolutions.

    `reference` is the angle, with its revolutions, that θ is nearest to; it is a state variable, not a parameter.
    """

    f_i: Vec3  # [-] fixed in body i; f_i, g_i, h_i right-handed
    g_i: Vec3  # [-]
    h_i: Vec3  # [-] the axis in body i
    f_j: Vec3  # [-] fixed in body j
    h_j: Vec3  # [-] the axis in body j
    k: Scalar  # [N m/rad]
    c: Scalar  # [N m s/rad]
    angle: Scalar  # [rad] free angle
    torque: Scalar  # [N m] of the actuator
    reference: Memory  # [rad]

    def damper(self, rate: Scalar) -> Scalar:
        return self.c * rate

    def actuated(self, t: Scalar) -> Scalar:
        return self.torque

    def law(self, angle: Scalar, rate: Scalar, t: Scalar) -> Law:
        turned = angle - self.angle
        return Law(self.k * turned + self.c * rate + self.torque, self.k, self.c)

    def potential(self, x: Pair) -> tuple[Scalar, ...]:
        """½ k (θ - angle)² [J]; the actuator's work is none of it."""
        turned = self.angle_of(x) - self.angle
        return (self.k * turned * turned / 2,)


class NonlinearRSDA(TurningSpring, Force, derivatives="automatic", rare=True):
    """Curves for stiffness, damping and actuator: n = k κ(θ) (θ - angle) + c χ(θ̇) θ̇ + torque φ(t)."""

    f_i: Vec3  # [-] as in `RSDA`
    g_i: Vec3  # [-]
    h_i: Vec3  # [-]
    f_j: Vec3  # [-]
    h_j: Vec3  # [-]
    k: Scalar  # [N m/rad] scale of the stiffness curve
    c: Scalar  # [N m s/rad] scale of the damping curve
    angle: Scalar  # [rad] free angle
    torque: Scalar  # [N m] scale of the actuator curve
    stiffness: Curve  # κ(θ), θ with its revolutions
    damping: Curve  # χ(θ̇)
    actuator: Curve  # φ(t)
    reference: Memory  # [rad]

    def damper(self, rate: Scalar) -> Scalar:
        return self.c * self.damping(rate) * rate

    def actuated(self, t: Scalar) -> Scalar:
        return self.torque * self.actuator(t)

    def law(self, angle: Scalar, rate: Scalar, t: Scalar) -> Law:
        turned, kappa, chi = angle - self.angle, self.stiffness(angle), self.damping(rate)
        spring, damper, actuator = turned * kappa, chi * rate, self.actuator(t)
        n_angle = self.k * (kappa + turned * self.stiffness.slope(angle))
        n_rate = self.c * (chi + rate * self.damping.slope(rate))
        return Law(self.k * spring + self.c * damper + self.torque * actuator, n_angle, n_rate)

    def potential(self, x: Pair) -> tuple[Scalar, ...]:
        """∫ k κ(s) (s - angle) ds from the free angle on [J]; the actuator's work is none of it."""
        return (self.k * self.stiffness.moment(self.angle, self.angle_of(x)),)
