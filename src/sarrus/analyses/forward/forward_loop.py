"""Accelerations and multipliers at a state, and their derivatives: functions that are compiled."""

from __future__ import annotations

from ..._jit.kernels.pointer import call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work, shortest
from ..equations.minimum_norm_loop import LeftOut
from ..equilibria.linear_loop import Constraints, Forces, Sparse, clear, evaluate, solve
from ..equilibria.parameter_loop import ByParameters, add_motion_by_parameters
from ..equilibria.regular_loop import factor_regular, solve_regular

ROUNDS = 2  # of the equations of motion: the first, and a refinement


@compiled
def forward(
    entries: Entries, work: Work, matrix: Matrix, others: LeftOut, least: float, b: Array, t: float, q: Array,
    v: Array, a: Array, lam: Array,
) -> float:  # fmt: skip
    """Fill a and λ, the shortest where constraints are redundant.

    Returns
    -------
    how far the pivots can be trusted; at most `least`, nothing else is done; -1 if a or λ are not finite, or
    vectors have other sizes
    """
    nq = len(work.Q)
    if not (len(q) == len(v) == len(a) == nq and len(lam) == len(matrix.left_out)):
        return -1.0
    trust = factor_regular(entries, b, t, q, matrix)
    if trust > least:
        if not solve_regular(entries, b, t, q, v, a, lam, work, matrix, ROUNDS):
            return -1.0
        shortest(entries, b, t, q, lam, work, matrix, others)
    return trust


@compiled
def scatter(A: Sparse, by: float, to: Array, row: int, column: int) -> None:
    """Add a multiple of a sparse matrix to a block of a dense one."""
    for k in range(len(A.first) - 1):
        for entry in range(A.first[k], A.first[k + 1]):
            to[row + k, column + A.columns[entry]] += by * A.numbers[entry]


@compiled
def derivatives(
    entries: Entries, work: Work, matrix: Matrix, others: LeftOut, phi: Constraints, forces: Forces,
    combinations: ByParameters, a: Array, lam: Array, right: Array, columns: Array, least: float, b: Array, t: float,
    q: Array, v: Array, found: Array,
) -> float:  # fmt: skip
    """Fill `found` (nq + m, 1 + 2 nq + k): a and λ as `forward`, their derivatives by q, v, and k combinations of b.

    M δa + Φ_qᵀ δλ = (Q_q + S_q - (M a)_q - (Φ_qᵀλ)_q) δq + (Q_v + S_v) δv + (Q + S - M a - Φ_qᵀλ)_b δb,
    Φ_q δa = (γ_q - (Φ_q a)_q) δq + γ_v δv + (γ - Φ_q a)_b δb
    """
    if found.shape != right.shape:
        return -1.0
    trust = forward(entries, work, matrix, others, least, b, t, q, v, a, lam)
    if trust > least:
        nq, by_q, by_v = len(q), 1, 1 + len(q)
        for k in range(len(lam)):
            phi.lam[k] = lam[k]
        evaluate(phi, b, t, q, v, a)
        call_kernels(forces.force, b, t, q, v, forces.Q_q.numbers, forces.Q_v.numbers)
        call_kernels(forces.inertia, b, q, a, forces.M_a_q.numbers)
        call_kernels(forces.by_q, b, q, v, forces.S_q.numbers)
        call_kernels(forces.by_v, b, q, v, forces.S_v.numbers)
        clear(right)
        scatter(forces.Q_q, 1.0, right, 0, by_q)
        scatter(forces.S_q, 1.0, right, 0, by_q)
        scatter(forces.M_a_q, -1.0, right, 0, by_q)
        scatter(phi.Phi_qT_lam_q, -1.0, right, 0, by_q)
        scatter(phi.gamma_q, 1.0, right, nq, by_q)
        scatter(phi.along_a, -1.0, right, nq, by_q)
        scatter(forces.Q_v, 1.0, right, 0, by_v)
        scatter(forces.S_v, 1.0, right, 0, by_v)
        scatter(phi.gamma_v, 1.0, right, nq, by_v)
        add_motion_by_parameters(combinations, b, t, q, v, a, lam, right, by_v + nq)
        solve(matrix, right, columns, found)
        for k in range(nq):
            found[k, 0] = a[k]
        for k in range(len(lam)):
            found[nq + k, 0] = lam[k]
    return trust
