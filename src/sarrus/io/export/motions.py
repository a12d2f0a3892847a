"""The motions that each kind of joint leaves body j in body i, in the axes of body j, in a given position."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import pi
from typing import Any

import numpy as np

from ...model import (
    Cartesian,
    Cylindrical,
    Fixed,
    Joint,
    Planar,
    PointOnLine,
    PointOnPlane,
    Revolute,
    Screw,
    Spherical,
    Translational,
    Universal,
)
from ...model.geometry.motion import Ball, Free, Motion, Slide, Turn, Twist, relative
from ...model.geometry.points import GROUND, LocalFrame
from ...model.geometry.pose import GROUND_POSE, Pose, Poses
from ...model.quantity import Array, Vec3
from ..robot import Edge, Mimic


class Axes:
    """The frames of a joint, and its vectors in the axes of body j."""

    def __init__(self, name: str, i: LocalFrame, j: LocalFrame, poses: Mapping[str, Pose]) -> None:
        self.name, self.i, self.j, self.poses = name, i, j, poses

    def of_i(self, vector: Vec3) -> Array:
        """Return a vector of body i in the axes of body j."""
        return self.poses[self.j.body].local_vector(self.poses[self.i.body].A @ np.array(vector))

    def turn(self, axis: Array, ending: str = "") -> Motion:
        """Return the rotation about an axis through P_j."""
        return Turn(f"{self.name}{ending}", axis, np.array(self.j.s))

    def slides(self) -> tuple[Motion, Motion, Motion]:
        """Return the displacements along f_i, g_i and h_i."""
        vectors = zip("xyz", (self.i.f, self.i.g, self.i.h), strict=True)
        x, y, z = (Slide(f"{self.name}.displacement_{word}", self.of_i(vector)) for word, vector in vectors)
        return x, y, z

    def ball(self, ending: str = "") -> Motion:
        """Return the rotations about P_j."""
        return Ball(f"{self.name}{ending}", np.array(self.j.s))


def _cylindrical(axes: Axes) -> tuple[Motion, ...]:
    along = axes.of_i(axes.i.h)
    return Slide(f"{axes.name}.displacement", along), axes.turn(along, ".angle")


def _universal(axes: Axes) -> tuple[Motion, ...]:
    return axes.turn(axes.of_i(axes.i.h), ".angle_i"), axes.turn(np.array(axes.j.h), ".angle_j")


MOTIONS: dict[type[Joint], Callable[[Axes], tuple[Motion, ...]]] = {
    Fixed: lambda axes: (),
    Revolute: lambda axes: (axes.turn(axes.of_i(axes.i.h)),),
    Translational: lambda axes: (Slide(axes.name, axes.of_i(axes.i.h)),),
    Cylindrical: _cylindrical,
    Screw: _cylindrical,
    Planar: lambda axes: (*axes.slides()[:2], axes.turn(axes.of_i(axes.i.h), ".angle")),
    Cartesian: lambda axes: axes.slides(),
    Universal: _universal,
    Spherical: lambda axes: (axes.ball(),),
    PointOnLine: lambda axes: (Slide(f"{axes.name}.displacement", axes.of_i(axes.i.h)), axes.ball(".ball")),
    PointOnPlane: lambda axes: (*axes.slides()[:2], axes.ball(".ball")),
}


def edge_of(
    joint: Joint, initial: Poses, poses: Mapping[str, Pose], link: Callable[[str], str]
) -> Edge | None:
    """Return a joint as an edge between links, or None if it is of another kind.

    Parameters
    ----------
    initial : poses in which global points and axes are given
    poses : those in which coordinates are zero
    link : returns the name of the link of a body
    """
    make = MOTIONS.get(type(joint))
    if make is None:
        return None
    i, j = _frames(joint, initial)
    motions = make(Axes(joint.name, i, j, poses))
    return Edge(joint.name, link(i.body), link(j.body), relative(poses[i.body], poses[j.body]), motions)


def _frames(joint: Any, initial: Poses) -> tuple[LocalFrame, LocalFrame]:
    """Return both frames; the axes of those of a ball do not matter."""
    if not isinstance(joint, Spherical):
        i, j = joint.frames(initial)
        return i, j
    x, y, z = np.eye(3)
    (piece,) = joint.primitives(initial)
    (s_i, s_j), axes = piece.values, (tuple(x), tuple(y), tuple(z))
    return LocalFrame(piece.bodies[0], s_i, *axes), LocalFrame(piece.bodies[1], s_j, *axes)


def screw_of(joint: Joint) -> dict[str, Mimic]:
    """Return what the displacement of a screw follows."""
    if not isinstance(joint, Screw):
        return {}
    return {f"{joint.name}.displacement": Mimic(f"{joint.name}.angle", float(joint.pitch) / (2 * pi))}


def motion_of(joint: str, coordinate: str, edges: Mapping[str, Edge]) -> Motion | None:
    """Return the motion of a coordinate, as ``angle``, of a joint."""
    names = (
        {joint, f"{joint}.{coordinate}"}
        if coordinate in ("angle", "displacement")
        else {f"{joint}.{coordinate}"}
    )
    return (
        next((motion for motion in edges[joint].motions if motion.name in names), None)
        if joint in edges
        else None
    )


def rates(
    edges: Sequence[Edge], poses: Mapping[str, Pose], twists: Mapping[str, tuple[Array, Array]]
) -> dict[str, Array]:
    """Return the velocities of motions, where their coordinates are zero.

    Parameters
    ----------
    twists : velocity of the origin and angular velocity of each body, in global axes
    """
    found: dict[str, Array] = {}
    for edge in edges:
        frame = poses[edge.child]
        (v, omega), (v_i, omega_i) = twists[edge.child], twists[edge.parent or GROUND]
        apart = frame.r - poses[edge.parent or GROUND].r
        relative_rates = np.concatenate([v - v_i - np.cross(omega_i, apart), omega - omega_i])
        units = [(motion, twist) for motion in edge.motions for twist in _units(motion, frame)]
        columns = [np.concatenate([twist.at(frame.r), twist.omega]) for _, twist in units]
        solved = np.linalg.lstsq(np.transpose(columns), relative_rates, rcond=None)[0] if columns else ()
        for (motion, _), value in zip(units, solved, strict=True):
            found[motion.name] = np.append(found.get(motion.name, []), value)
    return found


def _units(motion: Motion, frame: Pose) -> list[Twist]:
    """Return the unit twists of a motion; those of a free body are its own, from the origin of the world."""
    if isinstance(motion, Free):
        return motion.twists(GROUND_POSE, np.concatenate([frame.r, frame.p]))
    return motion.twists(frame, np.array(motion.zero))
