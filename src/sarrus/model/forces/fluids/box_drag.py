"""Resistance of a fluid to a box: drag and viscous forces along its axes, and torques about them.

With the velocity u of the box's centre relative to the fluid and its angular velocity w, both along the box's axes, the
sides b, the density ρ, the viscosity β and d = (b₁ + b₂ + b₃)/3:

    F₁ = -3π β d u₁ - ½ ρ b₂ b₃ |u₁| u₁,    T₁ = -π β d³ w₁ - ρ/64 b₁ (b₂⁴ + b₃⁴) |w₁| w₁,

and likewise for the other axes. This is MuJoCo's model of a body in a fluid. |u| is sqrt(u² + creep²), and so is |w|
with its own creep.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import Annotated

import numpy as np

from .... import elements
from ....algebra import Array
from ....elements.element import Scalar, Vec3
from ....functions import sqrt
from ...geometry.frame import Frame
from ...geometry.pose import Poses
from ...measure import In, Offset, Velocity
from ...primitive import Primitive
from ...quantity import not_negative, vector
from ..force import Force, refuse_ground
from .in_fluid import InFluid, checked_fluid


class BoxInFluid(InFluid, elements.Force, bodies=1, derivatives="automatic", rare=True):
    """F and T, see above."""

    s: Vec3  # [m] centre of the box in the body
    f: Vec3  # [-] axes of the box in the body
    g: Vec3  # [-]
    h: Vec3  # [-]
    box: Vec3  # [m] its sides
    wind: Vec3  # [m/s] velocity of the fluid in global axes
    density: Scalar  # [kg/m³]
    viscosity: Scalar  # [Pa s]
    creep: Scalar  # [m/s]
    angular_creep: Scalar  # [rad/s]

    def load(self, u: Array, w: Array) -> tuple[Array, Array]:
        """F and T, see above."""
        b, d, force, torque = self.box, sum(self.box) / 3, [], []
        for n in range(3):
            area, arms = b[n - 1] * b[n - 2], b[n - 1] ** 4 + b[n - 2] ** 4
            resistance = 3 * pi * self.viscosity * d + self.density * area / 2 * self._size(u[n], self.creep)
            spin = self._size(w[n], self.angular_creep)
            turning = pi * self.viscosity * d**3 + self.density * b[n] * arms / 64 * spin
            force.append(-resistance * u[n])
            torque.append(-turning * w[n])
        return np.array(force), np.array(torque)

    def _size(self, speed: Scalar, creep: Scalar) -> Scalar:
        return sqrt(speed * speed + creep * creep)


@dataclass(frozen=True, eq=False)
class BoxDrag(Force):
    """Resistance of a fluid to a body like a box: drag by the ``density``, and viscous forces.

    The forces along the three axes of the box, and the torques about them, are independent; there is no lift. Models of
    swimmers and flyers in MJCF use it, with the box that has the mass and the moments of inertia of the body.

    Parameters
    ----------
    frame
        Centre and axes of the box.
    box
        Its three sides [m].
    density
        Of the fluid [kg/m³].
    viscosity
        Of the fluid [Pa s].
    wind
        Velocity of the fluid [m/s], in global axes.
    creep, angular_creep
        Small speeds [m/s], [rad/s], below which drag is linear, so that it has derivatives at rest. By default the
        second one has the number of the first.
    """

    frame: Frame
    box: Offset
    density: Annotated[float, In("kg/m^3")] = 0.0
    viscosity: Annotated[float, In("N s/m^2")] = 0.0
    wind: Velocity = (0.0, 0.0, 0.0)
    creep: Annotated[float, In("m/s")] = 1e-5
    angular_creep: Annotated[float, In("rad/s")] | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the box."""
        body, *place = self.frame.resolve(poses, "frame")
        refuse_ground(body, "frame")
        box = vector(self.box, "box", "Give the three sides in m.")
        for side in box:
            not_negative(side, "box", "Give the three sides in m.")
        yield Primitive(BoxInFluid, (body,), (*place, box, *checked_fluid(self)), "drag")
