"""Joint space: from the angles and displacements of a tree's joints to Cartesian coordinates, and v = T q̇_joint."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...euler import E
from ...model import ModelError
from ...model.expansion.tree import Step, TreeModel, walk
from ...model.geometry.motion import Motion, Twist
from ...model.geometry.points import GROUND
from ...model.geometry.pose import Pose
from ...model.show import quote, suggest
from ...outputs import UnknownOutput, find_output
from ...system import System
from ..arguments import kind


def followed_coordinates(system: System) -> Array:
    """Mark the states that drivers follow (nq,)."""
    return np.isin(np.arange(system.nq), [one.place for one in system.followed_states.values()])


def held_coordinates(system: System, fixed: Iterable[str]) -> Array:
    """Mark the coordinates of the bodies and coordinates that are named (nq,).

    Raises
    ------
    KeyError
        If a name is neither a body's nor a coordinate's.
    """
    held = np.zeros(system.nq, dtype=bool)
    for name in fixed:
        if not isinstance(name, str):
            raise TypeError(
                f"fixed must be names of bodies or coordinates, got {kind(name)}. Pass a list of texts."
            )
        if name in system.bodies:
            held[system.coordinates_of(name)] = True
        else:
            held[coordinate(system, name)] = True
    return held


def coordinate(system: System, name: str) -> int:
    """The place in q of a coordinate.

    Raises
    ------
    UnknownOutput
        If there is no such coordinate.
    """
    output = find_output(system, name)
    if output.place is None:
        raise UnknownOutput(
            f"{system.name}: {name!r} is no coordinate of a body. Name a body or e.g. slider.x."
        )
    return output.place


class JointSpace:
    """Joint coordinates of a system with a tree structure, such as an imported robot.

    A revolute or prismatic joint has one coordinate, the angle [rad] or displacement [m] from the zero of the
    description. A ball joint has four Euler parameters and the velocity ω in body axes. A free body has [r; p] and the
    velocity [ṙ; ω], with ṙ in the axes of its parent and ω in body axes. Joints that close loops, and couplers, are
    ignored.

    Parameters
    ----------
    system : System
        Of a `TreeModel`.

    Attributes
    ----------
    width, freedoms : number of coordinates and of velocities
    coordinates_of, velocities_of : joint name -> indices of its coordinates and velocities

    Raises
    ------
    ModelError
        If the model has no tree.
    """

    def __init__(self, system: System) -> None:
        if not isinstance(system.model, TreeModel):
            raise ModelError("has no tree of joints. Import it from a robot description.", part="model")
        self.system = system
        self._branches = system.model.branches
        self.motions: tuple[Motion, ...] = tuple(m for branch in self._branches for m in branch.motions)
        self.coordinates_of = _places({m.name: m.width for m in self.motions})
        self.velocities_of = _places({m.name: m.freedoms for m in self.motions})
        self.width = sum(m.width for m in self.motions)
        self.freedoms = sum(m.freedoms for m in self.motions)

    def zero(self) -> Array:
        """Return the coordinates of the initial position of all joints. (width,)"""
        return np.array([x for motion in self.motions for x in motion.zero])

    def pack(self, values: Mapping[str, ArrayLike]) -> Array:
        """Return the coordinates with given values of some joints and zero for all others. (width,)

        Raises
        ------
        ModelError
            If there is no such joint.
        """
        theta = self.zero()
        for name, value in values.items():
            if name not in self.coordinates_of:
                raise ModelError(f"there is no joint {quote(name)}. {suggest(name, self.coordinates_of)}")
            theta[self.coordinates_of[name]] = value
        return theta

    def q(self, theta: ArrayLike) -> Array:
        """Forward kinematics: the Cartesian coordinates q of the bodies. (nq,)"""
        q = np.zeros(self.system.nq)
        for step in self._walk(theta):
            q[self.system.coordinates_of(step.branch.body)] = [*step.pose.r, *step.pose.p]
        return q

    def T(self, theta: ArrayLike) -> Array:
        """The tangent map: v = T θ̇, exact; its columns span the null space of the tree joints' Φ_q. (nq, freedoms)"""
        T = np.zeros((self.system.nq, self.freedoms))
        carried: dict[str, dict[int, Twist]] = {}
        first = 0
        for step in self._walk(theta):
            twists = dict(enumerate(step.twists, first))
            first += len(twists)
            carried[step.branch.body] = carried.get(step.branch.parent, {}) | twists
            rows = self.system.coordinates_of(step.branch.body)
            for column, twist in carried[step.branch.body].items():
                T[rows, column] = _rates(step.pose, twist)
        return T

    def v(self, theta: ArrayLike, rates: ArrayLike) -> Array:
        """The velocities v = T θ̇, from parent to child: the cost is proportional to the number of bodies. (nq,)"""
        theta_dot = np.asarray(rates, dtype=float)
        if theta_dot.shape != (self.freedoms,):
            raise ValueError(
                f"rates must have shape ({self.freedoms},), got {theta_dot.shape}. Pass one value for each joint "
                "velocity."
            )
        carried = {GROUND: Twist(np.zeros(3), np.zeros(3), np.zeros(3))}
        v, first = np.zeros(self.system.nq), 0
        for step in self._walk(theta):
            whole = carried[step.branch.parent]
            omega, velocity = whole.omega.copy(), whole.at(step.pose.r)
            for rate, twist in zip(theta_dot[first:], step.twists, strict=False):
                omega, velocity = omega + rate * twist.omega, velocity + rate * twist.at(step.pose.r)
            first += len(step.twists)
            carried[step.branch.body] = moved = Twist(omega, step.pose.r, velocity)
            v[self.system.coordinates_of(step.branch.body)] = _rates(step.pose, moved)
        return v

    def M(self, theta: ArrayLike) -> Array:
        """The mass matrix of the joint velocities, Tᵀ M T. (freedoms, freedoms)"""
        T = self.T(theta)
        return np.asarray(T.T @ (self.system.M(self.q(theta)) @ T))

    def _walk(self, theta: ArrayLike) -> list[Step]:
        coordinates = np.asarray(theta, dtype=float)
        if coordinates.shape != (self.width,):
            raise ValueError(
                f"theta must have shape ({self.width},), got {coordinates.shape}. Pass one value for each joint "
                "coordinate."
            )
        values = {name: coordinates[place] for name, place in self.coordinates_of.items()}
        return list(walk(self._branches, values))


def _rates(pose: Pose, twist: Twist) -> Array:
    """[ṙ; ṗ] of a body that moves with a twist: ṗ = ½ Eᵀω."""
    return np.concatenate([twist.at(pose.r), E(pose.p).T @ twist.omega / 2])


def _places(widths: Mapping[str, int]) -> dict[str, slice]:
    ends = np.cumsum([0, *widths.values()])
    return {name: slice(int(a), int(b)) for name, a, b in zip(widths, ends, ends[1:], strict=False)}
