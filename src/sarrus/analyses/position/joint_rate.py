"""Rate of a joint, as a linear function of the velocities: rate = C(q) v."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...algebra import Array
from ...outputs import find_output
from ...outputs.measure import measured
from ...system import System
from ...system.operators.joints import JointCoordinate


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
    """The rate of a joint's angle [rad/s] or displacement [m/s]."""

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
    """The rate of an output that depends on the position: ``slider.x``, ``hook.angle_i``, ``spring.length``.

    Raises
    ------
    UnknownOutput
        If there is no such output, or if it depends on more than the position.
    """
    place = find_output(system, name).place
    return (
        CoordinateRate(place, system.nq)
        if place is not None
        else JointRate(measured(system, name, "a given rate"))
    )
