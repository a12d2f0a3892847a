"""Accelerations and multipliers at a state, and their derivatives: functions that are compiled."""

from __future__ import annotations

from ..._jit.kernels.pointer import call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work, factor, shortest, solve_motion
from ..equations.minimum_norm_loop import LeftOut
from ..equilibria.linear_loop import Constraints, Forces, Sparse, clear, evaluate, solve

ROUNDS = 2  # of the equations of motion: the first, and a refinement


@compiled(entry=True)
def forward(
    entries: Entries, work: Work, matrix: Matrix, others: LeftOut, least: float, b: Array, t: float, q: Array,
    v: Array, a: Array, lam: Array,
) -> float:  # fmt: skip
    """Fill a and λ, the shortest where constraints are redundant.

    Returns
    -------
    how far the pivots can be trusted; at most `least`, nothing else is done
    """
    trust = factor(entries, b, t, q, matrix)
    if trust > least:
        for k in range(len(a)):
            a[k] = 0.0
        for k in range(len(lam)):
            lam[k] = 0.0
        solve_motion(entries, b, t, q, v, a, lam, work, matrix, ROUNDS)
        shortest(entries, b, t, q, lam, work, matrix, others)
    return trust


@compiled
def scatter(A: Sparse, by: float, to: Array, row: int, column: int) -> None:
    """Add a multiple of a sparse matrix to a block of a dense one."""
    for k in range(len(A.first) - 1):
        for entry in range(A.first[k], A.first[k + 1]):
            to[row + k, column + A.columns[entry]] += by * A.numbers[entry]


@compiled(entry=True)
def derivatives(
    matrix: Matrix, phi: Constraints, forces: Forces, right: Array, work: Array, found: Array, Q_u: Array, b: Array,
    t: float, q: Array, v: Array, a: Array, lam: Array,
) -> None:  # fmt: skip
    """Fill `found` (nq + m, 2 nq + nu): the derivatives of a and λ by q, v and u, with the factors at hand.

    M δa + Φ_qᵀ δλ = (Q_q + S_q - (M a)_q - (Φ_qᵀλ)_q) δq + (Q_v + S_v) δv + Q_u δu,
    Φ_q δa = (γ_q - (Φ_q a)_q) δq + γ_v δv
    """
    nq = len(q)
    for k in range(len(lam)):
        phi.lam[k] = lam[k]
    evaluate(phi, b, t, q, v, a)
    call_kernels(forces.force, b, t, q, v, forces.Q_q.numbers, forces.Q_v.numbers)
    call_kernels(forces.inertia, b, q, a, forces.M_a_q.numbers)
    call_kernels(forces.by_q, b, q, v, forces.S_q.numbers)
    call_kernels(forces.by_v, b, q, v, forces.S_v.numbers)
    clear(right)
    scatter(forces.Q_q, 1.0, right, 0, 0)
    scatter(forces.S_q, 1.0, right, 0, 0)
    scatter(forces.M_a_q, -1.0, right, 0, 0)
    scatter(phi.Phi_qT_lam_q, -1.0, right, 0, 0)
    scatter(phi.gamma_q, 1.0, right, nq, 0)
    scatter(phi.along_a, -1.0, right, nq, 0)
    scatter(forces.Q_v, 1.0, right, 0, nq)
    scatter(forces.S_v, 1.0, right, 0, nq)
    scatter(phi.gamma_v, 1.0, right, nq, nq)
    for k in range(nq):
        for j in range(Q_u.shape[1]):
            right[k, 2 * nq + j] = Q_u[k, j]
    solve(matrix, right, work, found)
