"""Derivatives of the equations of motion at a state, forward and backward, as functions that are compiled.

    M a + Φ_qᵀλ = Q + S,    Φ_q a = γ.

All vectors are arrays (n, columns).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..._jit.link import compiled
from ..._jit.pointer import Entry, call_kernels
from ..._jit.scalars import Scalars
from ...algebra import Array
from ..equations.block_matrix import leave_out
from .columns_loop import solve_columns
from .panel_loop import copy, refactor, solve_columns_transposed


class Node(NamedTuple):
    """The operators' numbers at a node, parts of the values of the matrix of the accelerations."""

    Phi_q: Array
    Phi_qT_lam_q: Array
    M: Array
    M_a_q: Array
    S_q: Array
    S_v: Array
    Q_q: Array
    Q_v: Array
    gamma_q: Array
    gamma_v: Array
    Phi_q_a_q: Array


class Numbers(NamedTuple):
    """The operators by b: which entry each number is, and which are an operator's; see `times_numbers`."""

    b_values: Array
    b_rows: Array
    b_columns: Array
    b_segments: Array
    chosen: Array


class ByNumbers(NamedTuple):
    """The parts of `Numbers.b_values`."""

    Phi_b: Array
    Phi_qT_lam_b: Array
    Phi_q_xi_b: Array
    Phi_t_b: Array
    M_a_b: Array
    S_b: Array
    Q_b: Array
    gamma_b: Array


class Entries(NamedTuple):
    """The drivers of the operators, by address, and their entries."""

    jacobian: Entry
    inertia: Entry
    stiffness: Entry
    gamma_v: Entry
    gamma_q_v: Entry
    Phi_q_xi_q: Entry
    Phi_b: Entry
    Phi_qT_lam_b: Entry
    Phi_q_xi_b: Entry
    Phi_t_b: Entry
    M_a_b: Entry
    S_b: Entry
    Q_b: Entry
    gamma_b: Entry


class Trust(Scalars):
    """The last relative change of a refined solution, up to which the order of the pivots is kept."""

    change: float


class Bars(NamedTuple):
    """Derivatives with respect to the state (backward), or of it (forward), and to the numbers b; all with columns."""

    q: Array
    v: Array
    b: Array


class Given(NamedTuple):
    """Per node what the sweep takes or gives: gradients of responses (backward), or room for derivatives (forward)."""

    q: Array
    v: Array
    a: Array
    lam: Array


@compiled
def times_numbers(
    blocks: Numbers, n: int, rows: Array, columns: Array, weight: float, x: Array, out: Array
) -> None:
    """Out += weight A x, for operator n by b with the rows and columns of its numbers; exchanged, Aᵀ x."""
    for place in range(blocks.b_segments[n, 0], blocks.b_segments[n, 1]):
        value, row, column = weight * blocks.b_values[blocks.chosen[place]], rows[place], columns[place]
        for c in range(x.shape[1]):
            out[row, c] += value * x[column, c]


@compiled
def apply(values: Array, rows: Array, columns: Array, weight: float, x: Array, out: Array) -> None:
    """Out += weight A x; with rows and columns exchanged, Aᵀ x."""
    for k in range(len(values)):
        value, row, column = weight * values[k], rows[k], columns[k]
        for c in range(x.shape[1]):
            out[row, c] += value * x[column, c]


@compiled
def move(numbers: Numbers, n: int, weight: float, x: Array, out: Array, at: int, transposed: bool) -> None:
    """Add an operator by b, whose rows begin at a place of the equations, to these or, transposed, to the numbers."""
    if transposed:
        times_numbers(numbers, n, numbers.b_columns, numbers.b_rows, weight, x[at:], out)
    else:
        times_numbers(numbers, n, numbers.b_rows, numbers.b_columns, weight, x, out[at:])


@compiled
def subtract(source: Array, right: Array) -> None:
    """Right -= source."""
    for k in range(right.shape[0]):
        for c in range(right.shape[1]):
            right[k, c] -= source[k, c]


@compiled
def factor_node(entries: Entries, b: Array, record: Any, n: int, tables: Any) -> bool:
    """Evaluate the derivatives of the equations of motion at node n and factor [M, Φ_qᵀ; Φ_q, 0]."""
    t, q, v, a, lam = record.t[n], record.q[n], record.v[n], record.a[n], record.lam[n]
    at, by_b = tables.at_node, tables.by_b
    call_kernels(entries.jacobian, b, t, q, lam, at.Phi_q, at.Phi_qT_lam_q)
    call_kernels(entries.inertia, b, q, v, a, at.M, at.M_a_q, at.S_q, at.S_v)
    call_kernels(entries.stiffness, b, t, q, v, at.Q_q, at.Q_v)
    call_kernels(entries.gamma_q_v, b, t, q, v, at.gamma_q, at.gamma_v)
    call_kernels(entries.Phi_q_xi_q, b, t, q, a, at.Phi_q_a_q)
    leave_out(at.Phi_q, tables.places.Phi_q[0], tables.node_left_out)
    call_kernels(entries.Phi_qT_lam_b, b, t, q, lam, by_b.Phi_qT_lam_b)
    call_kernels(entries.Phi_q_xi_b, b, t, q, a, by_b.Phi_q_xi_b)
    call_kernels(entries.M_a_b, b, q, a, by_b.M_a_b)
    call_kernels(entries.S_b, b, q, v, by_b.S_b)
    call_kernels(entries.Q_b, b, t, q, v, by_b.Q_b)
    call_kernels(entries.gamma_b, b, t, q, v, by_b.gamma_b)
    return refactor(tables.node_values, tables.node)


@compiled
def quiet(x: Array, nq: int, left_out: Array) -> None:
    """As `silence`, at a node."""
    for k in range(len(left_out)):
        if left_out[k] > 0.0:
            for c in range(x.shape[1]):
                x[nq + k, c] = 0.0


@compiled
def node_by_b(numbers: Numbers, nq: int, x: Array, out: Array, transposed: bool) -> None:
    """Subtract the derivatives of the equations of motion by the numbers times x."""
    move(numbers, 1, -1.0, x, out, 0, transposed)
    move(numbers, 4, -1.0, x, out, 0, transposed)
    move(numbers, 5, 1.0, x, out, 0, transposed)
    move(numbers, 6, 1.0, x, out, 0, transposed)
    move(numbers, 2, -1.0, x, out, nq, transposed)
    move(numbers, 7, 1.0, x, out, nq, transposed)


@compiled
def forward_node(
    entries: Entries, b: Array, record: Any, n: int, tables: Any, bars: Bars, given: Given,
    beside: Any,
) -> bool:  # fmt: skip
    """The changes of a and λ at node n, written with those of q and v; false if pivots must be renewed."""
    if not factor_node(entries, b, record, n, tables):
        return False
    nq, right, at, p = len(bars.q), tables.node_right, tables.at_node, tables.places
    right[:] = 0.0
    below = right[nq:]
    apply(at.M_a_q, p.M_a_q[0], p.M_a_q[1], -1.0, bars.q, right)
    apply(at.Phi_qT_lam_q, p.Phi_qT_lam_q[0], p.Phi_qT_lam_q[1], -1.0, bars.q, right)
    apply(at.S_q, p.S_q[0], p.S_q[1], 1.0, bars.q, right)
    apply(at.Q_q, p.Q_q[0], p.Q_q[1], 1.0, bars.q, right)
    apply(at.S_v, p.S_v[0], p.S_v[1], 1.0, bars.v, right)
    apply(at.Q_v, p.Q_v[0], p.Q_v[1], 1.0, bars.v, right)
    apply(at.Phi_q_a_q, p.Phi_q_a_q[0], p.Phi_q_a_q[1], -1.0, bars.q, below)
    apply(at.gamma_q, p.gamma_q[0], p.gamma_q[1], 1.0, bars.q, below)
    apply(at.gamma_v, p.gamma_v[0], p.gamma_v[1], 1.0, bars.v, below)
    node_by_b(tables.numbers, nq, bars.b, right, False)
    if len(beside.node) > 0:
        subtract(beside.node[n], right)
    quiet(right, nq, tables.node_left_out)
    solution = tables.node_solution
    change = solve_columns(tables.node, tables.node_by_rows, right, solution, tables.node_arranged)
    if not change <= tables.trust.change:
        return False
    copy(bars.q, given.q[n])
    copy(bars.v, given.v[n])
    copy(solution[:nq], given.a[n])
    copy(solution[nq:], given.lam[n])
    return True


@compiled
def backward_node(
    entries: Entries, b: Array, record: Any, n: int, tables: Any, bars: Bars, given: Given,
    beside: Any, turned: Any,
) -> bool:  # fmt: skip
    """Add what responses take from node n, by a and λ too; false if pivots must be renewed."""
    nq, right, y = len(bars.q), tables.node_right, tables.node_solution
    copy(given.a[n], right)
    copy(given.lam[n], right[nq:])
    if len(turned.node) > 0:
        subtract(turned.node[n], right)
    taken = False
    for k in range(len(right)):
        for c in range(right.shape[1]):
            taken = taken or right[k, c] != 0.0
    if taken:
        if not factor_node(entries, b, record, n, tables):
            return False
        if (
            not solve_columns_transposed(tables.node, right, y, tables.node_arranged)[1]
            <= tables.trust.change
        ):
            return False
        quiet(y, nq, tables.node_left_out)
        at, p, z = tables.at_node, tables.places, y[nq:]
        apply(at.M_a_q, p.M_a_q[1], p.M_a_q[0], -1.0, y, bars.q)
        apply(at.Phi_qT_lam_q, p.Phi_qT_lam_q[1], p.Phi_qT_lam_q[0], -1.0, y, bars.q)
        apply(at.S_q, p.S_q[1], p.S_q[0], 1.0, y, bars.q)
        apply(at.Q_q, p.Q_q[1], p.Q_q[0], 1.0, y, bars.q)
        apply(at.S_v, p.S_v[1], p.S_v[0], 1.0, y, bars.v)
        apply(at.Q_v, p.Q_v[1], p.Q_v[0], 1.0, y, bars.v)
        apply(at.Phi_q_a_q, p.Phi_q_a_q[1], p.Phi_q_a_q[0], -1.0, z, bars.q)
        apply(at.gamma_q, p.gamma_q[1], p.gamma_q[0], 1.0, z, bars.q)
        apply(at.gamma_v, p.gamma_v[1], p.gamma_v[0], 1.0, z, bars.v)
        node_by_b(tables.numbers, nq, y, bars.b, True)
        if len(beside.node) > 0:
            copy(y, beside.node[n])
    if len(turned.node) > 0:
        subtract(turned.node_q[n], bars.q)
        subtract(turned.node_v[n], bars.v)
    for k in range(nq):
        for c in range(right.shape[1]):
            bars.q[k, c] += given.q[n, k, c]
            bars.v[k, c] += given.v[n, k, c]
    return True
