"""Weight of a body, at the frame's origin or at an eccentric centre of mass."""

from __future__ import annotations

from ...algebra import Array, Row
from ...euler import B, D, rotate
from ..element import ZERO_SINGLE, Force, Grid, Scalar, Single, Vec3


class Gravity(Force, bodies=1, derivatives="automatic"):
    """Q = [m g; 0] [N]."""

    mass: Scalar  # [kg]
    g: Vec3  # [m/s²] in global axes

    def potential(self, x: Single) -> tuple[Scalar, ...]:
        """-m gᵀr [J]."""
        return (-self.mass * (self.g @ x.r),)

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        return self.mass * self.g, None

    def Q_q(self, x: Single, v: Single, t: Scalar) -> Grid:
        return ZERO_SINGLE

    def Q_v(self, x: Single, v: Single, t: Scalar) -> Grid:
        return ZERO_SINGLE


class EccentricGravity(Force, bodies=1, derivatives="automatic"):
    """Q = [m g; m Bᵀg], B = B(p, c), c the centre of mass in the body."""

    mass: Scalar  # [kg]
    center: Vec3  # [m] centre of mass in body axes
    g: Vec3  # [m/s²] in global axes

    def _weight(self) -> Array:
        return self.mass * self.g

    def potential(self, x: Single) -> tuple[Scalar, ...]:
        """-m gᵀ(r + A c) [J]."""
        return (-(self._weight() @ (x.r + rotate(x.p, self.center))),)

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        return self._weight(), self._weight() @ B(x.p, self.center)

    def Q_q(self, x: Single, v: Single, t: Scalar) -> Grid:
        return (None, None), (None, D(self.center, self._weight()))

    def Q_v(self, x: Single, v: Single, t: Scalar) -> Grid:
        return ZERO_SINGLE
