"""How fast a joint turns or slides, as a linear function of the velocities: rate = C(q) v."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..algebra import Array
from ..system import System
from ..system.joints import JointCoordinate
from .held import place_of, unknown


@dataclass(frozen=True)
class CoordinateRate:
    """The rate of one coordinate."""

    place: int
    size: int

    def row(self, q: Array) -> Array:
        """C(q) (nq,)."""
        return np.asarray(np.eye(1, self.size, self.place)[0])

    def row_xi_q(self, q: Array, xi: Array) -> Array:
        """(C ξ)_q (nq,): zero."""
        return np.zeros(self.size)

    def row_q(self, q: Array) -> Array:
        """(Cᵀ)_q (nq, nq): zero."""
        return np.zeros((self.size, self.size))


@dataclass(frozen=True)
class JointRate:
    """The rate of a joint's angle [rad/s] or travel [m/s]."""

    coordinate: JointCoordinate

    def row(self, q: Array) -> Array:
        """C(q) (nq,)."""
        return np.asarray(self.coordinate.gradient(q).toarray()[0])

    def row_xi_q(self, q: Array, xi: Array) -> Array:
        """(C ξ)_q (nq,)."""
        return np.asarray(self.coordinate.gradient_xi_q(q, xi).toarray()[0])

    def row_q(self, q: Array) -> Array:
        """(Cᵀ)_q (nq, nq), symmetric."""
        return np.asarray(self.coordinate.gradientT_q(q).toarray())


Rate = CoordinateRate | JointRate


def rate(system: System, name: str) -> Rate:
    """The rate of a coordinate (``slider.x``) or of a joint's angle or travel (``hook.angle_i``).

    A joint that has only one of these is named alone (``pin``).

    Raises
    ------
    KeyError
        If there is no such coordinate or joint, or the joint has no such rate.
    """
    place = place_of(system, name)
    if place is not None:
        return CoordinateRate(place, system.nq)
    joint_name, _, what = name.partition(".")
    if joint_name not in {joint.name for joint in system.model.joints}:
        raise KeyError(unknown(system, name, "coordinate or joint"))
    joint = system.joint(joint_name)
    if what not in joint.names if what else len(joint.names) != 1:
        offered = " or ".join(f"{joint_name}.{own}" for own in joint.names)
        raise KeyError(f"the joint {joint_name!r} has no single rate {name!r}; give {offered}")
    return JointRate(joint[what or joint.names[0]])
