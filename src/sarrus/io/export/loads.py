"""Forces of a model as dynamics of motions, springs between points, and constant forces."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import inf
from typing import Any, NamedTuple

import numpy as np

from ... import elements
from ...elements.element import Pair
from ...model import Model
from ...model.coordinate import angle_between
from ...model.expansion.expand import expand
from ...model.forces.spherical_joint import RotationInertia, RotationSpring
from ...model.geometry.motion import Ball, Motion, Slide, Turn
from ...model.geometry.points import GROUND
from ...model.geometry.pose import Pose
from ...model.primitive import Primitive
from ...model.quantity import Vec3, triple
from ..robot import Dynamics, Edge
from ..robot.description import WORLD
from .missing import Gap, no_place

PARALLEL = 1e-9


class Spring(NamedTuple):
    """A linear spring and damper between two points, in body axes [m]."""

    name: str
    bodies: tuple[str, str]
    points: tuple[Vec3, Vec3]
    stiffness: float
    damping: float
    length: float


class PointLoad(NamedTuple):
    """A constant force [N] in global axes at a point of a body [m]."""

    name: str
    body: str
    point: Vec3
    force: Vec3


class Match(NamedTuple):
    """A motion, the sign of a coordinate along or about an axis, and its value where the motion is zero."""

    motion: str
    sign: float
    start: float


class Loads:
    """The forces of a model but actuators; ``missing`` are those that none of the fields can have.

    Attributes
    ----------
    owners : by motion and field of its dynamics, the names of the forces that it is the sum of
    """

    def __init__(
        self, model: Model, edges: Mapping[str, Edge], poses: Mapping[str, Pose], actuators: Collection[str]
    ) -> None:
        self.edges, self.poses = edges, poses
        self.dynamics: dict[str, Dynamics] = {}
        self.ranges: dict[str, tuple[float | None, float | None]] = {}
        self.springs: list[Spring] = []
        self.pushes: list[PointLoad] = []
        self.owners: dict[tuple[str, str], list[str]] = {}
        self.missing: list[Gap] = []
        expanded = expand(model).pieces
        for force in (one for one in model.forces if one.name not in actuators):
            pieces = [piece.primitive for piece in expanded if piece.owner == force.name]
            if not all(self._take(force.name, piece) for piece in pieces):
                self.missing.append(no_place(force.name, type(force).__name__).missing)

    def _take(self, name: str, piece: Primitive) -> bool:
        take = _TAKERS.get(piece.element)
        return take is not None and bool(take(self, name, piece.bodies, piece.values))

    def add(self, name: str, match: Match | None, **values: float) -> bool:
        """Add dynamics of a force to a motion."""
        if match is None:
            return False
        for field in values:
            if values[field] and field != "free":
                self.owners.setdefault((match.motion, field), []).append(name)
        before = self.dynamics.get(match.motion, Dynamics())
        k = before.stiffness + values.get("stiffness", 0.0)
        moment = before.stiffness * before.free + values.get("stiffness", 0.0) * values.get("free", 0.0)
        self.dynamics[match.motion] = Dynamics(
            stiffness=k,
            free=moment / k if k else 0.0,
            damping=before.damping + values.get("damping", 0.0),
            friction=before.friction + values.get("friction", 0.0),
            inertia=before.inertia + values.get("inertia", 0.0),
        )
        return True

    def angle(
        self, bodies: tuple[str, ...], f_i: Vec3, g_i: Vec3, f_j: Vec3, start: float | None = None
    ) -> Match | None:
        """Return the rotation that an angle from f_i to f_j measures."""
        h_i = np.cross(f_i, g_i)
        match = self.motion(bodies, h_i, Turn)
        if match is None:
            return None
        now = angle_between((bodies[0], f_i), (bodies[0], g_i), (bodies[1], f_j), self.poses)
        revolutions = 0.0 if start is None else round((start - now) / (2 * np.pi))
        return match._replace(start=now + 2 * np.pi * revolutions)

    def displacement(self, bodies: tuple[str, ...], h_i: Vec3, s_i: Vec3, s_j: Vec3) -> Match | None:
        """Return the slide that a displacement along h_i measures."""
        match = self.motion(bodies, np.array(h_i), Slide)
        apart = self.poses[bodies[1]].global_point(np.array(s_j)) - self.poses[bodies[0]].global_point(
            np.array(s_i)
        )
        return match and match._replace(start=float(self.poses[bodies[0]].A @ np.array(h_i) @ apart))

    def motion(self, bodies: tuple[str, ...], axis: Any, kind: type[Motion]) -> Match | None:
        """Return the motion of a kind between two bodies, along or about an axis of the first, or about a point."""
        ends = [WORLD if body == GROUND else body for body in bodies]
        along = self.poses[bodies[0]].A @ np.array(axis)
        for edge in self.edges.values():
            if {edge.parent, edge.child} != {*ends}:
                continue
            for motion in edge.motions:
                forward = 1.0 if edge.parent == ends[0] else -1.0
                if isinstance(motion, kind) and isinstance(motion, Ball):
                    return Match(motion.name, forward, 0.0)
                if isinstance(motion, kind) and isinstance(motion, Turn | Slide):
                    there = self.poses[edge.child].A @ motion.axis if edge.child else motion.axis
                    cosine = float(there @ along)
                    if abs(abs(cosine) - 1) < PARALLEL:
                        return Match(motion.name, forward * float(np.sign(cosine)), 0.0)
        return None


def _rsda(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    f_i, g_i, _h_i, f_j, _h_j, k, c, free, torque, start = values
    match = loads.angle(bodies, f_i, g_i, f_j, start)
    at = 0.0 if match is None else match.sign * (free - match.start)
    return not torque and loads.add(name, match, stiffness=k, damping=c, free=at)


def _bushing(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    """Take a spring along the third axis only."""
    s_i, _f, _g, h_i, s_j, _e_0, _e, K, C, preload = values
    K, C, preload = np.array(K).reshape(6, 6), np.array(C).reshape(6, 6), np.array(preload)
    only = np.zeros((6, 6), bool)
    only[2, 2] = True
    k, c = float(K[2, 2]), float(C[2, 2])
    if np.any(K[~only]) or np.any(C[~only]) or np.any(preload[~only[2]]) or (preload[2] and not k):
        return False
    match = loads.displacement(bodies, h_i, s_i, s_j)
    if match is None:
        return False
    free = preload[2] / k if k else 0.0
    return loads.add(name, match, stiffness=k, damping=c, free=match.sign * (free - match.start))


def _tsda(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    s_i, s_j, k, c, length, force = values
    loads.springs.append(Spring(name, (bodies[0], bodies[1]), (s_i, s_j), k, c, length))
    return not force


def _angle_inertia(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    f_i, g_i, f_j, inertia = values
    return loads.add(name, loads.angle(bodies, f_i, g_i, f_j), inertia=inertia)


def _displacement_inertia(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    h_i, s_i, s_j, inertia = values
    return loads.add(name, loads.displacement(bodies, h_i, s_i, s_j), inertia=inertia)


def _angle_friction(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    h_i, radius, load, mu, mu_static, _stribeck, _creep, viscous = values
    match = loads.motion(bodies, h_i, Turn)
    return mu == mu_static and loads.add(
        name, match, friction=load * mu * radius, damping=viscous * radius**2
    )


def _displacement_friction(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    h_i, _s_j, load, mu, mu_static, _stribeck, _creep, viscous = values
    match = loads.motion(bodies, h_i, Slide)
    return mu == mu_static and loads.add(name, match, friction=load * mu, damping=viscous)


def _angle_stop(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    f_i, g_i, _h_i, f_j, _h_j, limit, sign, *_contact, start = values
    return _stop(loads, loads.angle(bodies, f_i, g_i, f_j, start), limit, sign)


def _displacement_stop(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    h_i, s_i, s_j, limit, sign, *_contact = values
    return _stop(loads, loads.displacement(bodies, h_i, s_i, s_j), limit, sign)


def _rotation_spring(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    """Take a spring that is free in the assembled position, and friction about the axes of the child."""
    *_, k, c, friction, _creep = values
    i, j = (loads.poses[body] for body in bodies)
    turned = np.linalg.norm(RotationSpring(*values).rotation(Pair(i.r, i.p, j.r, j.p)))
    match = loads.motion(bodies, np.zeros(3), Ball)
    if match is None or (k and turned > PARALLEL) or (friction and match.sign < 0):
        return False
    return loads.add(name, match, stiffness=k, damping=c, friction=friction)


def _rotation_inertia(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    return loads.add(name, loads.motion(bodies, np.zeros(3), Ball), inertia=values[0])


def _stop(loads: Loads, match: Match | None, limit: float, sign: float) -> bool:
    """Take one end of the range of a coordinate: the upper one where the sign is positive."""
    if match is None:
        return False
    lower, upper = loads.ranges.get(match.motion, (None, None))
    value = match.sign * (limit - match.start)
    loads.ranges[match.motion] = (lower, value) if sign * match.sign > 0 else (value, upper)
    return True


def _point_force(loads: Loads, name: str, bodies: tuple[str, ...], values: Any) -> bool:
    s, force = values
    loads.pushes.append(PointLoad(name, bodies[0], s, triple(force)))
    return bool(np.all(np.abs(force) < inf))


_TAKERS: dict[Any, Any] = {
    elements.RSDA: _rsda,
    elements.Bushing: _bushing,
    elements.TSDA: _tsda,
    elements.AngleInertia: _angle_inertia,
    elements.DisplacementInertia: _displacement_inertia,
    elements.AngleFriction: _angle_friction,
    elements.DisplacementFriction: _displacement_friction,
    RotationSpring: _rotation_spring,
    RotationInertia: _rotation_inertia,
    elements.AngleStop: _angle_stop,
    elements.DisplacementStop: _displacement_stop,
    elements.PointForce: _point_force,
}
