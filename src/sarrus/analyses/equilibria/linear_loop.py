"""Linearized equations of motion in independent coordinates: functions that are compiled.

Small changes of a motion, x = [δc; δċ; δs] with independent coordinates c and first-order states s, are followed by

    Φ_q δq = 0,                          c_q δq = δc,
    Φ_q δv = -(Φ_q v + Φ_t)_q δq,        c_q δv = δċ - (c_q v)_q δq,
    M δa + Φ_qᵀ δλ = Q_u δu - K δq - D δv,    Φ_q δa = (γ_q - (Φ_q a)_q) δq + γ_v δv

with K = (M a)_q + (Φ_qᵀλ)_q - Q_q - S_q and D = -(Q_v + S_v). All are solved with the factors of [M Φ_qᵀ; Φ_q 0].
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.kernels.pointer import KernelTable, call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work, factor, solve_motion
from ..equations.block_matrix import backsolve

DEPENDENT = (
    1e-10  # part of a coordinate that those before leave, squared and in the metric of M, that counts as none
)
ROUNDS = 4  # of the equations of motion: the first, and refinements
FOUND = -1


class Sparse(NamedTuple):
    """A sparse matrix by rows: where each row begins, columns, numbers."""

    first: Array
    columns: Array
    numbers: Array


class Constraints(NamedTuple):
    """Kernels of equations Φ, or of coordinates c, and the numbers of their derivatives.

    along, along_a : (Φ_q v)_q and (Φ_q a)_q
    """

    kinematic: KernelTable
    second: KernelTable
    b: Array
    lam: Array
    Phi_q: Sparse
    Phi_qT_lam_q: Sparse
    along: Sparse
    gamma_q: Sparse
    gamma_v: Sparse
    along_a: Sparse


class Forces(NamedTuple):
    """Kernels of forces and inertia, and the numbers of their derivatives."""

    force: KernelTable
    inertia: KernelTable
    by_q: KernelTable
    by_v: KernelTable
    Q_q: Sparse
    Q_v: Sparse
    M_a_q: Sparse
    S_q: Sparse
    S_v: Sparse


class Coordinates(NamedTuple):
    """Independent coordinates and first-order states.

    row, place : (n,) row among the measured coordinates, or -1 and the place in q of a coordinate of a body
    rates : which of the coordinates have independent rates (d,)
    states : places in v (ns,)
    """

    row: Array
    place: Array
    rates: Array
    states: Array


class Maps(NamedTuple):
    """Changes of q, v, a and λ by each entry of x and then of u, one row each (N + nu, …).

    free : (n + ns, nq) directions in which one coordinate or state changes alone
    gram : (n + ns, n + ns + 1) work array
    Q_u : (nu, nq) forces by inputs
    """

    q: Array
    v: Array
    a: Array
    lam: Array
    free: Array
    gram: Array
    Q_u: Array


@compiled
def add(A: Sparse, factor_: float, x: Array, to: Array) -> None:
    """Add a multiple of A x."""
    for row in range(len(A.first) - 1):
        total = 0.0
        for entry in range(A.first[row], A.first[row + 1]):
            total += A.numbers[entry] * x[A.columns[entry]]
        to[row] += factor_ * total


@compiled
def row_times(A: Sparse, row: int, x: Array) -> float:
    """One row of A x; nothing for a row of -1."""
    total = 0.0
    if row >= 0:
        for entry in range(A.first[row], A.first[row + 1]):
            total += A.numbers[entry] * x[A.columns[entry]]
    return total


@compiled
def rate_of(of: Coordinates, k: int, c: Constraints, x: Array) -> float:
    """c_q x of one coordinate."""
    return float(row_times(c.Phi_q, of.row[k], x) if of.row[k] >= 0 else x[of.place[k]])


@compiled
def evaluate(c: Constraints, t: float, q: Array, v: Array, a: Array) -> None:
    """All derivatives of equations or coordinates."""
    call_kernels(c.kinematic, c.b, t, q, v, c.lam, c.Phi_q.numbers, c.Phi_qT_lam_q.numbers, c.along.numbers,
                 c.gamma_q.numbers, c.gamma_v.numbers)  # fmt: skip
    call_kernels(c.second, c.b, t, q, a, c.along_a.numbers)


@compiled
def solve(matrix: Matrix, work: Work, x: Array, y: Array) -> None:
    """x and y of [M Φ_qᵀ; Φ_q 0] [x; y] = `work.right`, without equations left out."""
    n = len(x)
    for row in range(len(y)):
        work.right[n + row] *= 1.0 - matrix.left_out[row]
    backsolve(matrix.placed, work.right, work.solution)
    for k in range(n):
        x[k] = work.solution[k]
    for row in range(len(y)):
        y[row] = work.solution[n + row]


@compiled
def directions(of: Coordinates, c: Constraints, matrix: Matrix, work: Work, maps: Maps) -> int:
    """Directions in which constraints hold, and one coordinate or state changes alone; FOUND, or the one that cannot.

    The projections of the gradients in the metric of M span them; Gauss and Jordan's elimination separates them.
    """
    n, count, free, gram = len(of.row), len(maps.free), maps.free, maps.gram
    for k in range(count):
        for entry in range(len(work.right)):
            work.right[entry] = 0.0
        if k >= n or of.row[k] < 0:
            work.right[of.states[k - n] if k >= n else of.place[k]] = 1.0
        else:
            for entry in range(c.Phi_q.first[of.row[k]], c.Phi_q.first[of.row[k] + 1]):
                work.right[c.Phi_q.columns[entry]] = c.Phi_q.numbers[entry]
        solve(matrix, work, free[k], work.weak)
        for other in range(count):
            gram[other, k] = rate_of(of, other, c, free[k]) if other < n else free[k, of.states[other - n]]
    for k in range(count):
        gram[k, count] = gram[k, k]
    for k in range(count):
        pivot = gram[k, k]
        if not pivot > DEPENDENT * gram[k, count]:
            return k
        for other in range(count):
            gram[k, other] /= pivot
        for entry in range(free.shape[1]):
            free[k, entry] /= pivot
        for row in range(count):
            by = gram[row, k]
            if row != k and by != 0.0:
                for other in range(count):
                    gram[row, other] -= by * gram[k, other]
                for entry in range(free.shape[1]):
                    free[row, entry] -= by * free[k, entry]
    return FOUND


@compiled
def positions(of: Coordinates, maps: Maps) -> None:
    """δq and the free part of δv."""
    n, nx = len(of.row), len(of.row) + len(of.rates) + len(of.states)
    for j in range(nx):
        own = j if j < n else (of.rates[j - n] if j < n + len(of.rates) else j - len(of.rates))
        for k in range(maps.q.shape[1]):
            maps.q[j, k] = maps.free[own, k] if j < n else 0.0
            maps.v[j, k] = 0.0 if j < n else maps.free[own, k]


@compiled
def velocities(
    of: Coordinates, phi: Constraints, c: Constraints, matrix: Matrix, work: Work, maps: Maps
) -> None:
    """δv by δq: on the constraints, with the rates of the coordinates unchanged."""
    nq, n = maps.q.shape[1], len(of.row)
    for j in range(n):
        x, largest = maps.v[j], 0.0
        for k in range(len(work.right)):
            work.right[k] = 0.0
        add(phi.gamma_v, 0.5, maps.q[j], work.right[nq:])
        for k in range(nq, len(work.right)):
            largest = max(largest, abs(work.right[k]))
        if largest > 0.0:
            solve(matrix, work, x, work.weak)
        for k in range(n):
            change = rate_of(of, k, c, x) + row_times(c.along, of.row[k], maps.q[j])
            if change != 0.0:
                for entry in range(nq):
                    x[entry] -= change * maps.free[k, entry]
        for k in range(len(of.states)):
            change = x[of.states[k]]
            if change != 0.0:
                for entry in range(nq):
                    x[entry] -= change * maps.free[n + k, entry]


@compiled
def accelerations(phi: Constraints, forces: Forces, matrix: Matrix, work: Work, maps: Maps) -> None:
    """δa and δλ by x and u."""
    nq, nx = maps.q.shape[1], len(maps.q)
    for j in range(len(maps.a)):
        for k in range(len(work.right)):
            work.right[k] = maps.Q_u[j - nx, k] if j >= nx and k < nq else 0.0
        if j < nx:
            force, row = work.right[:nq], work.right[nq:]
            add(forces.M_a_q, -1.0, maps.q[j], force)
            add(phi.Phi_qT_lam_q, -1.0, maps.q[j], force)
            add(forces.Q_q, 1.0, maps.q[j], force)
            add(forces.S_q, 1.0, maps.q[j], force)
            add(forces.Q_v, 1.0, maps.v[j], force)
            add(forces.S_v, 1.0, maps.v[j], force)
            add(phi.gamma_q, 1.0, maps.q[j], row)
            add(phi.along_a, -1.0, maps.q[j], row)
            add(phi.gamma_v, 1.0, maps.v[j], row)
        solve(matrix, work, maps.a[j], maps.lam[j])


@compiled
def rates(of: Coordinates, c: Constraints, maps: Maps, A: Array) -> None:
    """ẋ by x and u."""
    n, d, nx = len(of.row), len(of.rates), len(maps.q)
    for j in range(len(maps.a)):
        for k in range(n):
            A[k, j] = 0.0
            if j < nx:
                A[k, j] = rate_of(of, k, c, maps.v[j]) + row_times(c.along, of.row[k], maps.q[j])
        for i in range(d):
            k = of.rates[i]
            A[n + i, j] = rate_of(of, k, c, maps.a[j])
            if j < nx:
                A[n + i, j] += row_times(c.along_a, of.row[k], maps.q[j])
                A[n + i, j] -= row_times(c.gamma_q, of.row[k], maps.q[j])
                A[n + i, j] -= row_times(c.gamma_v, of.row[k], maps.v[j])
        for i in range(len(of.states)):
            A[n + d + i, j] = maps.a[j, of.states[i]]


@compiled
def forward(
    entries: Entries, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, work: Work, matrix: Matrix
) -> float:
    """a and λ of the equations of motion; returns how far the pivots can be trusted."""
    trust = factor(entries, b, t, q, matrix)
    if trust > 0.0:
        solve_motion(entries, b, t, q, v, a, lam, work, matrix, ROUNDS)
    return trust


@compiled(entry=True)
def linearized(
    entries: Entries, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, work: Work, matrix: Matrix,
    phi: Constraints, c: Constraints, forces: Forces, of: Coordinates, maps: Maps, A: Array, least: float,
) -> tuple[float, int]:  # fmt: skip
    """Fill A (nx, nx + nu), the rates of x by x and u, with all maps.

    Returns
    -------
    how far the pivots can be trusted: at most `least`, nothing else is done; and FOUND or the dependent coordinate
    """
    trust = forward(entries, b, t, q, v, a, lam, work, matrix)
    if not trust > least:
        return trust, FOUND
    for k in range(len(lam)):
        phi.lam[k] = lam[k]
    evaluate(phi, t, q, v, a)
    evaluate(c, t, q, v, a)
    call_kernels(forces.force, b, t, q, v, forces.Q_q.numbers, forces.Q_v.numbers)
    call_kernels(forces.inertia, b, q, a, forces.M_a_q.numbers)
    call_kernels(forces.by_q, b, q, v, forces.S_q.numbers)
    call_kernels(forces.by_v, b, q, v, forces.S_v.numbers)
    dependent = directions(of, c, matrix, work, maps)
    if dependent == FOUND:
        positions(of, maps)
        velocities(of, phi, c, matrix, work, maps)
        accelerations(phi, forces, matrix, work, maps)
        rates(of, c, maps, A)
    return trust, dependent
