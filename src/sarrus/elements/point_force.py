"""Forces at a point of a body: fixed in space, or turning with the body."""

from __future__ import annotations

from ..algebra import I3, Row
from ..euler import A, B, D, K, rotate
from .element import ZERO_SINGLE, Force, Grid, Scalar, Single, Vec3


class PointForce(Force, bodies=1):
    """A force given in global axes: Q = [F; Bᵀ(p, s) F]."""

    s: Vec3  # [m] point in the body
    force: Vec3  # [N] in global axes

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        return self.force, self.force @ B(x.p, self.s)

    def Q_q(self, x: Single, v: Single, t: Scalar) -> Grid:
        return (None, None), (None, D(self.s, self.force))

    def Q_v(self, x: Single, v: Single, t: Scalar) -> Grid:
        return ZERO_SINGLE

    def Q_b(self, x: Single, v: Single, t: Scalar) -> Grid:
        return (None, I3), (K(x.p, self.force), B(x.p, self.s).T)


class FollowerForce(Force, bodies=1):
    """A force given in body axes: Q = [f; Bᵀ(p, s) f], f = A(p) f'."""

    s: Vec3  # [m] point in the body
    force: Vec3  # [N] in body axes

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        f = rotate(x.p, self.force)
        return f, f @ B(x.p, self.s)

    def Q_q(self, x: Single, v: Single, t: Scalar) -> Grid:
        f, B_f = rotate(x.p, self.force), B(x.p, self.force)
        return (None, B_f), (None, D(self.s, f) + B(x.p, self.s).T @ B_f)

    def Q_v(self, x: Single, v: Single, t: Scalar) -> Grid:
        return ZERO_SINGLE

    def Q_b(self, x: Single, v: Single, t: Scalar) -> Grid:
        return (None, A(x.p)), (K(x.p, rotate(x.p, self.force)), B(x.p, self.s).T @ A(x.p))
