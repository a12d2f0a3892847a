"""Resistance of a fluid to the motion of a body: quadratic at a point, or viscous. Differentiated automatically."""

from __future__ import annotations

from ..._jit.formulas.functions import sqrt
from ...algebra import Array, Row
from ...euler import B, G
from ..element import Force, Scalar, Single, Vec3
from ..force_outputs import Dissipative
from ..output import output


class Drag(Force, bodies=1, derivatives="automatic", rare=True):
    """F = -c sqrt(u·u + creep²) u for the velocity u of a point through a wind; c is half of density, area and C_D.

    The speed `creep` rounds the law at rest, where -c |u| u has no second derivative.
    """

    s: Vec3  # [m] point in the body
    c: Scalar  # [N s²/m²]
    wind: Vec3  # [m/s] in global axes
    creep: Scalar  # [m/s]

    def _velocity(self, x: Single, v: Single) -> Array:
        """u."""
        return v.r + B(x.p, self.s) @ v.p - self.wind

    @output("m/s")
    def speed(self, x: Single, v: Single) -> Scalar:
        """sqrt(u·u + creep²)."""
        u = self._velocity(x, v)
        return sqrt(u @ u + self.creep * self.creep)

    def dissipated_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """-F·u."""
        u = self._velocity(x, v)
        return self.c * self.speed(x, v) * (u @ u)

    def supplied_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """Power that the wind supplies, F·wind."""
        return -self.c * self.speed(x, v) * (self._velocity(x, v) @ self.wind)

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        F = -self.c * self.speed(x, v) * self._velocity(x, v)
        return F, F @ B(x.p, self.s)


class ViscousDrag(Dissipative, Force, bodies=1, derivatives="automatic", rare=True):
    """F = -c v at a point, and the torque -c_turn ω."""

    s: Vec3  # [m] point in the body
    c: Scalar  # [N s/m]
    c_turn: Scalar  # [N m s/rad]

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        B_s, G_p = B(x.p, self.s), G(x.p)
        F = -self.c * (v.r + B_s @ v.p)
        return F, F @ B_s - 4 * self.c_turn * ((G_p @ v.p) @ G_p)
