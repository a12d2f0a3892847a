"""Derivatives of the equations of motion by combinations of parameters, as columns: functions that are compiled.

A combination is a change of the parameters b of the elements: that of an input, or of a parameter of the model. It
moves the mechanism where the coordinates c and their rates are constant,

    Φ_q δq = -Φ_b δb,                                        c_q δq = -c_b δb,
    Φ_q δv = -(Φ_q v + Φ_t)_q δq - (Φ_q v + Φ_t)_b δb,       c_q δv = -(c_q v)_q δq - (c_q v)_b δb
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.kernels.pointer import KernelTable, call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import Matrix
from .linear_loop import Constraints, Coordinates, Maps, clear, hold, rate_of, row_times, solve


class Combination(NamedTuple):
    """The derivatives of an operator by b, and their products with changes of b; no kernels if all of these are zero.

    entries, weights : number of the derivatives and its factor, for each product
    rows, columns : where the product is added: row of the operator, and combination
    """

    kernel: KernelTable
    numbers: Array
    entries: Array
    weights: Array
    rows: Array
    columns: Array


class ByParameters(NamedTuple):
    """The operators of the equations of motion, by combinations of parameters."""

    M_a: Combination
    Phi_qT_lam: Combination
    Q: Combination
    S: Combination
    Phi_q_a: Combination
    gamma: Combination


class Displacer(NamedTuple):
    """Constraints and coordinates by combinations of parameters, with work arrays.

    Attributes
    ----------
    present : whether any of these derivatives is not zero
    Phi, Phi_q_v, Phi_t : of the constraints
    c, c_q_v, c_q_a, gamma : of the coordinates, a row for each
    right, along, work : (nq + m, k)
    changes : (n + ns, k) of the coordinates and states
    """

    present: bool
    Phi: Combination
    Phi_q_v: Combination
    Phi_t: Combination
    c: Combination
    c_q_v: Combination
    c_q_a: Combination
    gamma: Combination
    right: Array
    along: Array
    work: Array
    changes: Array


@compiled
def add_products(of: Combination, by: float, to: Array, row: int, column: int) -> None:
    """Add a multiple of the change with each combination to a column."""
    for k in range(len(of.entries)):
        to[row + of.rows[k], column + of.columns[k]] += by * of.weights[k] * of.numbers[of.entries[k]]


@compiled
def add_motion_by_parameters(
    of: ByParameters, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, right: Array, column: int
) -> None:
    """Add (Q + S - M a - Φ_qᵀλ)_b and (γ - Φ_q a)_b along each combination, at constant q, v, a and λ."""
    nq = len(q)
    call_kernels(of.M_a.kernel, b, q, a, of.M_a.numbers)
    call_kernels(of.Phi_qT_lam.kernel, b, t, q, lam, of.Phi_qT_lam.numbers)
    call_kernels(of.Q.kernel, b, t, q, v, of.Q.numbers)
    call_kernels(of.S.kernel, b, q, v, of.S.numbers)
    call_kernels(of.Phi_q_a.kernel, b, t, q, a, of.Phi_q_a.numbers)
    call_kernels(of.gamma.kernel, b, t, q, v, of.gamma.numbers)
    add_products(of.Q, 1.0, right, 0, column)
    add_products(of.S, 1.0, right, 0, column)
    add_products(of.M_a, -1.0, right, 0, column)
    add_products(of.Phi_qT_lam, -1.0, right, 0, column)
    add_products(of.gamma, 1.0, right, nq, column)
    add_products(of.Phi_q_a, -1.0, right, nq, column)


@compiled
def displace(
    of: Coordinates, by: Displacer, phi: Constraints, c: Constraints, matrix: Matrix, b: Array, t: float, q: Array,
    v: Array, maps: Maps, first: int,
) -> bool:  # fmt: skip
    """δq and δv by combinations at constant coordinates, rates and states, in columns from the first on; if any."""
    if not by.present:
        return False
    nq, count = len(q), by.changes.shape[1]
    call_kernels(by.Phi.kernel, b, t, q, by.Phi.numbers)
    call_kernels(by.Phi_q_v.kernel, b, t, q, v, by.Phi_q_v.numbers)
    call_kernels(by.Phi_t.kernel, b, t, q, by.Phi_t.numbers)
    call_kernels(by.c.kernel, c.b, t, q, by.c.numbers)
    call_kernels(by.c_q_v.kernel, c.b, t, q, v, by.c_q_v.numbers)
    clear(by.right)
    add_products(by.Phi, -1.0, by.right, nq, 0)
    solve(matrix, by.right, by.work, by.along)
    rates_along(of, by, c)
    add_products(by.c, 1.0, by.changes, 0, 0)
    hold(of, by.along, by.changes, count, maps, maps.q, first)
    clear(by.right)
    for row in range(len(phi.gamma_v.first) - 1):
        for j in range(count):
            by.right[nq + row, j] = 0.5 * row_times(phi.gamma_v, row, maps.q, first + j)
    add_products(by.Phi_q_v, -1.0, by.right, nq, 0)
    add_products(by.Phi_t, -1.0, by.right, nq, 0)
    solve(matrix, by.right, by.work, by.along)
    rates_along(of, by, c)
    for k in range(len(of.row)):
        for j in range(count):
            by.changes[k, j] += row_times(c.along, of.row[k], maps.q, first + j)
    add_products(by.c_q_v, 1.0, by.changes, 0, 0)
    hold(of, by.along, by.changes, count, maps, maps.v, first)
    return True


@compiled
def rates_along(of: Coordinates, by: Displacer, c: Constraints) -> None:
    """The changes of the coordinates and states with q or v along `along`."""
    n = len(of.row)
    for k in range(len(by.changes)):
        for j in range(by.changes.shape[1]):
            by.changes[k, j] = rate_of(of, k, c, by.along, j) if k < n else by.along[of.states[k - n], j]


@compiled
def bend_by_parameters(
    of: Coordinates,
    by: Displacer,
    c: Constraints,
    t: float,
    q: Array,
    v: Array,
    a: Array,
    A: Array,
    first: int,
) -> None:
    """Add (c_q a - γ)_b to the columns of combinations."""
    call_kernels(by.c_q_a.kernel, c.b, t, q, a, by.c_q_a.numbers)
    call_kernels(by.gamma.kernel, c.b, t, q, v, by.gamma.numbers)
    add_products(by.c_q_a, 1.0, A, len(of.row), first)
    add_products(by.gamma, -1.0, A, len(of.row), first)
