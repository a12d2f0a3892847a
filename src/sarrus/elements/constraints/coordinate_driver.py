"""Coordinate driver: a coordinate of a body, or a linear form of its coordinates, is a function of time."""

from __future__ import annotations

from ...algebra import Array, single
from ..element import Curve, Primitive, Scalar, Single, Time, Vec3


class CoordinateDriver(Primitive, rows=1, bodies=1, derivatives="automatic", rare=True):
    """Φ = by_rᵀ r + by_e0 e0 + by_eᵀ e - scale f(t). The paper has no such constraint."""

    by_r: Vec3  # of the position
    by_e0: Scalar  # of the first Euler parameter
    by_e: Vec3  # of the others
    scale: Scalar  # of the motion
    motion: Curve  # f(t)
    t: Time

    def Phi(self, x: Single) -> Array:
        form = self.by_r @ x.r + self.by_e0 * x.p[0] + self.by_e @ x.p[1:]
        return single(form - self.scale * self.motion(self.t))[0]
