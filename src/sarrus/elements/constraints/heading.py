"""Heading: angle of the line from P_i to P_j in a plane of body i; the angle of the hinge of a massless link."""

from __future__ import annotations

from math import pi

from ..._jit.formulas.functions import atan2, nearest
from ...algebra import Array, single
from ..element import Memory, Pair, Primitive, Scalar, Vec3
from .dot2 import Dot2


class Heading(Primitive, rows=1, derivatives="automatic", rare=True):
    """Φ = θ - angle [rad], θ being the angle of P_j - P_i in the plane of f_i and g_i. Undefined where it is normal.

    `reference` is the angle, with its revolutions, that θ is nearest to; it is a state variable, not a parameter. The
    paper has no formula for it: derivatives are generated from the recorded formula.
    """

    f_i: Vec3  # [-] fixed in body i
    g_i: Vec3  # [-] f_i rotated by a right angle
    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j
    angle: Scalar  # [rad]
    reference: Memory  # [rad]

    def theta(self, x: Pair) -> Scalar:
        """θ [rad] with the revolutions that bring it nearest to the reference."""
        along, across = (Dot2(a, self.s_i, self.s_j).Phi(x)[0] for a in (self.f_i, self.g_i))
        theta = atan2(across, along)
        return theta + 2 * pi * nearest((self.reference - theta) / (2 * pi))

    def Phi(self, x: Pair) -> Array:
        return single(self.theta(x) - self.angle)[0]

    def remember(self, x: Pair) -> tuple[Scalar, ...]:
        """New values of the memory fields at an accepted state."""
        return (self.theta(x),)
