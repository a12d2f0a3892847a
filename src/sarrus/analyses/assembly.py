"""Assembly: the nearest coordinates and velocities that satisfy the constraints."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..algebra import Array
from ..results import Assembly
from ..system import System
from .saddle import Saddle, SingularSystem


def assemble(
    system: System,
    q: ArrayLike | None = None,
    v: ArrayLike | None = None,
    *,
    t: float = 0.0,
    tolerance: float = 1e-12,
    iterations: int = 100,
) -> Assembly:
    """Find consistent coordinates and velocities near given ones.

    Newton's method with the least change of q in each step, halved while the residual grows; then the least change of v
    with Φ_q v = -Φ_t.

    Parameters
    ----------
    system : System
    q, v : (nq,) where to start; by default the model's
    t : time at which drivers are taken [s]
    tolerance : of the largest entry of |Φ|
    iterations : at most so many Newton steps

    Returns
    -------
    Assembly
        With ``success`` false and the open joints in ``message``, if the constraints could not be satisfied.
    """
    q = np.array(system.q0 if q is None else q, dtype=float)
    v = np.array(system.v0 if v is None else v, dtype=float)
    saddle, weight = Saddle(system, "I"), np.ones(system.nq)
    residual, count = _size(system.Phi(q, t)), 0
    try:
        while residual > tolerance and count < iterations:
            saddle.factor(weight, system.Phi_q(q, t).data)
            step, _ = saddle.solve(np.zeros(system.nq), -system.Phi(q, t))
            q, improved = _damped(system, q, step, residual, t)
            count += 1
            if improved >= residual and improved > tolerance:
                break
            residual = improved
        v = project_velocity(system, saddle, q, v, t)
    except SingularSystem:
        return _failed(system, q, v, t, count, "the constraints are dependent there")
    if residual > tolerance:
        return _failed(system, q, v, t, count, f"after {count} steps")
    return Assembly(q, v, True, f"assembled in {count} steps", residual, count)


def project_velocity(system: System, saddle: Saddle, q: Array, v: Array, t: float = 0.0) -> Array:
    """The velocity nearest to v that satisfies Φ_q v = -Φ_t."""
    saddle.factor(np.ones(system.nq), system.Phi_q(q, t).data)
    change, _ = saddle.solve(np.zeros(system.nq), -system.Phi_q_xi(q, v, t) - system.Phi_t(q, t))
    return v + change


def _size(residual: Array) -> float:
    return float(abs(residual).max(initial=0.0))


def _damped(system: System, q: Array, step: Array, before: float, t: float) -> tuple[Array, float]:
    """The longest of the steps 1, 1/2, 1/4, ... that makes the residual smaller."""
    for halvings in range(12):
        there = q + step * 0.5**halvings
        after = _size(system.Phi(there, t))
        if after < before:
            return there, after
    return q + step, _size(system.Phi(q + step, t))


def _failed(system: System, q: Array, v: Array, t: float, count: int, why: str) -> Assembly:
    residual = system.Phi(q, t)
    worst = np.argsort(-abs(residual))[:3]
    open_rows = ", ".join(f"{system.row_names[n]} by {residual[n]:.3g}" for n in worst if residual[n])
    message = (
        f"{system.name} could not be assembled {why}; still open: {open_rows}; "
        "start from poses nearer to the assembled ones, or look for joints that contradict each other"
    )
    return Assembly(q, v, False, message, _size(residual), count)
