"""The displacement or rotation that one constraint equation restrains, and its gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...euler import E
from ...system.layout import Layout

NOTHING = 1e-9  # a gradient so small that no direction can be read from it
ALONG = 0.999  # cosine from which a direction is called x, y or z


@dataclass(frozen=True)
class Restraint:
    """A direction of relative motion at which an equation works.

    Attributes
    ----------
    kind : "displacement", "rotation", or "nothing" where the gradient vanishes
    direction : (3,) unit vector, global axes
    rate : |Φ̇| per m/s or rad/s in this direction
    first : first coordinate of the body that is moved
    """

    kind: Literal["displacement", "rotation", "nothing"]
    direction: Array
    rate: float
    first: int = 0

    @property
    def unit(self) -> str:
        """The unit of a gap."""
        return {"displacement": "m", "rotation": "rad", "nothing": "in its own unit"}[self.kind]

    def gap(self, residual: float, curvature: float = 0.0) -> float:
        """The gap of the equation [m], [rad]: |s| with Φ + Φ' s + ½ Φ'' s² = 0, or else to first order."""
        if self.kind == "nothing":
            return abs(residual)
        inside = self.rate**2 - 2 * curvature * residual
        root = np.sqrt(inside) if inside > 0 else self.rate
        return float(2 * abs(residual) / (self.rate + root))

    def displacement(self, size: int) -> Array:
        """The direction as a direction of all coordinates (size,), zero for rotations."""
        xi = np.zeros(size)
        if self.kind == "displacement":
            xi[self.first : self.first + len(self.direction)] = self.direction
        return xi

    def words(self) -> str:
        """For example "displacement along z", "rotation about (0.500, 0.866, 0.000)"."""
        if self.kind == "nothing":
            return "an equation without gradient"
        preposition = "along" if self.kind == "displacement" else "about"
        return f"{self.kind} {preposition} {axis_name(self.direction)}"


def axis_name(direction: Array) -> str:
    """x, y or z, or the components."""
    best = int(np.argmax(abs(direction)))
    if abs(direction[best]) > ALONG:
        return "xyz"[best]
    components = np.round(np.sign(direction[best]) * direction, 3) + 0.0
    return "(" + ", ".join(f"{c:.3f}" for c in components) + ")"


def restraint(layout: Layout, J: csr_array, row: int, q: Array) -> Restraint:
    """Read the restraint of an equation from its gradient, on the last of its bodies that has one.

    The gradient by r is along a displacement; without one, ½ E(p) times the gradient by p is the axis of a rotation.
    """
    gradient = np.zeros(len(q))
    place = slice(J.indptr[row], J.indptr[row + 1])
    gradient[J.indices[place]] = J.data[place]
    bodies = layout.bodies
    last = [n for n in np.unique(layout.owner_of[J.indices[place]])[::-1] if n < len(bodies.firsts)]
    for at, r in zip(bodies.firsts[last], bodies.positions[last], strict=True):
        if np.linalg.norm(shift := gradient[r]) > NOTHING:
            return _restraint("displacement", shift, at)
    for at, p in zip(bodies.firsts[last], bodies.rotations[last], strict=True):
        if np.linalg.norm(turn := 0.5 * E(q[p]) @ gradient[p]) > NOTHING:
            return _restraint("rotation", turn, at)
    return Restraint("nothing", np.zeros(3), 0.0)


def _restraint(kind: Literal["displacement", "rotation"], vector: Array, first: int) -> Restraint:
    size = float(np.linalg.norm(vector))
    return Restraint(kind, vector / size, size, int(first))
