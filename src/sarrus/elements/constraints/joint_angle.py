"""Angle of body j relative to body i about an axis, constant or prescribed. The paper has no such constraints."""

from __future__ import annotations

from ...algebra import Array, single
from ..element import Curve, Memory, Pair, Scalar, Time
from .argument import Argument


class Angle(Argument, rows=1, derivatives="automatic", rare=True):
    """Φ = θ - angle [rad], θ being the angle of f_j in the plane of f_i and g_i. Undefined where f_j is normal to it.

    `reference` is the angle, with its revolutions, that θ is nearest to; it is a state variable, not a parameter.
    """

    angle: Scalar  # [rad]
    reference: Memory  # [rad]

    def Phi(self, x: Pair) -> Array:
        return single(self.near(x, self.reference) - self.angle)[0]

    def remember(self, x: Pair) -> tuple[Scalar, ...]:
        """New values of the memory fields at an accepted state."""
        return (self.near(x, self.reference),)


class AngleDriver(Argument, rows=1, derivatives="automatic", rare=True):
    """Φ = θ - scale f(t) [rad]. θ is taken nearest to the motion, so no revolutions are stored."""

    scale: Scalar  # of the motion
    motion: Curve  # f(t) [rad]
    t: Time

    def Phi(self, x: Pair) -> Array:
        goal = self.scale * self.motion(self.t)
        return single(self.near(x, goal) - goal)[0]
