"""Second derivatives of forward dynamics in independent coordinates, contracted: compiled functions.

With weights of the rates ẋ, of the multipliers, and of changes of q, v and a, the adjoint variables of the equations

    M a + Φ_qᵀλ = Q + S,  Φ_q a = γ,      Φ_q v + Φ_t = 0,  ċ = x_ċ,      Φ = 0,  c = x_c

follow one after another with the factors of [M Φ_qᵀ; Φ_q 0]; see `linear_loop` for the changes of the state.
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.kernels.vector import LANES
from ..._jit.linking.link import compiled
from ...algebra import Array
from ...linalg.lanes_loop import clear_lanes
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work
from ..equations.block_matrix import backsolve
from ..equilibria.linear_loop import FOUND, Constraints, Coordinates, Forces, Maps
from ..equilibria.linearization_loop import linearized
from ..equilibria.parameter_loop import ByParameters, Displacer
from .contraction_loop import (
    Columns,
    Equations,
    Pairs,
    State,
    add_curved,
    add_kinematics,
    add_motion,
    add_parameters,
    add_product,
    add_transposed,
    at_state,
    clear_changes,
    fill,
    fit,
    put,
    set_parameters,
)


class Adjoint(NamedTuple):
    """Weights of changes of q, v, a, which are constant; and work arrays.

    Attributes
    ----------
    weights_q, weights_v, weights_a : (nq,)
    q, v : gradients by q and v
    measured : adjoint variables of the coordinates that elements measure
    right, solution : (nq + m,)
    """

    weights_q: Array
    weights_v: Array
    weights_a: Array
    q: Array
    v: Array
    measured: Array
    right: Array
    solution: Array


@compiled
def weigh(of: Coordinates, c: Constraints, weights: Array, adjoint: Adjoint) -> None:
    """The gradients by q, v, and by a and λ, of the weighted rates and multipliers."""
    nq, n, d = len(adjoint.q), len(of.row), len(of.rates)
    nx, right = n + d + len(of.states), adjoint.right
    for k in range(nq):
        adjoint.q[k], adjoint.v[k] = adjoint.weights_q[k], adjoint.weights_v[k]
        right[k] = adjoint.weights_a[k]
    for k in range(len(right) - nq):
        right[nq + k] = weights[nx + k]
    measure(of, weights, n, 1.0, adjoint.measured, right)
    for k in range(len(of.states)):
        right[of.states[k]] += weights[n + d + k]
    add_transposed(c.Phi_q, 1.0, adjoint.measured, 0, right)
    add_transposed(c.along_a, 1.0, adjoint.measured, 0, adjoint.q)
    add_transposed(c.gamma_q, -1.0, adjoint.measured, 0, adjoint.q)
    add_transposed(c.gamma_v, -1.0, adjoint.measured, 0, adjoint.v)


@compiled
def measure(of: Coordinates, weights: Array, first: int, by: float, measured: Array, to: Array) -> None:
    """Weights of the coordinates: those that elements measure, and those of bodies, whose multiples are added to q."""
    for k in range(len(measured)):
        measured[k] = 0.0
    for k in range(len(of.row)):
        if of.row[k] >= 0:
            measured[of.row[k]] += weights[first + k]
        else:
            to[of.place[k]] += by * weights[first + k]


@compiled
def of_motion(phi: Constraints, forces: Forces, matrix: Matrix, adjoint: Adjoint) -> None:
    """The adjoint variables of the equations of motion, as the solution; and the gradients by q and v with them."""
    y, nq = adjoint.solution, len(adjoint.q)
    solve_rows(matrix, adjoint)
    add_transposed(forces.M_a_q, -1.0, y, 0, adjoint.q)
    add_transposed(phi.Phi_qT_lam_q, -1.0, y, 0, adjoint.q)
    add_transposed(forces.Q_q, 1.0, y, 0, adjoint.q)
    add_transposed(forces.S_q, 1.0, y, 0, adjoint.q)
    add_transposed(phi.gamma_q, 1.0, y, nq, adjoint.q)
    add_transposed(phi.along_a, -1.0, y, nq, adjoint.q)
    add_transposed(forces.Q_v, 1.0, y, 0, adjoint.v)
    add_transposed(forces.S_v, 1.0, y, 0, adjoint.v)
    add_transposed(phi.gamma_v, 1.0, y, nq, adjoint.v)


@compiled
def solve_rows(matrix: Matrix, adjoint: Adjoint) -> None:
    """Solve with the matrix of the equations of motion, without equations that are left out."""
    nq = len(adjoint.q)
    for k in range(len(matrix.left_out)):
        if matrix.left_out[k] != 0.0:
            adjoint.right[nq + k] = 0.0
    backsolve(matrix.placed, adjoint.right, adjoint.solution)


@compiled
def of_conditions(
    of: Coordinates, c: Constraints, matrix: Matrix, along: Array, first: int, maps: Maps, gradient: Array,
    adjoint: Adjoint,
) -> None:  # fmt: skip
    """The adjoint variables of coordinates, `measured`, and of constraints, in the solution, for a gradient.

    along : (nq, …) directions in which one coordinate changes alone, from a column on
    """
    nq, n, right, states = len(gradient), len(of.row), adjoint.right, len(of.row) + len(of.rates)
    for k in range(nq):
        right[k] = gradient[k]
    for k in range(len(right) - nq):
        right[nq + k] = 0.0
    for k in range(len(adjoint.measured)):
        adjoint.measured[k] = 0.0
    for j in range(n):
        y = 0.0
        for k in range(nq):
            y += along[k, first + j] * gradient[k]
        if of.row[j] >= 0:
            adjoint.measured[of.row[j]] += y
        else:
            right[of.place[j]] -= y
    for j in range(len(of.states)):
        for k in range(nq):
            right[of.states[j]] -= maps.v[k, states + j] * gradient[k]
    add_transposed(c.Phi_q, -1.0, adjoint.measured, 0, right)
    solve_rows(matrix, adjoint)


@compiled
def adjoint_variables(
    phi: Constraints, c: Constraints, forces: Forces, of: Coordinates, maps: Maps, matrix: Matrix, weights: Array,
    adjoint: Adjoint, x: State, equations: Equations, coordinates: Equations,
) -> None:  # fmt: skip
    """Those of all equations, in lanes, with the signs that they have in the Lagrangians."""
    nq = len(adjoint.q)
    weigh(of, c, weights, adjoint)
    fill(adjoint.measured, 1.0, 0, coordinates.nu_motion)
    of_motion(phi, forces, matrix, adjoint)
    fill(adjoint.solution, -1.0, 0, x.xi)
    fill(adjoint.solution, -1.0, nq, equations.nu_motion)
    of_conditions(of, c, matrix, maps.v, len(of.row), maps, adjoint.v, adjoint)
    fill(adjoint.solution, 1.0, nq, equations.nu_rate)
    fill(adjoint.measured, 1.0, 0, coordinates.nu_rate)
    add_transposed(phi.gamma_v, 0.5, adjoint.solution, nq, adjoint.q)
    add_transposed(c.along, -1.0, adjoint.measured, 0, adjoint.q)
    of_conditions(of, c, matrix, maps.q, 0, maps, adjoint.q, adjoint)
    fill(adjoint.solution, -1.0, nq, equations.nu_place)
    fill(adjoint.measured, -1.0, 0, coordinates.nu_place)


@compiled
def move(x: State, of: Equations, maps: Maps, column: int, lane: int) -> None:
    """The change of the state with one entry of x or combination of parameters."""
    put(maps.q, 0, column, lane, x.q_dot)
    put(maps.v, 0, column, lane, x.v_dot)
    put(maps.motion, 0, column, lane, x.a_dot)
    put(maps.motion, len(maps.q), column, lane, of.lam_dot)


@compiled
def contract(
    x: State, equations: Equations, coordinates: Equations, by: Columns, by_c: Columns, maps: Maps, first: int,
    count: int, nx: int, b: Array, H: Array,
) -> None:  # fmt: skip
    """Some rows, at most as many as there are lanes."""
    for lane in range(LANES):
        move(x, equations, maps, first + min(lane, count - 1), lane)
    clear_changes(x, equations)
    clear_lanes(coordinates.by_b)
    add_motion(x, equations, b, x.xi)
    add_kinematics(x, equations, b)
    add_motion(x, coordinates, coordinates.b, x.still)
    add_kinematics(x, coordinates, coordinates.b)
    for lane in range(count):
        row = first + lane
        for k in range(H.shape[1]):
            H[row, k] = 0.0
        add_product(x.by_q, lane, maps.q, 0, 0, row, H)
        add_product(x.by_v, lane, maps.v, 0, 0, row, H)
        add_product(x.by_a, lane, maps.motion, 0, 0, row, H)
        add_product(equations.by_lam, lane, maps.motion, len(maps.q), 0, row, H)
        add_parameters(by, equations, lane, row, nx, H)
        add_parameters(by_c, coordinates, lane, row, nx, H)


@compiled
def hessian(
    entries: Entries, work: Work, matrix: Matrix, phi: Constraints, c: Constraints, forces: Forces, of: Coordinates,
    combinations: ByParameters, displacing: Displacer, maps: Maps, A: Array, a: Array, lam: Array, by: Columns,
    by_c: Columns, curved: Pairs, equations: Equations, coordinates: Equations, x: State, adjoint: Adjoint,
    least: float, b: Array, t: float, q: Array, v: Array, weights: Array, H: Array,
) -> tuple[float, int]:  # fmt: skip
    """Fill H (nx + k, nx + k), second derivatives of a weighted sum by x and combinations of parameters.

    weights : (nx + m,) of the rates of x and of the multipliers

    Returns
    -------
    how far the pivots can be trusted: at most `least`, nothing else is done, -1 if arguments have other sizes or, where
    constraints are redundant, for weights of multipliers; and FOUND or the dependent coordinate
    """
    nx = len(A)
    if not fit(equations, b, weights, nx + len(lam), H, nx + len(by.first) - 1):
        return -1.0, FOUND
    for k in range(len(lam)):
        if weights[nx + k] != 0.0 and matrix.left_out.any():
            return -1.0, FOUND
    trust, dependent = linearized(
        entries, work, matrix, phi, c, forces, of, combinations, displacing, maps, A, a, lam, True, least, b, t, q,
        v,
    )  # fmt: skip
    if trust > least and dependent == FOUND:
        at_state(x, equations, t, q, v, a, lam)
        adjoint_variables(phi, c, forces, of, maps, matrix, weights, adjoint, x, equations, coordinates)
        for first in range(0, nx, LANES):
            contract(x, equations, coordinates, by, by_c, maps, first, min(LANES, nx - first), nx, b, H)
        for k in range(len(by.first) - 1):
            set_parameters(by, k, 1.0, equations)
            set_parameters(by_c, k, 1.0, coordinates)
            contract(x, equations, coordinates, by, by_c, maps, nx + k, 1, nx, b, H)
            set_parameters(by, k, 0.0, equations)
            set_parameters(by_c, k, 0.0, coordinates)
        add_curved(curved, weights, 0, A, 0, H)
        add_curved(curved, weights, nx, maps.motion, len(q), H)
        add_curved(curved, adjoint.weights_q, 0, maps.q, 0, H)
        add_curved(curved, adjoint.weights_v, 0, maps.v, 0, H)
        add_curved(curved, adjoint.weights_a, 0, maps.motion, 0, H)
    return trust, dependent
