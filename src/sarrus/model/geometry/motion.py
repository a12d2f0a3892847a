"""The motions of a branch of a tree: rotating, sliding, rotating about a point, or free; with exact velocities."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from ...algebra import cross
from ..quantity import Array
from . import rotation
from .pose import Pose


class Twist(NamedTuple):
    """A unit of one joint velocity: the velocity of P is ``velocity + omega × (P − point)``, in global axes."""

    omega: Array
    point: Array
    velocity: Array

    def at(self, point: Array) -> Array:
        """Return the velocity of the body-fixed point that is now at the global ``point``. (3,)"""
        return np.asarray(self.velocity + cross(self.omega, point - self.point))


@dataclass(frozen=True, eq=False)
class Motion(ABC):
    """One motion of a branch, named after its joint.

    ``width`` numbers place it, ``freedoms`` numbers are its velocity, and ``zero`` is where it has not moved.
    """

    width: ClassVar[int] = 1
    freedoms: ClassVar[int] = 1
    zero: ClassVar[tuple[float, ...]] = (0.0,)

    name: str

    @abstractmethod
    def moved(self, frame: Pose, values: Array) -> Pose:
        """Return ``frame`` after the motion by ``values``."""

    @abstractmethod
    def twists(self, frame: Pose, values: Array) -> list[Twist]:
        """Return the twist of each freedom; ``frame`` is that before the motion."""

    def expressed_in(self, frame: Pose) -> Motion | None:
        """Return the same motion in the axes of ``frame``, which is given in the present axes and moves along.

        None where other axes would need other coordinates.
        """
        return None


@dataclass(frozen=True, eq=False)
class Turn(Motion):
    """A rotation [rad] about the unit ``axis`` through ``point`` [m], both in the frame that rotates."""

    axis: Array
    point: Array

    def moved(self, frame: Pose, values: Array) -> Pose:
        """Turn the frame."""
        return about(frame, self.point, axis_angle(self.axis, float(values[0])))

    def twists(self, frame: Pose, values: Array) -> list[Twist]:
        """Return ω along the axis."""
        return [Twist(frame.A @ self.axis, frame.global_point(self.point), np.zeros(3))]

    def expressed_in(self, frame: Pose) -> Motion:
        """Return the turn in other axes."""
        return Turn(self.name, frame.local_vector(self.axis), frame.local_point(self.point))


@dataclass(frozen=True, eq=False)
class Slide(Motion):
    """A displacement [m] along the unit ``axis`` of the frame."""

    axis: Array

    def moved(self, frame: Pose, values: Array) -> Pose:
        """Move the frame."""
        return frame._replace(r=frame.r + frame.A @ (self.axis * values[0]))

    def twists(self, frame: Pose, values: Array) -> list[Twist]:
        """Return the velocity along the axis."""
        return [Twist(np.zeros(3), np.zeros(3), frame.A @ self.axis)]

    def expressed_in(self, frame: Pose) -> Motion:
        """Return the slide in other axes."""
        return Slide(self.name, frame.local_vector(self.axis))


@dataclass(frozen=True, eq=False)
class Ball(Motion):
    """A turn about ``point`` [m] by Euler parameters; its velocity is ω in the axes of what turned [rad/s]."""

    width: ClassVar[int] = 4
    freedoms: ClassVar[int] = 3
    zero: ClassVar[tuple[float, ...]] = (1.0, 0.0, 0.0, 0.0)

    point: Array

    def moved(self, frame: Pose, values: Array) -> Pose:
        """Turn the frame."""
        return about(frame, self.point, unit(values))

    def twists(self, frame: Pose, values: Array) -> list[Twist]:
        """Return ω along each axis of the turned frame."""
        center, axes = frame.global_point(self.point), self.moved(frame, values).A
        return [Twist(axes[:, k], center, np.zeros(3)) for k in range(3)]


@dataclass(frozen=True, eq=False)
class Free(Motion):
    """Any motion: position [m] and Euler parameters in the frame.

    Its velocity is that of the origin in the frame's axes [m/s], then ω in the axes of what moved [rad/s].
    """

    width: ClassVar[int] = 7
    freedoms: ClassVar[int] = 6
    zero: ClassVar[tuple[float, ...]] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)

    def moved(self, frame: Pose, values: Array) -> Pose:
        """Move the frame."""
        return compose(frame, pose(values[:3], unit(values[3:])))

    def twists(self, frame: Pose, values: Array) -> list[Twist]:
        """Return three translations, then ω along each axis of the moved frame."""
        there, still = self.moved(frame, values), np.zeros(3)
        slides = [Twist(still, still, frame.A[:, k]) for k in range(3)]
        return slides + [Twist(there.A[:, k], there.r, still) for k in range(3)]


def pose(r: Array, p: Array) -> Pose:
    """Return the pose at ``r`` with the unit Euler parameters ``p``."""
    return Pose(np.asarray(r, dtype=float), p, rotation.matrix(p))


def compose(frame: Pose, then: Pose) -> Pose:
    """Return the pose ``then``, which is given in ``frame``, in what ``frame`` is given in."""
    return pose(frame.global_point(then.r), unit(rotation.product(frame.p, then.p)))


def relative(frame: Pose, other: Pose) -> Pose:
    """Return the pose ``other`` as it is given in ``frame``, where both are given in the same axes."""
    w, x, y, z = frame.p
    back = np.array([w, -x, -y, -z])
    return pose(frame.local_point(other.r), unit(rotation.product(back, other.p)))


def about(frame: Pose, point: Array, p: Array) -> Pose:
    """Return ``frame`` turned by ``p`` about a point of its own."""
    return compose(frame, pose(point - rotation.matrix(p) @ point, p))


def axis_angle(axis: Array, angle: float) -> Array:
    """Return the Euler parameters of a turn about a unit axis. (4,)"""
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])


def unit(p: Array) -> Array:
    """Return ``p`` with unit length. (4,)"""
    return np.asarray(p / np.linalg.norm(p))
