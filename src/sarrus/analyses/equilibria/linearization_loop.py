"""The linearization of the equations of motion in independent coordinates: one function that is compiled."""

from __future__ import annotations

from ..._jit.kernels.pointer import call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work
from .linear_loop import (
    FOUND,
    Constraints,
    Coordinates,
    Forces,
    Maps,
    accelerations,
    bend,
    clear,
    directions,
    evaluate,
    positions,
    rates,
    solve,
    velocities,
)
from .parameter_loop import ByParameters, Displacing, add_motion_by_parameters, bend_by_parameters, displace
from .regular_loop import factor_regular, solve_regular

ROUNDS = 4  # of the equations of motion: the first, and refinements


@compiled
def linearized(
    entries: Entries, work: Work, matrix: Matrix, phi: Constraints, c: Constraints, forces: Forces, of: Coordinates,
    combinations: ByParameters, displacing: Displacing, maps: Maps, A: Array, a: Array, lam: Array, whole: bool,
    least: float, b: Array, t: float, q: Array, v: Array,
) -> tuple[float, int]:  # fmt: skip
    """Fill a, λ and A (nx, nx + k), the rates of x by x and k combinations of b, with all maps.

    That of a and λ if it is wanted (`whole`).

    Returns
    -------
    how far the pivots can be trusted: at most `least`, nothing else is done, -1 if a or λ are not finite or if vectors
    have other sizes; and FOUND or the dependent coordinate
    """
    if not len(q) == len(v) == len(a):
        return -1.0, FOUND
    trust = factor_regular(entries, b, t, q, matrix)
    if not trust > least:
        return trust, FOUND
    if not solve_regular(entries, b, t, q, v, a, lam, work, matrix, ROUNDS):
        return -1.0, FOUND
    for k in range(len(lam)):
        phi.lam[k] = lam[k]
    evaluate(phi, b, t, q, v, a)
    evaluate(c, c.b, t, q, v, a)
    call_kernels(forces.force, b, t, q, v, forces.Q_q.numbers, forces.Q_v.numbers)
    call_kernels(forces.inertia, b, q, a, forces.M_a_q.numbers)
    call_kernels(forces.by_q, b, q, v, forces.S_q.numbers)
    call_kernels(forces.by_v, b, q, v, forces.S_v.numbers)
    dependent = directions(of, c, matrix, maps)
    if dependent == FOUND:
        n, nx, end = len(of.row), len(A), A.shape[1]
        positions(of, maps)
        moving = velocities(of, phi, c, matrix, maps)
        displaced = displace(of, displacing, phi, c, matrix, b, t, q, v, maps, nx)
        by_q, by_v = (0, n), (0 if moving else n, nx)
        clear(maps.right)
        accelerations(phi, forces, maps, by_q, by_v)
        add_motion_by_parameters(combinations, b, t, q, v, a, lam, maps.right, nx)
        if displaced:
            accelerations(phi, forces, maps, (nx, end), (nx, end))
        rates(of, matrix, maps, A)
        bend(of, c, maps, A, by_q, by_v if moving else (n, n))
        if displaced:
            bend(of, c, maps, A, (nx, end), (nx, end))
            bend_by_parameters(of, displacing, c, t, q, v, a, A, nx)
        if whole:
            solve(matrix, maps.right, maps.work, maps.motion)
    return trust, dependent
