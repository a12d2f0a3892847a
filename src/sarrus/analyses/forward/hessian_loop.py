"""Second derivatives of forward dynamics by all coordinates, velocities, inputs and parameters: compiled functions."""

from __future__ import annotations

from ..._jit.kernels.vector import LANES
from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work
from ..equations.block_matrix import backsolve
from ..equations.minimum_norm import Omissions
from ..equilibria.linear_loop import Constraints, Forces
from ..equilibria.parameter_loop import ByParameters
from .contraction_loop import (
    Columns,
    Equations,
    Pairs,
    State,
    add_curved,
    add_motion,
    add_parameters,
    add_product,
    at_state,
    clear_changes,
    fill,
    fit,
    put,
    set_parameters,
    still_lane,
)
from .forward_loop import derivatives


@compiled
def move_alone(x: State, of: Equations, slopes: Array, column: int, lane: int) -> None:
    """The change of one coordinate, velocity or combination of parameters alone, with those of a and λ."""
    nq = len(x.q) // LANES
    still_lane(lane, x.q_dot)
    still_lane(lane, x.v_dot)
    if column < nq:
        x.q_dot[column * LANES + lane] = 1.0
    elif column < 2 * nq:
        x.v_dot[(column - nq) * LANES + lane] = 1.0
    put(slopes, 0, 1 + column, lane, x.a_dot)
    put(slopes, nq, 1 + column, lane, of.lam_dot)


@compiled
def take_row(x: State, of: Equations, by: Columns, slopes: Array, lane: int, row: int, H: Array) -> None:
    """One row of the second derivatives."""
    nq = len(x.q) // LANES
    for k in range(nq):
        H[row, k] = x.by_q[k * LANES + lane]
        H[row, nq + k] = x.by_v[k * LANES + lane]
    for k in range(2 * nq, H.shape[1]):
        H[row, k] = 0.0
    add_parameters(by, of, lane, row, 2 * nq, H)
    add_product(x.by_a, lane, slopes, 0, 1, row, H)
    add_product(of.by_lam, lane, slopes, nq, 1, row, H)


@compiled
def contract(
    x: State, of: Equations, by: Columns, slopes: Array, first: int, count: int, b: Array, H: Array
) -> None:
    """Some rows, at most as many as there are lanes."""
    for lane in range(LANES):
        move_alone(x, of, slopes, first + min(lane, count - 1), lane)
    clear_changes(x, of)
    add_motion(x, of, b, x.xi)
    for lane in range(count):
        take_row(x, of, by, slopes, lane, first + lane, H)


@compiled
def hessian(
    entries: Entries, work: Work, matrix: Matrix, others: Omissions, phi: Constraints, forces: Forces,
    combinations: ByParameters, a: Array, lam: Array, right: Array, columns: Array, by: Columns, curved: Pairs,
    of: Equations, x: State, slopes: Array, weighted: Array, adjoint: Array, least: float, b: Array, t: float,
    q: Array, v: Array, weights: Array, H: Array,
) -> float:  # fmt: skip
    """Fill H (2 nq + k, 2 nq + k), second derivatives of the sum of a and λ with weights (nq + m,).

    With the adjoint variables [ξ; ν] of the weights, the Lagrangian is -ξᵀ(M a + Φ_qᵀλ - Q - S) - νᵀ(Φ_q a - γ).
    Where b has second derivatives by parameters, the first derivatives of a and λ along these are added.

    Returns
    -------
    how far the pivots can be trusted; at most `least`, nothing else is done; -1 if arguments have other sizes
    """
    nq = len(a)
    if not fit(of, b, weights, nq + len(lam), H, 2 * nq + len(by.first) - 1):
        return -1.0
    trust = derivatives(
        entries, work, matrix, others, phi, forces, combinations, a, lam, right, columns, least, b, t, q, v, slopes,
    )  # fmt: skip
    if trust > least:
        for k in range(len(weighted)):
            weighted[k] = weights[k]
        backsolve(matrix.placed, weighted, adjoint)
        at_state(x, of, t, q, v, a, lam)
        fill(adjoint, -1.0, 0, x.xi)
        fill(adjoint, -1.0, nq, of.nu_motion)
        for first in range(0, 2 * nq, LANES):
            contract(x, of, by, slopes, first, min(LANES, 2 * nq - first), b, H)
        for k in range(len(by.first) - 1):
            set_parameters(by, k, 1.0, of)
            contract(x, of, by, slopes, 2 * nq + k, 1, b, H)
            set_parameters(by, k, 0.0, of)
        add_curved(curved, weights, 0, slopes, 0, H)
    return trust
