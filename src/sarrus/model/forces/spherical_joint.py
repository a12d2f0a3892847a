"""Spring, damper, dry friction and inertia of the relative rotation of two bodies, as in a spherical joint.

With the angular velocity w of body j relative to body i and the rotation vector ϑ = φ n of its rotation by φ ≤ π about
n, both in the axes of body j:

    torque on body j, opposed on body i: -k ϑ - c w - T tanh(w / creep), componentwise,
    kinetic energy: ½ I w·w.

k ϑ is the gradient of ½ k φ². It jumps at half a revolution, where n is not unique. The inertia follows from Lagrange's
equations, with w = 2 E(p_j) ṗ_j - 2 E(p_i) ṗ_i in global axes: S_j = -4 I Eᵀ(ṗ_j) w, S_i = 4 I Eᵀ(ṗ_i) w, since
E(p) ṗ = -E(ṗ) p. The paper has neither.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from ... import elements
from ...algebra import Array, Row
from ...elements.element import Grid, Pair, Scalar, Vec3
from ...elements.force_outputs import Passive
from ...elements.forces.bushing import rotation_vector
from ...euler import E, G
from ...functions import tanh
from ..geometry.placement import placed_frames, refuse_same_body
from ..geometry.points import Frame, Solid
from ..geometry.pose import Poses
from ..measure import In, Place
from ..parity import POLAR
from ..primitive import Primitive
from ..quantity import not_negative
from ..quantity import positive as checked_positive
from .force import Force


class RotationSpring(Passive, elements.Force, derivatives="automatic", rare=True):
    """Torque against the rotation of body j relative to body i, from an orientation without torque."""

    e_0: Scalar  # [-] Euler parameters of body j in body i without torque
    e: Vec3  # [-]
    k: Scalar  # [N m/rad]
    c: Scalar  # [N m s/rad]
    friction: Scalar  # [N m]
    creep: Scalar  # [rad/s]

    def rotation(self, x: Pair) -> Array:
        """ϑ [rad] in the axes of body j."""
        free = self.e_0 * x.p_i + self.e @ G(x.p_i)  # where body j would be without torque
        return rotation_vector(free @ x.p_j, G(free) @ x.p_j)[0]

    def resistance(self, w: Array) -> Array:
        """The torque of the damper and of friction against w."""
        found: Array = self.c * w + self.friction * np.array([tanh(one / self.creep) for one in w])
        return found

    def potential(self, x: Pair) -> tuple[Scalar, ...]:
        """½ k φ² [J]."""
        turned = self.rotation(x)
        return (self.k * (turned @ turned) / 2,)

    def dissipated_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Power that the damper and friction dissipate."""
        w = relative_spin(x, v) @ _in_body_axes(x.p_j)
        return self.resistance(w) @ w

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        axes = _in_body_axes(x.p_j)
        torque = -self.k * self.rotation(x) - self.resistance(relative_spin(x, v) @ axes)
        return None, -2 * ((axes @ torque) @ E(x.p_i)), None, 2 * (torque @ G(x.p_j))


class RotationInertia(elements.InertiaElement, bodies=2, derivatives="automatic", rare=True):
    """Inertia of the rotation of body j relative to body i, the same about all axes."""

    inertia: Scalar  # [kg m²]

    def M(self, x: Pair) -> Grid:
        E_i, E_j, I = E(x.p_i), E(x.p_j), 4 * self.inertia
        mixed = -I * (E_i.T @ E_j)
        none = (None,) * 4
        return none, (None, I * (E_i.T @ E_i), None, mixed), none, (None, mixed.T, None, I * (E_j.T @ E_j))

    def S(self, x: Pair, v: Pair) -> Row:
        w = 4 * self.inertia * relative_spin(x, v)
        return None, w @ E(v.p_i), None, -(w @ E(v.p_j))


def relative_spin(x: Pair, v: Pair) -> Array:
    """ω_j - ω_i in global axes."""
    spins: list[Array] = [2 * (E(p) @ rate) for p, rate in ((x.p_i, v.p_i), (x.p_j, v.p_j))]
    return spins[1] - spins[0]


def _in_body_axes(p: Array) -> Array:
    """A(p) = E Gᵀ, which is orthogonal."""
    return E(p) @ G(p).T


@dataclass(frozen=True, eq=False)
class SphericalSpring(Force):
    """A torque −k φ n − c w − friction · tanh(w / creep) on body j, and the opposite one on body i.

    φ n is the rotation vector of body j in body i, 0 ≤ φ ≤ π, and w its relative angular velocity, in the axes of body
    j. Beyond half a revolution the spring pulls back the shorter way, and its torque jumps. Placed by a
    global ``point`` [m] in the design position, where φ then starts at 0, or by ``frame_i`` and ``frame_j``, with φ = 0
    where their axes are parallel; where their origins are does not matter.

    Parameters
    ----------
    body_i, body_j
        The two bodies, if they are placed by a point.
    k
        Stiffness [N m/rad], not negative.
    c
        Damping [N m s/rad], not negative.
    friction
        Dry friction [N m] about each axis of body j, not negative.
    creep
        Speed of regularization [rad/s]: far below it, friction sticks, and the bodies creep.
    """

    parity = POLAR

    body_i: Solid | None = None
    body_j: Solid | None = None
    point: Place | None = None
    frame_i: Frame | None = None
    frame_j: Frame | None = None
    k: Annotated[float, In("N m/rad")] = field(default=0.0, kw_only=True)
    c: Annotated[float, In("N m s/rad")] = field(default=0.0, kw_only=True)
    friction: Annotated[float, In("N m")] = field(default=0.0, kw_only=True)
    creep: Annotated[float, In("rad/s")] = field(default=1e-3, kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        i, j = frames = placed_frames(self, None, poses)
        values = [
            not_negative(getattr(self, name), name, "Give 0 or more.") for name in ("k", "c", "friction")
        ]
        creep = checked_positive(self.creep, "creep", "Give a small speed in rad/s.")
        yield Primitive(RotationSpring, (i.body, j.body), (*frames.parallel(), *values, creep), "spring")


@dataclass(frozen=True, eq=False)
class SphericalInertia(Force):
    """Kinetic energy ½ inertia · w·w of the relative angular velocity w of two bodies, as of an armature.

    Parameters
    ----------
    body_i, body_j
        The two bodies.
    inertia
        [kg m²], not negative.
    """

    body_i: Solid
    body_j: Solid
    inertia: Annotated[float, In("kg m^2")] = field(kw_only=True)

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        refuse_same_body(self.body_i.name, self.body_j.name, "body_j")
        inertia = not_negative(self.inertia, "inertia", "Give it in kg m².")
        yield Primitive(RotationInertia, (self.body_i.name, self.body_j.name), (inertia,), "inertia")
