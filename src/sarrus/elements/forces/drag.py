"""Resistance of a fluid to the motion of a body: quadratic at a point, or viscous. Differentiated automatically."""

from __future__ import annotations

from ..._jit.formulas.functions import sqrt
from ...algebra import Row
from ...euler import B, G
from ..element import Force, Scalar, Single, Vec3


class Drag(Force, bodies=1, derivatives="automatic", rare=True):
    """F = -c sqrt(u·u + creep²) u for the velocity u of a point through a wind; c is half of density, area and C_D.

    The speed `creep` rounds the law at rest, where -c |u| u has no second derivative.
    """

    s: Vec3  # [m] point in the body
    c: Scalar  # [N s²/m²]
    wind: Vec3  # [m/s] in global axes
    creep: Scalar  # [m/s]

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        B_s = B(x.p, self.s)
        u = v.r + B_s @ v.p - self.wind
        F = -self.c * sqrt(u @ u + self.creep * self.creep) * u
        return F, F @ B_s


class ViscousDrag(Force, bodies=1, derivatives="automatic", rare=True):
    """F = -c v at a point, and the torque -c_turn ω."""

    s: Vec3  # [m] point in the body
    c: Scalar  # [N s/m]
    c_turn: Scalar  # [N m s/rad]

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        B_s, G_p = B(x.p, self.s), G(x.p)
        F = -self.c * (v.r + B_s @ v.p)
        return F, F @ B_s - 4 * self.c_turn * ((G_p @ v.p) @ G_p)
