"""Forces of a fluid on an ellipsoid: drag, viscous resistance, lift, and the moments of its added mass.

The velocity u of the centre relative to the fluid and the angular velocity w are along the axes of the ellipsoid, with
semi-axes a, b, c and volume V; ρ is the density and β the viscosity of the fluid. With m = (bc, ca, ab), the projected
area A = π √(Σ mᵢ⁴uᵢ² / Σ mᵢ²uᵢ²) along u, its largest value A₀, nᵢ = mᵢ²uᵢ, D = 2/3 (a + b + c), the moments
Iᵢ = 8/15 π aᵢ max(aⱼ, aₖ)⁴, I₀ = 8/15 π (middle axis) (longest axis)⁴, the added masses μ and moments of inertia J:

    drag         F = -(3π β D + ρ |u| (C_blunt A + C_slender (A₀ - A))) u
                 T = -(π β D³ + ρ |k|) w,    kᵢ = (C_angular Iᵢ + C_slender (I₀ - Iᵢ)) wᵢ
    Magnus lift  F = C_magnus ρ V w × u
    Kutta lift   F = C_kutta ρ A (Σ mᵢ²uᵢ² / (|u| Σ mᵢ⁴uᵢ²)) (n × u) × u
    added mass   F = (μ u) × w,    T = (μ u) × u + (J w) × w

This is MuJoCo's ellipsoid model, in which the inertia of the added mass, -μ u̇ and -J ẇ, does not act. In |u|, A and
|k|, uᵢ² and wᵢ² are uᵢ² + creep²/3 and wᵢ² + angular_creep²/3, so that all derivatives exist at rest. |k| is
k²/√(k² + 1e-6 angular_creep² I₀²), so that they exist without drag of rotations, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import Annotated

import numpy as np

from .... import elements
from ....algebra import Array, cross
from ....elements.element import Scalar, Vec3
from ....functions import sqrt
from ...errors import ModelError
from ...geometry.frame import Frame
from ...geometry.pose import Poses
from ...measure import In, Offset, Ratio, Velocity
from ...primitive import Primitive
from ...quantity import LARGEST, Vector, not_negative, number, positive, vector
from ..force import Force, refuse_ground
from .added_mass import added_masses
from .in_fluid import InFluid, checked_fluid

SMALLEST = 1e-250  # m⁵, of I₀: what is computed from smaller ones is not a number
LEAST = 1e-3  # of I₀ and creep: what is added to |k|, whose coefficients may be zero


class EllipsoidInFluid(InFluid, elements.Force, bodies=1, derivatives="automatic", rare=True):
    """F and T, see above."""

    s: Vec3  # [m] centre of the ellipsoid in the body
    f: Vec3  # [-] its axes in the body
    g: Vec3  # [-]
    h: Vec3  # [-]
    semiaxes: Vec3  # [m]
    wind: Vec3  # [m/s] velocity of the fluid in global axes
    density: Scalar  # [kg/m³]
    viscosity: Scalar  # [Pa s]
    blunt_drag: Scalar  # [-]
    slender_drag: Scalar  # [-]
    kutta_lift: Scalar  # [-]
    magnus_lift: Scalar  # [-]
    area: Scalar  # [m²] largest projected area
    moment: Scalar  # [m⁵] I₀
    turning: Vec3  # [m⁵] kᵢ / wᵢ
    added_mass: Vec3  # [kg]
    added_inertia: Vec3  # [kg m²]
    creep: Scalar  # [m/s]
    angular_creep: Scalar  # [rad/s]

    def load(self, u: Array, w: Array) -> tuple[Array, Array]:
        """F and T, see above."""
        a, b, c = self.semiaxes
        m = np.array([b * c, c * a, a * b]) * (pi / self.area)  # over their largest, as powers underflow
        m2 = m * m
        u2, w2 = u * u + self.creep * self.creep / 3, w * w + self.angular_creep * self.angular_creep / 3
        speed, N, D = sqrt(u2 @ np.array([1, 1, 1])), m2 @ u2, (m2 * m2) @ u2
        area, diameter = self.area * sqrt(D / N), 2 * (a + b + c) / 3
        drag = self.density * speed * (self.blunt_drag * area + self.slender_drag * (self.area - area))
        k = self.turning / self.moment
        k2 = (k * k) @ w2
        turning = self.density * self.moment * k2 / sqrt(k2 + (LEAST * self.angular_creep) ** 2)
        kutta = self.kutta_lift * self.density * area * N / (speed * D)
        magnus = self.magnus_lift * self.density * 4 / 3 * pi * a * b * c
        momentum = self.added_mass * u
        force = magnus * cross(w, u) + kutta * cross(cross(m2 * u, u), u) + cross(momentum, w)
        torque = cross(momentum, u) + cross(self.added_inertia * w, w)
        viscous = pi * self.viscosity * diameter
        return force - (3 * viscous + drag) * u, torque - (viscous * diameter**2 + turning) * w


@dataclass(frozen=True, eq=False)
class EllipsoidDrag(Force):
    """Drag, lift and moments of the added mass of a fluid on a body like an ellipsoid, such as a leaf or a fish.

    Lift by circulation (Kutta) and by rotation (Magnus) and the added mass do no work. As in MuJoCo, the inertia of the
    added mass is left out: it does not act on accelerations. The largest area and moments depend on which semi-axis is
    the longest: where two are equal, derivatives by one of them alone are those of one side.

    Parameters
    ----------
    frame
        Centre and axes of the ellipsoid.
    semiaxes
        Its three semi-axes [m].
    density
        Of the fluid [kg/m³].
    viscosity
        Of the fluid [Pa s].
    wind
        Velocity of the fluid [m/s], in global axes.
    blunt_drag
        Coefficient of drag of the projected area.
    slender_drag
        Coefficient of drag of the largest projected area, less the projected area.
    angular_drag
        Coefficient of drag of rotations.
    kutta_lift
        Coefficient of lift by circulation.
    magnus_lift
        Coefficient of lift by rotation.
    added_mass
        Masses of the fluid that moves along each axis [kg], by default those of an ellipsoid in an ideal fluid.
    added_inertia
        Moments of inertia of the fluid about each axis [kg m²], by default as for the masses.
    creep, angular_creep
        Small speeds [m/s], [rad/s], below which drag is linear, so that it has derivatives at rest. By default the
        second one has the number of the first.
    """

    frame: Frame
    semiaxes: Offset
    density: Annotated[float, In("kg/m^3")] = 0.0
    viscosity: Annotated[float, In("N s/m^2")] = 0.0
    wind: Velocity = (0.0, 0.0, 0.0)
    blunt_drag: Ratio = 0.5
    slender_drag: Ratio = 0.25
    angular_drag: Ratio = 1.5
    kutta_lift: Ratio = 1.0
    magnus_lift: Ratio = 1.0
    added_mass: Annotated[Vector, In("kg")] | None = None
    added_inertia: Annotated[Vector, In("kg m^2")] | None = None
    creep: Annotated[float, In("m/s")] = 1e-5
    angular_creep: Annotated[float, In("rad/s")] | None = None

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the ellipsoid."""
        body, *place = self.frame.resolve(poses, "frame")
        refuse_ground(body, "frame")
        remedy = "Give the three semi-axes in m."
        a, b, c = (positive(one, "semiaxes", remedy) for one in vector(self.semiaxes, "semiaxes", remedy))
        _, middle, longest = sorted((a, b, c))
        if not SMALLEST < middle * longest**4 < LARGEST:
            size = "small" if longest < 1 else "large"
            message = f"semiaxes are too {size}, they are {a:.3g}, {b:.3g}, {c:.3g} m. {remedy}"
            raise ModelError(message, field="semiaxes")
        wind, density, viscosity, *creep = checked_fluid(self)
        drags = "blunt_drag", "slender_drag", "angular_drag"
        remedy = "Give a coefficient without a unit."
        blunt, slender, angular = (not_negative(getattr(self, one), one, remedy) for one in drags)
        lift = (number(getattr(self, one), one, remedy) for one in ("kutta_lift", "magnus_lift"))
        masses, inertias = added_masses((a, b, c), density)
        if self.added_mass is not None:
            remedy = "Give three masses in kg."
            masses = _three(self.added_mass, "added_mass", remedy)
        if self.added_inertia is not None:
            remedy = "Give three moments of inertia in kg m²."
            inertias = _three(self.added_inertia, "added_inertia", remedy)
        moments = [8 / 15 * pi * x * max(y, z) ** 4 for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]
        most = 8 / 15 * pi * middle * longest**4
        turning = [angular * one + slender * (most - one) for one in moments]
        values = (
            *place, (a, b, c), wind, density, viscosity, blunt, slender, *lift,
            pi * middle * longest, most, turning, masses, inertias, *creep,
        )  # fmt: skip
        yield Primitive(EllipsoidInFluid, (body,), values, "drag")


def _three(values: Vector, field: str, remedy: str) -> tuple[float, float, float]:
    x, y, z = (not_negative(one, field, remedy) for one in vector(values, field, remedy))
    return x, y, z
