"""Factors of the equations of motion where these have one solution, and the solution: compiled functions."""

from __future__ import annotations

from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work, factor, solve_motion
from ..equations.block_matrix import Placed

NOTHING = 1e-15  # of the largest number above a pivot, below which it is what round-off leaves of zero


@compiled
def is_regular(placed: Placed) -> bool:
    """Whether no pivot of a matrix that is factored is zero but for round-off."""
    for j in range(len(placed.diagonal)):
        largest, pivot = 0.0, placed.diagonal[j]
        for entry in range(placed.pointers[j], pivot + 1):
            largest = max(largest, placed.scale[placed.rows[entry]] * abs(placed.factors[entry]))
        if not placed.scale[j] * abs(placed.factors[pivot]) > NOTHING * largest:
            return False
    return True


@compiled
def factor_regular(entries: Entries, b: Array, t: float, q: Array, matrix: Matrix) -> float:
    """Evaluate and factor [M Φ_qᵀ; Φ_q 0]; returns how far the pivots can be trusted, 0 if it is singular."""
    trust = factor(entries, b, t, q, matrix)
    return trust if trust > 0.0 and is_regular(matrix.placed) else 0.0


@compiled
def all_finite(x: Array) -> bool:
    """Whether no number is infinite or nan."""
    total = 0.0
    for k in range(len(x)):
        total += 0.0 * x[k]
    return total == 0.0


@compiled
def solve_regular(
    entries: Entries, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, work: Work, matrix: Matrix,
    rounds: int,
) -> bool:  # fmt: skip
    """Fill a and λ, which start from zeros: results do not depend on earlier calls. Returns whether all are finite."""
    for k in range(len(a)):
        a[k] = 0.0
    for k in range(len(lam)):
        lam[k] = 0.0
    solve_motion(entries, b, t, q, v, a, lam, work, matrix, rounds)
    return all_finite(a) and all_finite(lam)
