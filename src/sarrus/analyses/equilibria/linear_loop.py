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
from ..dynamics.dense_output.sample_loop import Entries, Matrix, MotionSolver, Work, factor, solve_motion
from ..equations.block_matrix import Assembler, backsolve_columns

NOTHING = 1e-15  # of the largest number above a pivot, below which it is what round-off leaves of zero


@compiled
def is_regular(placed: Assembler) -> bool:
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
    solve_motion(MotionSolver(entries, matrix, work), b, t, q, v, a, lam, rounds)
    return all_finite(a) and all_finite(lam)


# Part of a coordinate that those before leave, squared and in the metric of M, that counts as none
DEPENDENT = 1e-10
FOUND = -1


class CSR(NamedTuple):
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
    Phi_q: CSR
    Phi_qT_lam_q: CSR
    along: CSR
    gamma_q: CSR
    gamma_v: CSR
    along_a: CSR


class Forces(NamedTuple):
    """Kernels of forces and inertia, and the numbers of their derivatives."""

    force: KernelTable
    inertia: KernelTable
    by_q: KernelTable
    by_v: KernelTable
    Q_q: CSR
    Q_v: CSR
    M_a_q: CSR
    S_q: CSR
    S_v: CSR


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
    """Changes of q, v, and of a and λ by each entry of x and then by combinations of parameters, a column for each.

    Attributes
    ----------
    q, v : (nq, nx + k)
    free : (nq + m, n + ns) directions in which one coordinate or state changes alone, and what belongs to them
    gram, inverse : (n + ns, n + ns + 1) and (n + ns, n + ns) work arrays
    along : (nq + m, n) change of v on the constraints
    motion : (nq + m, nx + k) of a and λ
    right, right_free, right_along, work, work_free, work_along : right sides and work arrays of the same sizes
    """

    q: Array
    v: Array
    free: Array
    gram: Array
    inverse: Array
    along: Array
    motion: Array
    right: Array
    right_free: Array
    right_along: Array
    work: Array
    work_free: Array
    work_along: Array


@compiled
def add(A: CSR, by: float, x: Array, first: int, end: int, to: Array, at: int) -> None:
    """Add a multiple of A x to rows of `to` from `at` on, in some columns."""
    for row in range(len(A.first) - 1):
        for entry in range(A.first[row], A.first[row + 1]):
            number, column = by * A.numbers[entry], A.columns[entry]
            if number != 0.0:
                for k in range(first, end):
                    to[at + row, k] += number * x[column, k]


@compiled
def row_times(A: CSR, row: int, x: Array, column: int) -> float:
    """One row of A times one column of x; nothing for a row of -1."""
    total = 0.0
    if row >= 0:
        for entry in range(A.first[row], A.first[row + 1]):
            total += A.numbers[entry] * x[A.columns[entry], column]
    return total


@compiled
def rate_of(of: Coordinates, k: int, c: Constraints, x: Array, column: int) -> float:
    """c_q times one column of x, of one coordinate."""
    return float(row_times(c.Phi_q, of.row[k], x, column) if of.row[k] >= 0 else x[of.place[k], column])


@compiled
def evaluate(c: Constraints, b: Array, t: float, q: Array, v: Array, a: Array) -> None:
    """All derivatives of equations or coordinates."""
    call_kernels(c.kinematic, b, t, q, v, c.lam, c.Phi_q.numbers, c.Phi_qT_lam_q.numbers, c.along.numbers,
                 c.gamma_q.numbers, c.gamma_v.numbers)  # fmt: skip
    call_kernels(c.second, b, t, q, a, c.along_a.numbers)


@compiled
def clear(x: Array) -> None:
    """Set all numbers to zero."""
    for row in range(x.shape[0]):
        for column in range(x.shape[1]):
            x[row, column] = 0.0


@compiled
def solve(matrix: Matrix, right: Array, work: Array, solution: Array) -> None:
    """[M Φ_qᵀ; Φ_q 0] solution = right, without equations that are left out."""
    first = len(right) - len(matrix.left_out)
    for row in range(len(matrix.left_out)):
        if matrix.left_out[row] != 0.0:
            for column in range(right.shape[1]):
                right[first + row, column] = 0.0
    backsolve_columns(matrix.placed, right, work, solution)


@compiled
def directions(of: Coordinates, c: Constraints, matrix: Matrix, maps: Maps) -> int:
    """Directions in which constraints hold, and one coordinate or state changes alone; FOUND, or the one that cannot.

    The projections of the gradients in the metric of M span them.
    """
    n, count, gram, right = len(of.row), len(maps.gram), maps.gram, maps.right_free
    clear(right)
    for k in range(count):
        if k >= n or of.row[k] < 0:
            right[of.states[k - n] if k >= n else of.place[k], k] = 1.0
        else:
            for entry in range(c.Phi_q.first[of.row[k]], c.Phi_q.first[of.row[k] + 1]):
                right[c.Phi_q.columns[entry], k] = c.Phi_q.numbers[entry]
    solve(matrix, right, maps.work_free, maps.free)
    for k in range(count):
        for other in range(k + 1):  # it is symmetric
            rate = rate_of(of, other, c, maps.free, k) if other < n else maps.free[of.states[other - n], k]
            gram[other, k] = gram[k, other] = rate
    return invert(gram, maps.inverse)


@compiled
def invert(gram: Array, inverse: Array) -> int:
    """Invert a positive matrix by Gauss and Jordan's elimination; FOUND, or the first dependent row."""
    count = len(gram)
    for k in range(count):
        for other in range(count):
            inverse[k, other] = 0.0
        inverse[k, k], gram[k, count] = 1.0, gram[k, k]
    for k in range(count):
        pivot = gram[k, k]
        if not pivot > DEPENDENT * gram[k, count]:
            return k
        for other in range(count):
            gram[k, other] /= pivot
            inverse[k, other] /= pivot
        for row in range(count):
            by = gram[row, k]
            if row != k and by != 0.0:
                for other in range(count):
                    gram[row, other] -= by * gram[k, other]
                    inverse[row, other] -= by * inverse[k, other]
    return FOUND


@compiled
def positions(of: Coordinates, maps: Maps) -> None:
    """δq and the free part of δv."""
    n, d = len(of.row), len(of.rates)
    clear(maps.q)
    clear(maps.v)
    for k in range(len(maps.q)):
        for direction in range(len(maps.inverse)):
            by = maps.free[k, direction]
            if by != 0.0:
                for j in range(n):
                    maps.q[k, j] += by * maps.inverse[direction, j]
                for j in range(len(of.states)):
                    maps.v[k, n + d + j] += by * maps.inverse[direction, n + j]
        for j in range(d):
            maps.v[k, n + j] = maps.q[k, of.rates[j]]


@compiled
def velocities(of: Coordinates, phi: Constraints, c: Constraints, matrix: Matrix, maps: Maps) -> bool:
    """δv by δq: on the constraints, with the rates of the coordinates unchanged; whether there is any."""
    nq, n, along = len(maps.q), len(of.row), maps.along
    clear(maps.right_along)
    add(phi.gamma_v, 0.5, maps.q, 0, n, maps.right_along, nq)
    largest = 0.0
    for row in range(nq, len(along)):
        for j in range(n):
            largest = max(largest, abs(maps.right_along[row, j]))
    for entry in range(len(c.along.numbers)):
        largest = max(largest, abs(c.along.numbers[entry]))
    if largest == 0.0:
        return False
    solve(matrix, maps.right_along, maps.work_along, along)
    changes = maps.gram
    for k in range(len(changes)):
        for j in range(n):
            if k < n:
                changes[k, j] = rate_of(of, k, c, along, j) + row_times(c.along, of.row[k], maps.q, j)
            else:
                changes[k, j] = along[of.states[k - n], j]
    hold(of, along, changes, n, maps, maps.v, 0)
    return True


@compiled
def hold(
    of: Coordinates, along: Array, changes: Array, count: int, maps: Maps, to: Array, first: int
) -> None:  # fmt: skip
    """Columns of `along` without the changes of the coordinates and states that are in them."""
    n, d = len(of.row), len(of.rates)
    for row in range(len(to)):
        for j in range(count):
            to[row, first + j] = along[row, j]
        for k in range(n + len(of.states)):
            by = maps.q[row, k] if k < n else maps.v[row, d + k]
            if by != 0.0:
                for j in range(count):
                    to[row, first + j] -= by * changes[k, j]


@compiled
def accelerations(
    phi: Constraints, forces: Forces, maps: Maps, by_q: tuple[int, int], by_v: tuple[int, int]
) -> None:
    """Add to the right sides of the equations for δa and δλ what follows from some columns of δq and of δv."""
    nq, right = len(maps.q), maps.right
    add(forces.M_a_q, -1.0, maps.q, by_q[0], by_q[1], right, 0)
    add(phi.Phi_qT_lam_q, -1.0, maps.q, by_q[0], by_q[1], right, 0)
    add(forces.Q_q, 1.0, maps.q, by_q[0], by_q[1], right, 0)
    add(forces.S_q, 1.0, maps.q, by_q[0], by_q[1], right, 0)
    add(phi.gamma_q, 1.0, maps.q, by_q[0], by_q[1], right, nq)
    add(phi.along_a, -1.0, maps.q, by_q[0], by_q[1], right, nq)
    add(forces.Q_v, 1.0, maps.v, by_v[0], by_v[1], right, 0)
    add(forces.S_v, 1.0, maps.v, by_v[0], by_v[1], right, 0)
    add(phi.gamma_v, 1.0, maps.v, by_v[0], by_v[1], right, nq)


@compiled
def rates(of: Coordinates, matrix: Matrix, maps: Maps, A: Array) -> None:
    """ẋ by x and combinations, but for the changes of c_q and γ; see `bend`.

    The matrix is symmetric, and the directions are its solutions for the gradients of ċ. The rates of coordinates are
    entries of x, so that their derivatives are 0 and 1.
    """
    n, d, first = len(of.row), len(of.rates), len(maps.motion) - len(matrix.left_out)
    clear(A)
    for i in range(d):
        A[of.rates[i], n + i] = 1.0
    for row in range(len(maps.free)):
        if row < first or matrix.left_out[row - first] == 0.0:
            for i in range(d + len(of.states)):
                by = maps.free[row, of.rates[i] if i < d else n + i - d]
                if by != 0.0:
                    for j in range(A.shape[1]):
                        A[n + i, j] += by * maps.right[row, j]


@compiled
def bend(
    of: Coordinates, c: Constraints, maps: Maps, A: Array, by_q: tuple[int, int], by_v: tuple[int, int]
) -> None:
    """Add the changes of c̈ = c_q a - γ, at constant a, by some columns of δq and of δv."""
    n = len(of.row)
    for i in range(len(of.rates)):
        k = of.rates[i]
        for j in range(by_q[0], by_q[1]):
            A[n + i, j] += row_times(c.along_a, of.row[k], maps.q, j)
            A[n + i, j] -= row_times(c.gamma_q, of.row[k], maps.q, j)
        for j in range(by_v[0], by_v[1]):
            A[n + i, j] -= row_times(c.gamma_v, of.row[k], maps.v, j)
