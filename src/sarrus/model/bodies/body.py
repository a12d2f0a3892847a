"""A rigid body: what it weighs and where it starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from ..geometry import rotation
from ..geometry.orientation import Orientation, euler_parameters
from ..geometry.pose import Pose
from ..geometry.solid import Solid
from ..measure import AngularVelocity, In, Mass, Offset, Place, Velocity
from ..quantity import Array, Vec3, positive, vector
from .inertia import Inertia, Inertia6, inertia_entries
from .shape import Shape


class MassProperties(NamedTuple):
    """Mass [kg], inertia entries about the centre of mass [kg m²], centre of mass in body axes [m]."""

    mass: float
    inertia: Inertia6
    center: Vec3


@dataclass(frozen=True, eq=False)
class Body(Solid):
    """A rigid body with its body frame, mass and initial state.

    Parameters
    ----------
    name
        Unique among bodies, joints and forces.
    mass
        [kg], greater than 0.
    inertia
        About the centre of mass, in body axes [kg m²]: three principal moments, a mapping with
        ``xx, yy, zz`` and if wanted ``xy, xz, yz`` (entries of the tensor: ``xy`` is −∫ x y dm),
        or the whole symmetric 3x3 tensor.
    position
        Global position of the body frame's origin [m].
    orientation
        Euler parameters (4), rotation matrix (3x3), `AxisAngle` or `EulerAngles`.
    center_of_mass
        In body axes from the origin [m]. Left out, the origin is the centre of mass.
    velocity
        Global velocity of the origin [m/s].
    angular_velocity
        In global axes [rad/s].
    shape
        What it is drawn with; left out, it is drawn from its joints and points.

    Notes
    -----
    Nothing is checked here: ``blueprint``, and so ``System``, names what is wrong.
    """

    mass: Mass
    inertia: Annotated[Inertia, In("kg m^2")]
    position: Place = (0.0, 0.0, 0.0)
    orientation: Orientation = (1.0, 0.0, 0.0, 0.0)
    center_of_mass: Offset | None = None
    velocity: Velocity = (0.0, 0.0, 0.0)
    angular_velocity: AngularVelocity = (0.0, 0.0, 0.0)
    shape: Shape | None = None

    def pose(self) -> Pose:
        """Return the initial pose; raise ModelError if it is none."""
        r = np.array(vector(self.position, "position"))
        p = euler_parameters(self.orientation)
        return Pose(r, p, rotation.matrix(p))

    def rates(self) -> Array:
        """Return the initial q̇ = [ṙ; ṗ], with ṗ = ½ Eᵀω. (7,)"""
        omega = np.array(vector(self.angular_velocity, "angular_velocity"))
        p_dot = rotation.rates(euler_parameters(self.orientation), omega)
        return np.array([*vector(self.velocity, "velocity"), *p_dot])

    def mass_properties(self) -> MassProperties:
        """Return the checked mass, inertia and centre of mass."""
        mass = positive(self.mass, "mass", "Give the mass in kg.")
        center = (0.0, 0.0, 0.0) if self.center_of_mass is None else self.center_of_mass
        return MassProperties(mass, inertia_entries(self.inertia), vector(center, "center_of_mass"))
