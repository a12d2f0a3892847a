"""Torques on a body that vary in time: fixed in space, or turning with the body. Each is a constant one at t."""

from __future__ import annotations

from .element import Curve, Force, Scalar, Vec3
from .torque import BodyTorque, Torque
from .varying_force import Varying


class VaryingTorque(Varying, Force, bodies=1, rare=True):
    """A torque given in global axes: n = (torque_x x(t), torque_y y(t), torque_z z(t))."""

    torque: Vec3  # [N m] scales of the curves, in global axes
    x: Curve  # of time
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> Torque:
        """The constant torque of this moment."""
        return Torque(self.torque * self.factors(t))


class VaryingBodyTorque(Varying, Force, bodies=1, rare=True):
    """A torque given in body axes: n' = (torque_x x(t), torque_y y(t), torque_z z(t))."""

    torque: Vec3  # [N m] scales of the curves, in body axes
    x: Curve  # of time
    y: Curve
    z: Curve

    def at(self, t: Scalar) -> BodyTorque:
        """The constant torque of this moment."""
        return BodyTorque(self.torque * self.factors(t))
