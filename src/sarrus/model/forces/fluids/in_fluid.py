"""Elements of shapes in a fluid: forces and torques along the axes of the shape, by its velocities along them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....algebra import Array, Row
from ....elements.element import Scalar, Single, Vec3
from ....euler import B, G, rotate
from ...quantity import not_negative, regularization, vector


class InFluid:
    """Base of shapes in a fluid. The fluid does work by its wind only; the rest is dissipated."""

    s: Vec3  # [m] centre of the shape in the body
    f: Vec3  # [-] axes of the shape in the body
    g: Vec3  # [-]
    h: Vec3  # [-]
    wind: Vec3  # [m/s] velocity of the fluid in global axes

    def load(self, u: Array, w: Array) -> tuple[Array, Array]:
        """Force and torque about the centre along the axes of the shape.

        u is the velocity relative to the fluid and w the angular velocity, along the same axes.
        """
        raise NotImplementedError

    def dissipated_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """-F·u - T·w."""
        u, w = self._velocities(x, v)
        F, T = self.load(u, w)
        return -(F @ u) - T @ w

    def supplied_power(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """Power that the wind supplies, F·wind."""
        F, _ = self.load(*self._velocities(x, v))
        return F @ self._global_axes(x) @ self.wind

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        along, about = self.load(*self._velocities(x, v))
        F, T = along @ self._global_axes(x), about @ self._axes()
        return F, F @ B(x.p, self.s) + 2 * (T @ G(x.p))

    def _axes(self) -> Array:
        return np.array([self.f, self.g, self.h])

    def _global_axes(self, x: Single) -> Array:
        return np.array([rotate(x.p, axis) for axis in (self.f, self.g, self.h)])

    def _velocities(self, x: Single, v: Single) -> tuple[Array, Array]:
        """Velocity of the centre relative to the fluid, and angular velocity, along the axes of the shape."""
        u = self._global_axes(x) @ (v.r + B(x.p, self.s) @ v.p - self.wind)
        return u, self._axes() @ (2 * (G(x.p) @ v.p))


def checked_fluid(part: Any) -> tuple[Any, ...]:
    """Wind, density, viscosity, creep and angular creep of a shape's drag, checked."""
    density = not_negative(part.density, "density", "Give it in kg/m³.")
    viscosity = not_negative(part.viscosity, "viscosity", "Give it in Pa s.")
    creep = regularization(part.creep)
    angular = (
        creep if part.angular_creep is None else regularization(part.angular_creep, "angular_creep", "rad/s")
    )
    return vector(part.wind, "wind"), density, viscosity, creep, angular
