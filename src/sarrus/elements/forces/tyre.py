"""Tyres as a vertical spring and damper between a point of a body and a road: flat, with a profile, or a surface.

The first also pulls. The others lift off: the road under the wheel centre (x, y, z) is road + h + bump(t), where h is
profile(x) or surface(x, y). With the compression δ = radius - (z - road), its rate δ̇ and the width w of the rounding,
the force upwards is

    F = σ(δ) (k δ + c δ̇)₊

σ is `soft_step` of width w, the subscript `soft_ramp` of width k w: exactly k δ + c δ̇, as in `Tyre`, from δ = w/2 and
F = k w/2 on; exactly zero for δ ≤ -w/2, and never a pull. Its derivatives are made by differentiating Q.
"""

from __future__ import annotations

from ...algebra import I3, Array, Row, outer
from ...euler import B, D, rotate
from ..element import Curve, Force, Grid, Scalar, Single, Surface, Vec3
from ..force_outputs import Passive
from ..output import output
from .laws import soft_ramp, soft_step

UP: Array = I3[2]


class Tyre(Passive, Force, bodies=1, derivatives="automatic"):
    """F = k (R - z) - c ż upwards at the wheel centre, z its height above the road."""

    s: Vec3  # [m] wheel centre in the body
    k: Scalar  # [N/m]
    c: Scalar  # [N s/m]
    radius: Scalar  # [m] unloaded
    road: Scalar  # [m] height of the road

    def _z_q(self, x: Single) -> Array:
        return B(x.p, self.s)[2]

    @output("m", "compression")
    def _compression(self, x: Single) -> Scalar:
        return self.radius - (x.r[2] + rotate(x.p, self.s)[2] - self.road)

    @output("m/s")
    def rate(self, x: Single, v: Single) -> Scalar:
        """Rate of the compression."""
        return -self._rate(x, v)

    def stored_energy(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """½ k δ²."""
        compression = self._compression(x)
        return self.k * compression * compression / 2

    def dissipated_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """c ż²."""
        rate = self._rate(x, v)
        return self.c * rate * rate

    def _rate(self, x: Single, v: Single) -> Scalar:
        return v.r[2] + self._z_q(x) @ v.p

    def _force(self, x: Single, v: Single) -> Scalar:
        return self.k * self._compression(x) - self.c * self._rate(x, v)

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        F = self._force(x, v)
        return F * UP, F * self._z_q(x)

    def Q_q(self, x: Single, v: Single, t: Scalar) -> Grid:
        z_p, rate_p = self._z_q(x), B(v.p, self.s)[2]
        F_r, F_p = -self.k * UP, -self.k * z_p - self.c * rate_p
        pp = outer(z_p, F_p) + D(self.s, self._force(x, v) * UP)
        return (outer(UP, F_r), outer(UP, F_p)), (outer(z_p, F_r), pp)


class LiftingTyre(Force, abstract=True):
    """F = σ(δ) (k δ + c δ̇)₊ upwards at the wheel centre, the base of tyres on different kinds of road."""

    s: Vec3  # [m] wheel centre in the body
    k: Scalar  # [N/m]
    c: Scalar  # [N s/m]
    radius: Scalar  # [m] unloaded
    road: Scalar  # [m] height that is added to profile or surface, and curve
    width: Scalar  # [m] of the rounding
    bump: Curve  # [m] over time [s]

    def _height(self, place: Array) -> Scalar:
        """h."""
        raise NotImplementedError

    def _slopes(self, place: Array) -> tuple[Scalar, Scalar]:
        """∂h/∂x and ∂h/∂y."""
        raise NotImplementedError

    @output("m")
    def compression(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """δ, negative where the tyre is off the road."""
        place = x.r + rotate(x.p, self.s)
        return self.radius - (place[2] - (self.road + self._height(place) + self.bump(t)))

    @output("m/s", "rate")
    def compression_rate(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """δ̇."""
        return self._rise(x, v, t) - self._velocity(x, v)[2]

    def _velocity(self, x: Single, v: Single) -> Array:
        return v.r + B(x.p, self.s) @ v.p

    def _rise(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """The rate of the road's height under the wheel centre."""
        h_x, h_y = self._slopes(x.r + rotate(x.p, self.s))
        velocity = self._velocity(x, v)
        return h_x * velocity[0] + h_y * velocity[1] + self.bump.slope(t)

    def _force(self, depth: Scalar, rate: Scalar) -> Scalar:
        touching = soft_step(depth, self.width)
        return touching * soft_ramp(self.k * depth + self.c * rate, self.k * self.width)

    def _load(self, x: Single, v: Single, t: Scalar) -> Scalar:
        return self._force(self.compression(x, v, t), self.compression_rate(x, v, t))

    def stored_energy(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """½ k δ₊², the integral of F over δ for δ̇ = 0, with δ₊ by `soft_ramp`."""
        pressed = soft_ramp(self.compression(x, v, t), self.width)
        return self.k * pressed * pressed / 2

    def dissipated_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """The part of the load that depends on δ̇, times δ̇."""
        depth, rate = self.compression(x, v, t), self.compression_rate(x, v, t)
        return (self._force(depth, rate) - self._force(depth, 0 * rate)) * rate

    def supplied_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """Power that the road supplies: the load times the rate of the road's height."""
        return self._load(x, v, t) * self._rise(x, v, t)

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        F = self._load(x, v, t)
        return F * UP, F * B(x.p, self.s)[2]


class RoadTyre(LiftingTyre, bodies=1, derivatives="automatic", rare=True):
    """A tyre on a profile."""

    profile: Curve  # [m] over the global x [m]

    def _height(self, place: Array) -> Scalar:
        return self.profile(place[0])

    def _slopes(self, place: Array) -> tuple[Scalar, Scalar]:
        return self.profile.slope(place[0]), 0


class SurfaceTyre(LiftingTyre, bodies=1, derivatives="automatic", rare=True):
    """A tyre on a surface."""

    surface: Surface  # [m] over the global x and y [m]

    def _height(self, place: Array) -> Scalar:
        return self.surface.derivative(place[0], place[1], 0, 0)

    def _slopes(self, place: Array) -> tuple[Scalar, Scalar]:
        return self.surface.derivative(place[0], place[1], 1, 0), self.surface.derivative(
            place[0], place[1], 0, 1
        )
