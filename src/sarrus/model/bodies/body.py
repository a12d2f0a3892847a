"""A rigid body: mass, inertia and initial state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..errors import restated
from ..geometry import rotation
from ..geometry.orientation import Orientation, euler_parameters
from ..geometry.points import Solid
from ..geometry.pose import Pose
from ..measure import AngularVelocity, In, Mass, Offset, Position, Velocity
from ..quantity import Array, Vec3, Vector, number, positive, vector
from ..registry import shown
from ..show import quote
from ..text_numbers import with_numbers_of_texts
from . import solids
from .inertia import Inertia, Inertia6, inertia_entries, vanishes
from .shape import Shape


class MassProperties(NamedTuple):
    """Mass [kg], inertia entries about the centre of mass [kg m²], centre of mass in body axes [m]."""

    mass: float
    inertia: Inertia6
    center: Vec3


def _of(name: str, solid: Callable[..., solids.Uniform], *given: Any) -> solids.Uniform:
    """The properties of a solid; an error names the body."""
    with restated(part=f"body {quote(name)}"):
        return solid(*given)


@dataclass(frozen=True, eq=False)
class Body(Solid):
    """A rigid body with its body frame, mass and initial state.

    Parameters
    ----------
    name
        Unique among bodies, joints and forces.
    mass
        [kg], greater than 0; or 0 with no inertia: a frame between joints, whose motion must move other bodies.
    inertia
        About the centre of mass, in body axes [kg m²]: three principal moments, a mapping with
        ``xx, yy, zz`` and if wanted ``xy, xz, yz`` (entries of the tensor: ``xy`` is −∫ x y dm),
        or the whole symmetric 3x3 tensor.
    position
        Global position of the body frame's origin [m], in the design position: where global points of the model are.
    orientation
        Euler parameters (4), rotation matrix (3x3), `AxisAngle` or `EulerAngles`; likewise.
    center_of_mass
        In body axes from the origin [m]. Left out, the origin is the centre of mass.
    velocity
        Global velocity of the origin [m/s]. Left out, it follows from other velocities, and is otherwise zero.
    angular_velocity
        In global axes [rad/s]. Left out, it follows from other velocities, and is otherwise zero.
    initial_position, initial_orientation
        Those at the start, such as in a static equilibrium. Left out, they are those of the design position.
    shape
        Its shape in pictures; by default it is drawn from its joints and points.

    Raises
    ------
    ModelError
        For values that no body has.
    """

    __repr__ = shown

    mass: Mass
    inertia: Annotated[Inertia, In("kg m^2")]
    position: Position = (0.0, 0.0, 0.0)
    orientation: Orientation = (1.0, 0.0, 0.0, 0.0)
    center_of_mass: Offset | None = None
    velocity: Velocity | None = None
    angular_velocity: AngularVelocity | None = None
    initial_position: Position | None = None
    initial_orientation: Orientation | None = None
    shape: Shape | None = None

    def __post_init__(self) -> None:
        with restated(part=f"body {quote(self.name)}"):
            numbers = with_numbers_of_texts(self)
            vars(self).update(vars(numbers))
            self.pose(), self.initial_pose(), self.rates(), self.mass_properties()

    @classmethod
    def box(
        cls, name: str, size: Vector, *, mass: float | None = None, density: float | None = None, **state: Any
    ) -> Body:
        """A uniform box about the origin of its frame.

        Parameters
        ----------
        size : lengths of its edges along x, y and z of the body [m]
        mass, density : one of them [kg], [kg/m³]
        state : position, orientation and other fields of `Body`

        Raises
        ------
        ModelError
            For numbers that no box has.
        """
        return cls(name, *_of(name, solids.box, size, mass, density)[:2], **state)

    @classmethod
    def cylinder(
        cls, name: str, radius: float, length: float, *, axis: str = "z", inner_radius: float = 0.0,
        mass: float | None = None, density: float | None = None, **state: Any,
    ) -> Body:  # fmt: skip
        """A uniform cylinder, disk or tube about the origin of its frame; its axis is x, y or z of the body."""
        found = _of(name, solids.cylinder, radius, length, axis, inner_radius, mass, density)
        return cls(name, *found[:2], **state)

    @classmethod
    def sphere(
        cls,
        name: str,
        radius: float,
        *,
        mass: float | None = None,
        density: float | None = None,
        **state: Any,
    ) -> Body:
        """A uniform ball about the origin of its frame."""
        return cls(name, *_of(name, solids.sphere, radius, mass, density)[:2], **state)

    @classmethod
    def rod(
        cls, name: str, start: Vector, end: Vector, *, radius: float | None = None, mass: float | None = None,
        density: float | None = None, **state: Any,
    ) -> Body:  # fmt: skip
        """A uniform round rod between two global points: its frame is in its middle, with axes along the global ones.

        The ends in body axes are ±(end - start)/2; no axis of the body is along the rod, unless the rod is along a
        global one. Without a radius it is a fortieth of the length.
        """
        found = _of(name, solids.rod, start, end, radius, mass, density)
        return cls(name, found.mass, found.inertia, position=found.center, **state)

    @classmethod
    def from_points(
        cls, name: str, points: Sequence[Vector], *, radius: float | None = None, closed: bool = False,
        mass: float | None = None, density: float | None = None, **state: Any,
    ) -> Body:  # fmt: skip
        """Uniform round rods from point to point, such as a control arm: global points, axes along the global ones.

        The body frame is at the centre of mass. Two points are a `rod`.

        Parameters
        ----------
        points : global positions [m]
        radius : of the rods [m]; by default a fortieth of their total length
        closed : whether a rod connects the last point with the first one
        mass, density : one of them, [kg] of all rods, or [kg/m³]
        state : orientation and velocities, as of a body

        Raises
        ------
        ModelError
            For less than two points, equal neighbours, or numbers that no rod has.
        """
        found = _of(name, solids.frame, points, radius, closed, mass, density)
        return cls(name, found.mass, found.inertia, position=found.center, **state)

    @classmethod
    def from_mesh(
        cls, name: str, file: str | Path, *, scale: float = 1.0, mass: float | None = None,
        density: float | None = None, **state: Any,
    ) -> Body:  # fmt: skip
        """A uniform solid inside of a closed mesh, in the mesh's axes, drawn with it; needs the extra `mesh`.

        Parameters
        ----------
        file : .stl, .obj, .ply, .gltf, .glb or .dae
        scale : what the mesh's numbers are multiplied by to give metres: 0.001 for millimetres
        """
        found = _of(name, solids.mesh, file, scale, mass, density)
        given: dict[str, Any] = {"center_of_mass": found.center, "shape": Shape(str(file), scale)} | state
        return cls(name, found.mass, found.inertia, **given)

    def pose(self) -> Pose:
        """Return the pose in the design position; raise ModelError if it is none."""
        r = np.array(vector(self.position, "position"))
        p = euler_parameters(self.orientation)
        return Pose(r, p, rotation.matrix(p))

    def initial_pose(self) -> Pose:
        """Return the pose at the start; raise ModelError if it is none."""
        pose = self.pose()
        r, p = pose.r, pose.p
        if self.initial_position is not None:
            r = np.array(vector(self.initial_position, "initial_position"))
        if self.initial_orientation is not None:
            with restated("at the start:", field="initial_orientation"):
                p = euler_parameters(self.initial_orientation)
        return Pose(r, p, rotation.matrix(p))

    def rates(self) -> Array:
        """Return the initial q̇ = [ṙ; ṗ], with ṗ = ½ Eᵀω. (7,)"""
        velocity, angular = (
            (0.0, 0.0, 0.0) if x is None else x for x in (self.velocity, self.angular_velocity)
        )
        omega = np.array(vector(angular, "angular_velocity"))
        p_dot = rotation.rates(self.initial_pose().p, omega)
        return np.array([*vector(velocity, "velocity"), *p_dot])

    def given_rates(self) -> tuple[bool, ...]:
        """Return which entries of q̇ are given (7,)."""
        return (self.velocity is not None,) * 3 + (self.angular_velocity is not None,) * 4

    def mass_properties(self) -> MassProperties:
        """Return the checked mass, inertia and centre of mass."""
        center = (
            (0.0, 0.0, 0.0) if self.center_of_mass is None else vector(self.center_of_mass, "center_of_mass")
        )
        given = number(self.mass, "mass", "Give the mass in kg.")
        if given == 0 and vanishes(self.inertia):
            return MassProperties(0.0, (0.0,) * 6, center)
        mass = positive(given, "mass", "Give the mass in kg.")
        return MassProperties(mass, inertia_entries(self.inertia), center)
