"""Onto the constraints at a given time, by the least change in each step; whatever the rank of the Jacobian."""

from __future__ import annotations

from ..algebra import Array
from ..system import System
from .nullspace import NullSpace

TOLERANCE = 1e-13  # of the largest entry of |Φ|; round-off is a few times smaller
ACCEPTED = 1e-10  # where round-off, in a model of large numbers, ends the improvement earlier


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
    residual = system.Phi(q, t, b=b)
    for _ in range(steps):
        size = largest(residual)
        if size <= TOLERANCE:
            return q, True
        step = NullSpace(system.Phi_q(q, t, b=b)).change(-residual)
        there, after = _shortened(system, q, t, b, step, size)
        if largest(after) >= size:
            break
        q, residual = there, after
    return q, largest(residual) <= ACCEPTED


def largest(vector: Array) -> float:
    """Largest entry of |vector|."""
    return float(abs(vector).max(initial=0.0))


def _shortened(
    system: System, q: Array, t: float, b: Array | None, step: Array, before: float
) -> tuple[Array, Array]:
    there, after = q, system.Phi(q, t, b=b)
    for halvings in range(10):
        there = q + step * 0.5**halvings
        after = system.Phi(there, t, b=b)
        if largest(after) < before:
            break
    return there, after
