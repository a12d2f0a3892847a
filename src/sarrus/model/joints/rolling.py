"""Rolling without slip of a sphere, a disc and a wheel on a plane, and the knife edge: nonholonomic constraints.

The velocity of the point of body j that is at the contact, relative to body i, which has the plane, vanishes:

    u = d/dt C_j + ω_j x ρ - (ṙ_i + ω_i x (C_j + ρ - r_i)) = 0 along f_i and g_i,

with the centre C_j and the contact at C_j + ρ. That it stays in the plane is a holonomic equation.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ... import elements
from ...algebra import Array, cross
from ...elements import Nonholonomic, Pair
from ...elements.element import Scalar, Vec3
from ...euler import B, E, rotate
from ...functions import sqrt
from ..errors import ModelError
from ..geometry.placement import Frames, refuse_same_body
from ..geometry.points import PERPENDICULAR, Frame, LocalFrame, Point, Solid, frame_axes, ground
from ..geometry.pose import Poses
from ..measure import Direction, Length
from ..parity import POLAR, Parities, declared
from ..primitive import Primitive
from ..quantity import Vec3 as Numbers
from ..quantity import direction, positive, triple
from .joint import Joint, basic_constraints


def slip(x: Pair, xi: Pair, s_j: Array, arm: Array) -> Array:
    """The velocity of body j relative to body i at C_j + arm, for velocities ξ. (3,) [m/s]"""
    at = x.r_j + rotate(x.p_j, s_j) + arm - x.r_i
    omega_i, omega_j = 2 * E(x.p_i) @ xi.p_i, 2 * E(x.p_j) @ xi.p_j
    own = xi.r_j + B(x.p_j, s_j) @ xi.p_j + cross(omega_j, arm)
    return np.asarray(own - xi.r_i - cross(omega_i, at))


def lowest(n: Array, a: Array, radius: Scalar) -> Array:
    """Return the vector from the centre of a circle about the axis a to its lowest point along n (3,) [m]."""
    slope = n - (n @ a) * a
    return np.asarray(-radius / sqrt(slope @ slope) * slope)


def in_plane(of: SphereRolls | DiscRolls, x: Pair, u: Array) -> Array:
    """Return the components of a velocity along f_i and g_i (2,) [m/s]."""
    return np.array([rotate(x.p_i, of.f_i) @ u, rotate(x.p_i, of.g_i) @ u])


class SphereRolls(Nonholonomic, rows=2, derivatives="automatic", rare=True):
    """f_i·u = g_i·u = 0 [m/s] at the contact C_j - radius h_i of a sphere."""

    f_i: Vec3  # [-] in the plane; f_i, g_i, h_i right-handed
    g_i: Vec3  # [-]
    h_i: Vec3  # [-] its normal, towards the sphere
    s_j: Vec3  # [m] the centre in body j
    radius: Scalar  # [m]

    def Phi_q_xi(self, x: Pair, xi: Pair) -> Array:
        return in_plane(self, x, slip(x, xi, self.s_j, -self.radius * rotate(x.p_i, self.h_i)))


class DiscRolls(Nonholonomic, rows=2, derivatives="automatic", rare=True):
    """f_i·u = g_i·u = 0 [m/s] at the lowest point of a circle about the axis a_j."""

    f_i: Vec3  # [-] in the plane; f_i, g_i, h_i right-handed
    g_i: Vec3  # [-]
    h_i: Vec3  # [-] its normal, towards the disc
    s_j: Vec3  # [m] the centre in body j
    a_j: Vec3  # [-] the axis in body j
    radius: Scalar  # [m]

    def Phi_q_xi(self, x: Pair, xi: Pair) -> Array:
        arm = lowest(rotate(x.p_i, self.h_i), rotate(x.p_j, self.a_j), self.radius)
        return in_plane(self, x, slip(x, xi, self.s_j, arm))


class DiscTouches(elements.Primitive, rows=1, derivatives="automatic", rare=True):
    """Φ = h_i·(C_j + ρ - P_i) [m] for the lowest point of a circle about the axis a_j."""

    s_i: Vec3  # [m] a point of the plane in body i
    h_i: Vec3  # [-] its normal, towards the disc
    s_j: Vec3  # [m] the centre in body j
    a_j: Vec3  # [-] the axis in body j
    radius: Scalar  # [m]

    def Phi(self, x: Pair) -> Array:
        n = rotate(x.p_i, self.h_i)
        C = x.r_j + rotate(x.p_j, self.s_j) - x.r_i - rotate(x.p_i, self.s_i)
        return np.array([n @ (C + lowest(n, rotate(x.p_j, self.a_j), self.radius))])


class NoSideSlip(Nonholonomic, rows=1, derivatives="automatic", rare=True):
    """a_j·u = 0 [m/s] for the point P_j."""

    s_j: Vec3  # [m] P_j in body j
    a_j: Vec3  # [-] across the edge, in body j

    def Phi_q_xi(self, x: Pair, xi: Pair) -> Array:
        u = slip(x, xi, self.s_j, 0 * self.s_j)
        return np.array([rotate(x.p_j, self.a_j) @ u])


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class RollingOnPlane:
    """A round body j with a centre and a radius, on a plane of body i.

    Parameters
    ----------
    center
        The centre of the sphere, disc or wheel.
    plane
        A frame whose origin is in the plane and whose third axis is its normal, towards the centre.
    radius
        [m]
    """

    parity: ClassVar[Parities] = declared(plane="polar", axis="axial")

    center: Point
    plane: Frame
    radius: Length

    def _parts(self, poses: Poses) -> tuple[LocalFrame, str, Numbers, float]:
        """The plane, the rolling body, its centre there, and its radius."""
        plane, center = self.plane.resolve(poses, "plane"), self.center.resolve(poses, "center")
        refuse_same_body(center.body, plane.body, "plane")
        return plane, *center, positive(self.radius, "radius", "Give the radius in m.")


@dataclass(frozen=True, eq=False)
class RollingSphere(RollingOnPlane, Joint):
    """A sphere that rolls on a plane without slip; it may spin about the normal.

    One equation for positions, h_i·(C_j - P_i) = radius, and two for velocities. The reaction, which acts at the
    contact, is given as force and torque at the centre.
    """

    def frames(self, poses: Poses) -> Frames:
        """Return the plane's frame and one at the centre."""
        plane, body, s, _ = self._parts(poses)
        return Frames(plane, LocalFrame(body, s, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the contact and the two conditions of rolling."""
        plane, body, s, radius = self._parts(poses)
        yield touches(plane, body, s, radius)
        yield rolls(plane, body, s, radius)


def touches(plane: LocalFrame, body: str, s: Numbers, radius: float) -> Primitive:
    """The centre is at a height above the plane: Φ^d2, Eq. (88)."""
    raised = triple(np.array(plane.s) + radius * np.array(plane.h))
    return Primitive(elements.Dot2, (plane.body, body), (plane.h, raised, s), "contact")


def rolls(plane: LocalFrame, body: str, s: Numbers, radius: float) -> Primitive:
    """No slip of the point that is a radius below the centre."""
    return Primitive(SphereRolls, (plane.body, body), (plane.f, plane.g, plane.h, s, radius), "rolling")


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class RollingOnAxis(RollingOnPlane):
    """The same for a circle about an ``axis`` of body j, a global direction in the design position."""

    axis: Direction

    def frames(self, poses: Poses) -> Frames:
        """Return the plane's frame and one at the centre, with h along the axis."""
        plane, body, s, _ = self._parts(poses)
        normal = poses[plane.body].A @ np.array(plane.h)
        if np.linalg.norm(np.cross(normal, direction(self.axis, "axis"))) < PERPENDICULAR:
            raise ModelError("axis is along the normal of the plane. Tilt the body, or the frame of the plane.",
                             field="axis")  # fmt: skip
        axes = poses[body].A.T @ frame_axes(None, self.axis, "axis")
        return Frames(plane, LocalFrame(body, s, *(triple(axes[:, k]) for k in range(3))))


@dataclass(frozen=True, eq=False)
class RollingDisc(RollingOnAxis, Joint):
    """A thin disc that rolls on a plane without slip and may lean, like a coin.

    One equation for positions, which puts its lowest point in the plane, and two for velocities. Lying flat it has no
    lowest point. The reaction is given as force and torque at the centre.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the contact and the two conditions of rolling."""
        plane, _, s, radius = self._parts(poses)
        i, j = self.frames(poses)
        yield Primitive(DiscTouches, (i.body, j.body), (i.s, i.h, s, j.h, radius), "contact")
        yield Primitive(DiscRolls, (i.body, j.body), (i.f, i.g, i.h, s, j.h, radius), "rolling")


@dataclass(frozen=True, eq=False)
class RollingWheel(RollingOnAxis, Joint):
    """A wheel that rolls on a plane without slip and stays upright: its axis is parallel to the plane.

    Two equations for positions, the height of the centre and the direction of the axis, and two for velocities: no slip
    along the path and none to the side. The reaction is given as force and torque at the centre.
    """

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the contact, Φ^d1(h_i, h_j), and the two conditions of rolling."""
        plane, body, s, radius = self._parts(poses)
        i, j = self.frames(poses)
        yield touches(plane, body, s, radius)
        yield from basic_constraints(i, j, "h_i.h_j")
        yield rolls(plane, body, s, radius)


@dataclass(frozen=True, eq=False)
class KnifeEdge(Joint):
    """A point of a body that moves along an edge but not across it, like a skate, a runner or a light wheel.

    Parameters
    ----------
    point
        On body j.
    axis
        The direction across the edge, in which the point has no velocity, fixed in body j: global,
        in the design position.
    body_i
        Relative to which the point moves, by default the ground.

    One equation for velocities, none for positions.
    """

    parity = POLAR

    point: Point
    axis: Direction
    body_i: Solid = ground

    def frames(self, poses: Poses) -> Frames:
        """Return a frame on both bodies at the point, with h across the edge."""
        point = self.point.resolve(poses, "point")
        refuse_same_body(self.body_i.name, point.body, "point")
        at = Point(self.body_i, triple(point.position(poses)), "global")
        return Frames(
            Frame(at, z=self.axis).resolve(poses, "point", "axis"),
            Frame(Point(self.point.body, at.coordinates, "global"), z=self.axis).resolve(
                poses, "point", "axis"
            ),
        )

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the condition that there is no side slip."""
        i, j = self.frames(poses)
        yield Primitive(NoSideSlip, (i.body, j.body), (j.s, j.h), "side slip")
