"""Forces at a point of a body that vary in time, fixed in space or turning with the body: constant ones at each t."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..algebra import Array, Row
from .element import Curve, Force, Grid, Scalar, Single, Vec3
from .point_force import FollowerForce, PointForce


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

    def Q_q(self, x: Single, v: Single, t: Scalar) -> Grid:
        return self.at(t).Q_q(x, v, t)

    def Q_v(self, x: Single, v: Single, t: Scalar) -> Grid:
        return self.at(t).Q_v(x, v, t)

    def Q_b(self, x: Single, v: Single, t: Scalar) -> Grid:
        return tuple(_by_scale(line, self.factors(t)) for line in self.at(t).Q_b(x, v, t))


def _by_scale(line: Row, factors: Array) -> Row:
    """Derivatives to point and vector, then to the vector's scale; the curves are no numbers."""
    vector = line[-1]
    scaled = None if vector is None else vector * factors[None, :]
    return (*line[:-1], scaled, None, None, None)


class VaryingForce(Varying, Force, bodies=1, rare=True):
    """A force given in global axes: F = (force_x x(t), force_y y(t), force_z z(t))."""

    s: Vec3  # [m] point in the body
    force: Vec3  # [N] scales of the curves, in global axes
    x: Curve  # of time
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> PointForce:
        """The constant force of this moment."""
        return PointForce(self.s, self.force * self.factors(t))


class VaryingFollowerForce(Varying, Force, bodies=1, rare=True):
    """A force given in body axes: f' = (force_x x(t), force_y y(t), force_z z(t))."""

    s: Vec3  # [m] point in the body
    force: Vec3  # [N] scales of the curves, in body axes
    x: Curve  # of time
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> FollowerForce:
        """The constant force of this moment."""
        return FollowerForce(self.s, self.force * self.factors(t))
