"""Onto the constraints at a given time, by the least change in each step; whatever the rank of the Jacobian."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....system import System
from ..length import lever
from ..nullspace import NullSpace
from .closure import allowed

TOLERANCE = 1e-13  # of |Φ|, relative to the gradient of each equation; round-off is a few times smaller
ACCEPTED = 1e-10  # the same, where the improvement ends earlier


def onto(
    system: System, q: Array, t: float, *, b: Array | None = None, steps: int = 20
) -> tuple[Array, bool]:
    """Coordinates near q with Φ(q, t) = 0, and whether they were reached.

    Parameters
    ----------
    system : System
    q : (nq,)
    t : time [s]
    b : (nb,) other numbers than the model's
    steps : at most so many Gauss-Newton steps, each halved while it makes |Φ| larger
    """
    J, residual = system.Phi_q(q, t, b=b), system.Phi(q, t, b=b)
    length = lever(system, q, J)
    for _ in range(steps):
        if np.all(abs(residual) <= allowed(J, q, length, TOLERANCE)):
            return q, True
        space = NullSpace(J, length)
        there, after = _shortened(system, q, t, b, space.change(-residual), space.lengths)
        if largest(after / space.lengths) >= largest(residual / space.lengths):
            break
        q, residual, J = there, after, system.Phi_q(there, t, b=b)
    return q, bool(np.all(abs(residual) <= allowed(J, q, length, ACCEPTED)))


def largest(vector: Array) -> float:
    """Largest entry of |vector|."""
    return float(abs(vector).max(initial=0.0))


def _shortened(
    system: System, q: Array, t: float, b: Array | None, step: Array, rows: Array
) -> tuple[Array, Array]:
    there, after = q, system.Phi(q, t, b=b)
    before = largest(after / rows)
    for halvings in range(10):
        there = q + step * 0.5**halvings
        after = system.Phi(there, t, b=b)
        if largest(after / rows) < before:
            break
    return there, after
