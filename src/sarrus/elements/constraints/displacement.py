"""Displacement: how far P_j of body j lies from P_i of body i along a direction fixed in body i; given, or driven."""

from __future__ import annotations

from ...algebra import Array
from ..element import Curve, Pair, Scalar, Time
from .dot2 import Dot2


class Displacement(Dot2, rows=1, derivatives="automatic", rare=True):
    """Φ = a_iᵀ d - displacement [m for a unit vector] in the reduced form of DOT-2, whose derivatives it has."""

    displacement: Scalar  # [m]

    def Phi(self, x: Pair) -> Array:  # DOT-2 and a constant
        return super().Phi(x) - self.displacement


class DisplacementDriver(Dot2, rows=1, derivatives="automatic", rare=True):
    """Φ = a_iᵀ d - scale f(t) [m for a unit vector]; the path of a point, one component each, where i is the ground."""

    scale: Scalar  # of the motion
    motion: Curve  # f(t) [m]
    t: Time

    def Phi(self, x: Pair) -> Array:  # DOT-2 and a function of time
        return super().Phi(x) - self.scale * self.motion(self.t)
