"""Torques on a body, fixed in space or rotating with the body; varying in time, constant ones at each t."""

from __future__ import annotations

from ...algebra import Row
from ...euler import E, G
from ..element import Curve, Force, Scalar, Single, Vec3
from .point_force import Varying


class Torque(Force, bodies=1, derivatives="automatic"):
    """A torque given in global axes: Q = [0; 2 Eᵀ n]."""

    torque: Vec3  # [N m] in global axes

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        return None, 2 * (self.torque @ E(x.p))


class BodyTorque(Force, bodies=1, derivatives="automatic"):
    """A torque given in body axes: Q = [0; 2 Gᵀ n']. Eq. (5)."""

    torque: Vec3  # [N m] in body axes

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        return None, 2 * (self.torque @ G(x.p))


class VaryingTorque(Varying, Force, bodies=1, derivatives="automatic", rare=True):
    """A torque given in global axes: n = (torque_x x(t), torque_y y(t), torque_z z(t))."""

    torque: Vec3  # [N m] scales of the curves, in global axes
    x: Curve  # of time
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> Torque:
        """The constant torque of this moment."""
        return Torque(self.torque * self.factors(t))


class VaryingBodyTorque(Varying, Force, bodies=1, derivatives="automatic", rare=True):
    """A torque given in body axes: n' = (torque_x x(t), torque_y y(t), torque_z z(t))."""

    torque: Vec3  # [N m] scales of the curves, in body axes
    x: Curve  # of time
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> BodyTorque:
        """The constant torque of this moment."""
        return BodyTorque(self.torque * self.factors(t))
