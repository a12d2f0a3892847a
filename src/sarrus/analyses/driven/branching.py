"""Location of configurations where a driven motion can branch: the determinant of the Jacobian changes sign."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BPoly
from scipy.sparse import block_array, csr_array

from ...algebra import Array
from ...linalg.factors import Factored, SingularSystem
from ..equations.projection.constraint_projection import largest
from .steps import Instant, Path

HALVINGS = 40
STEPS = 10
SETTLED = 1e-10
PERTURBATION = 1e-9  # of Φ: what a true branching does not need


def branching_time(path: Path, before: Instant, after: Instant) -> float | None:
    """The time between two states at which the motion could branch; nothing, if only the step was wrong.

    Bisection along the quintic through both states gives the start for Newton's method; see `_residual`.
    """
    between = BPoly.from_derivatives(
        [before.t, after.t], [[before.q, before.v, before.a], [after.q, after.v, after.a]]
    )
    low, high = before.t, after.t
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _sign(path, middle, between(middle)) == before.sign else (low, middle)
    return _polished(path, low, between(low), after.t - before.t)


def _sign(path: Path, t: float, q: Array) -> float:
    try:
        return path.sign(t, q)
    except SingularSystem:
        return 0.0


def _polished(path: Path, t: float, q: Array, interval: float) -> float | None:
    """Newton's method on the four equations of `_residual`, from the multipliers of the smallest singular value."""
    try:
        u = path.weakest(t, q)[1]
        u, n, near = u / np.linalg.norm(u), len(q), t
        x = np.concatenate([q, u[path.rows], [t, 0.0]])
        for _ in range(STEPS):
            step = Factored(_matrix(path, x[:n], x[n:-2], x[-2], x[-1])).solve(
                -_residual(path, x[:n], x[n:-2], x[-2], x[-1])
            )
            x = x + step
            if largest(step) <= SETTLED:
                close = abs(x[-2] - near) <= interval and abs(x[-1]) <= PERTURBATION
                return float(x[-2]) if close else None
    except SingularSystem:
        pass
    return None


def _all(path: Path, u: Array) -> Array:
    lam = np.zeros(path.system.m)
    lam[path.rows] = u
    return lam


def _residual(path: Path, q: Array, u: Array, t: float, e: float) -> Array:
    """Φ + e u = 0, Φ_qᵀ u = 0, uᵀ Φ_t = 0, uᵀu = 1, with e = 0 in the solution: regular where two branches cross."""
    system, b, rows = path.system, path.b, path.rows
    Phi, Phi_t = system.Phi(q, t, b=b)[rows], system.Phi_t(q, t, b=b)[rows]
    force = system.Phi_qT_lam(q, _all(path, u), t, b=b)
    return np.concatenate([Phi + e * u, force, [u @ Phi_t, 0.5 * (u @ u - 1)]])


def _matrix(path: Path, q: Array, u: Array, t: float, e: float) -> csr_array:
    """The exact derivative of `_residual`; Φ_tq is -½ γ_v at rest."""
    system, b, rows = path.system, path.b, path.rows
    J, H = system.Phi_q(q, t, b=b)[rows], system.Phi_qT_lam_q(q, _all(path, u), t, b=b)
    J_t = -0.5 * system.gamma_v(q, np.zeros_like(q), t, b=b)[rows]
    Phi_t, Phi_tt = system.Phi_t(q, t, b=b)[rows], system.Phi_tt(q, t, b=b)[rows]
    turn = csr_array((J_t.T @ u)[:, None])
    by_t, by_e = csr_array(Phi_t[:, None]), csr_array(u[:, None])
    last = csr_array([[u @ Phi_tt]])
    return block_array(
        [
            [J, e * csr_array(np.eye(len(u))), by_t, by_e],
            [H, J.T, turn, None],
            [turn.T, by_t.T, last, None],
            [None, by_e.T, None, csr_array((1, 1))],
        ]
    ).tocsc()
