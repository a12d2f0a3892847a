"""Angle of body j relative to body i about an axis, constant or prescribed. The paper has no such constraints."""

from __future__ import annotations

from collections.abc import Iterator

from ...algebra import Array, Row, single
from ..element import Curve, Grid, Memory, Pair, Primitive, Scalar, Time, Vec3
from .argument import Argument
from .combination import Combination, Term


class Angle(Combination, Primitive, rows=1, rare=True):
    """Φ = θ - angle [rad], θ being the angle of f_j in the plane of f_i and g_i. Undefined where f_j is normal to it.

    `reference` is the angle, with its revolutions, that θ is nearest to; it is a state variable, not a parameter.
    """

    f_i: Vec3  # [-] fixed in body i
    g_i: Vec3  # [-] f_i rotated by a right angle
    f_j: Vec3  # [-] fixed in body j
    angle: Scalar  # [rad]
    reference: Memory  # [rad]

    def theta(self) -> Argument:
        """θ as a function of the coordinates."""
        return Argument(self.f_i, self.g_i, self.f_j)

    def terms(self) -> Iterator[Term]:
        yield Term(1, self.theta())

    def Phi(self, x: Pair) -> Array:
        return single(self.theta().near(x, self.reference) - self.angle)[0]

    def remember(self, x: Pair) -> tuple[Scalar, ...]:
        """New values of the memory fields at an accepted state."""
        return (self.theta().near(x, self.reference),)

    def Phi_b(self, x: Pair) -> Row:
        return *self.theta().Phi_b(x), single(-1), None

    def Phi_q_xi_b(self, x: Pair, xi: Pair) -> Row:
        return *self.theta().Phi_q_xi_b(x, xi), None, None

    def Phi_q_xi_q_eta_b(self, x: Pair, xi: Pair, eta: Pair) -> Row:
        return *self.theta().Phi_q_xi_q_eta_b(x, xi, eta), None, None

    def Phi_qT_lam_b(self, x: Pair, lam: Array) -> Grid:
        return tuple((*line, None, None) for line in self.theta().Phi_qT_lam_b(x, lam))


class AngleDriver(Combination, Primitive, rows=1, rare=True):
    """Φ = θ - scale f(t) [rad]. θ is taken nearest to the motion, so no revolutions are stored."""

    f_i: Vec3  # [-] fixed in body i
    g_i: Vec3  # [-] f_i rotated by a right angle
    f_j: Vec3  # [-] fixed in body j
    scale: Scalar  # of the motion
    motion: Curve  # f(t) [rad]
    t: Time

    def theta(self) -> Argument:
        """θ as a function of the coordinates."""
        return Argument(self.f_i, self.g_i, self.f_j)

    def terms(self) -> Iterator[Term]:
        yield Term(1, self.theta())

    def Phi(self, x: Pair) -> Array:
        goal = self.scale * self.motion(self.t)
        return single(self.theta().near(x, goal) - goal)[0]

    def Phi_b(self, x: Pair) -> Row:
        return *self.theta().Phi_b(x), single(-self.motion(self.t)), None, None

    def Phi_q_xi_b(self, x: Pair, xi: Pair) -> Row:
        return *self.theta().Phi_q_xi_b(x, xi), None, None, None

    def Phi_q_xi_q_eta_b(self, x: Pair, xi: Pair, eta: Pair) -> Row:
        return *self.theta().Phi_q_xi_q_eta_b(x, xi, eta), None, None, None

    def Phi_qT_lam_b(self, x: Pair, lam: Array) -> Grid:
        return tuple((*line, None, None, None) for line in self.theta().Phi_qT_lam_b(x, lam))
