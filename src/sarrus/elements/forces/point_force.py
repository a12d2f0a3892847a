"""Forces at a point of a body, fixed in space or rotating with the body; varying in time, constant ones at each t."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array, Row
from ...euler import B, D, rotate
from ..element import Curve, Force, Grid, Scalar, Single, Vec3


class PointForce(Force, bodies=1, derivatives="automatic"):
    """A force given in global axes: Q = [F; Bᵀ(p, s) F]."""

    s: Vec3  # [m] point in the body
    force: Vec3  # [N] in global axes

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        return self.force, self.force @ B(x.p, self.s)

    def Q_q(self, x: Single, v: Single, t: Scalar) -> Grid:
        return (None, None), (None, D(self.s, self.force))


class FollowerForce(Force, bodies=1, derivatives="automatic"):
    """A force given in body axes: Q = [f; Bᵀ(p, s) f], f = A(p) f'."""

    s: Vec3  # [m] point in the body
    force: Vec3  # [N] in body axes

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        f = rotate(x.p, self.force)
        return f, f @ B(x.p, self.s)


class Varying:
    """A vector whose three components have their own curves over time; the kernels are those of a constant one."""

    x: Curve
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> Any:
        """The constant element of this moment."""
        raise NotImplementedError

    def factors(self, t: Scalar) -> Array:
        """The curves' values."""
        return np.array([self.x(t), self.y(t), self.z(t)])

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        return self.at(t).Q(x, v, t)


class VaryingForce(Varying, Force, bodies=1, derivatives="automatic", rare=True):
    """A force given in global axes: F = (force_x x(t), force_y y(t), force_z z(t))."""

    s: Vec3  # [m] point in the body
    force: Vec3  # [N] scales of the curves, in global axes
    x: Curve  # of time
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> PointForce:
        """The constant force of this moment."""
        return PointForce(self.s, self.force * self.factors(t))


class VaryingFollowerForce(Varying, Force, bodies=1, derivatives="automatic", rare=True):
    """A force given in body axes: f' = (force_x x(t), force_y y(t), force_z z(t))."""

    s: Vec3  # [m] point in the body
    force: Vec3  # [N] scales of the curves, in body axes
    x: Curve  # of time
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> FollowerForce:
        """The constant force of this moment."""
        return FollowerForce(self.s, self.force * self.factors(t))
