"""Derivatives of consistent states, as functions that are compiled: on the constraints, with a and λ of the motion.

A state (q₀, v₀) of a method, or between its nodes, is made consistent as `dynamics.sample_loop` does it, with
M₀ = M(q₀) and J₀ = Φ_q(q₀):

    M₀ (q - q₀) + J₀ᵀσ = 0,   Φ(q) = 0;
    M₀ (v - v₀) + J₀ᵀρ = 0,   Φ_q(q) v + Φ_t(q) = 0;
    M a + Φ_qᵀλ = Q + S,      Φ_q a = γ   at q and v.

The first two have the matrix [M₀, J₀ᵀ; Φ_q(q), 0], the last one that of `node_loop`. At a node
q is on the constraints already. All vectors are arrays (n, 1).
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.link import compiled
from ..._jit.pointer import Entry, call_kernels
from ..._jit.vector import LANES
from ...algebra import Array
from ..equations.block_matrix import leave_out
from .columns_loop import ByRows, solve_columns
from .lanes_loop import clear_lanes
from .node_loop import (
    Bars,
    ByNumbers,
    Entries,
    Given,
    Node,
    Numbers,
    Trust,
    apply,
    backward_node,
    forward_node,
    move,
    quiet,
    subtract,
)
from .panel_loop import Factors, copy, refactor, solve_columns_transposed

NODE, PROJECTION = 0, 1  # what is done next


class Record(NamedTuple):
    """Consistent states (nt, …), and what they were made of.

    dq, dv : q - q₀, v - v₀
    between : 1 where q was put onto the constraints, 0 at nodes
    defined : 1 where the equations of motion have a solution; elsewhere states stay as they are
    left_out : 1 for equations that others imply
    """

    t: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    q0: Array
    dq: Array
    dv: Array
    sigma: Array
    rho: Array
    between: Array
    defined: Array
    left_out: Array
    places: Array
    memory: Array


class Projection(NamedTuple):
    """The operators' numbers for both projections: Φ_q0 at q₀, Φ_q at q; derivatives by q₀, of Φ_q v + Φ_t by q."""

    M: Array
    Phi_q0: Array
    Phi_q: Array
    M_dq_q: Array
    M_dv_q: Array
    sigma_q: Array
    rho_q: Array
    gamma_v: Array
    S_q: Array
    S_v: Array
    again: bool


class Tables(NamedTuple):
    """All that does not change from state to state; as far as nodes are concerned by the names of `node_loop`."""

    node: Factors
    node_values: Array
    node_left_out: Array
    node_by_rows: ByRows
    projection: Factors
    projection_values: Array
    left_out: Array
    at_node: Node
    at_projection: Projection
    places: Node
    numbers: Numbers
    by_b: ByNumbers
    trust: Trust
    node_right: Array
    node_solution: Array
    node_arranged: Array
    other_right: Array
    other_solution: Array
    q_bar: Array


class Solved(NamedTuple):
    """What is solved for at each state (nt, nq + m, 1): adjoints of the equations; or the changes of their unknowns."""

    node: Array
    velocity: Array
    position: Array


class Turned(NamedTuple):
    """What the change of an adjoint takes from the gradients, or nothing; for nodes by the names of `node_loop`."""

    node: Array
    node_q: Array
    node_v: Array
    velocity: Array
    position: Array
    q: Array
    q0: Array
    v0: Array


@compiled
def remember_state(record: Record, n: int, tables: Tables, b: Array) -> None:
    """What elements remember at state n, and which equations are left out."""
    for k in range(len(record.places)):
        b[record.places[k]] = record.memory[n, k]
    for k in range(len(tables.left_out)):
        tables.left_out[k] = record.left_out[n, k]
        tables.node_left_out[k] = record.left_out[n, k]


@compiled
def factor_projection(entries: Entries, b: Array, record: Record, n: int, tables: Tables) -> bool:
    """Evaluate the derivatives of both projections at state n and factor [M₀, J₀ᵀ; Φ_q, 0]."""
    t, q0, q, v = record.t[n], record.q0[n], record.q[n], record.v[n]
    at, rows = tables.at_projection, tables.places.Phi_q[0]
    call_kernels(entries.jacobian, b, t, q0, record.rho[n], at.Phi_q0, at.rho_q)
    call_kernels(entries.inertia, b, q0, v, record.dv[n], at.M, at.M_dv_q, at.S_q, at.S_v)
    if record.between[n] > 0.0:
        call_kernels(entries.jacobian, b, t, q0, record.sigma[n], at.Phi_q0, at.sigma_q)
        call_kernels(entries.jacobian, b, t, q, record.rho[n], at.Phi_q, at.again)
        call_kernels(entries.inertia, b, q0, v, record.dq[n], at.M, at.M_dq_q, at.S_q, at.S_v)
    else:
        for k in range(len(at.Phi_q)):
            at.Phi_q[k] = at.Phi_q0[k]
    call_kernels(entries.gamma_v, b, t, q, v, at.gamma_v)
    leave_out(at.Phi_q, rows, tables.left_out)
    leave_out(at.Phi_q0, rows, tables.left_out)
    return refactor(tables.projection_values, tables.projection)


@compiled(entry=True)
def find_multipliers(entries: Entries, b: Array, record: Record, n: int, tables: Tables) -> int:
    """σ and ρ of the states from n on, of which q - q₀ and v - v₀ are known; the state that needs new pivots."""
    while n < len(record.t):
        if record.defined[n] > 0.0:
            remember_state(record, n, tables, b)
            if not factor_projection(entries, b, record, n, tables):
                return n
            if record.between[n] > 0.0 and not multiplier_of(record.dq[n], record.sigma[n], tables):
                return n
            if not multiplier_of(record.dv[n], record.rho[n], tables):
                return n
        n += 1
    return n


@compiled
def multiplier_of(moved: Array, out: Array, tables: Tables) -> bool:
    """The multipliers of M₀ x + J₀ᵀσ = 0 for a given x; false if pivots must be renewed."""
    nq, right, solution, places = len(moved), tables.node_right, tables.node_solution, tables.places
    right[:] = 0.0
    apply(tables.at_projection.M, places.M[0], places.M[1], -1.0, moved.reshape(nq, 1), right)
    change = solve_columns(tables.projection, tables.node_by_rows, right, solution, tables.node_arranged)
    if not change <= tables.trust.change:
        return False
    for k in range(len(out)):
        out[k] = solution[nq + k, 0]
    return True


@compiled
def backward_projection(
    entries: Entries, b: Array, record: Record, n: int, tables: Tables, bars: Bars, out: Given, kept: Solved,
    turned: Turned,
) -> bool:  # fmt: skip
    """From the gradients by a consistent state n to those by (q₀, v₀); false if pivots must be renewed."""
    if not factor_projection(entries, b, record, n, tables):
        return False
    at, p, nq, room = tables.at_projection, tables.places, len(bars.q), tables.node_arranged
    right, first, q_bar, second = tables.node_right, tables.node_solution, tables.q_bar, tables.other_solution
    right[:] = 0.0
    copy(bars.v, right[:nq])
    if len(turned.velocity) > 0:
        subtract(turned.velocity[n], right)
    if not solve_columns_transposed(tables.projection, right, first, room)[1] <= tables.trust.change:
        return False
    quiet(first, nq, tables.left_out)
    copy(bars.q, q_bar)
    apply(at.gamma_v, p.gamma_v[1], p.gamma_v[0], 0.5, first[nq:], q_bar)
    if len(turned.q) > 0:
        subtract(turned.q[n], q_bar)
    if record.between[n] > 0.0:
        right[:] = 0.0
        copy(q_bar, right[:nq])
        if len(turned.position) > 0:
            subtract(turned.position[n], right)
        if not solve_columns_transposed(tables.projection, right, second, room)[1] <= tables.trust.change:
            return False
        quiet(second, nq, tables.left_out)
        q_bar[:] = 0.0
        apply(at.M, p.M[1], p.M[0], 1.0, second, q_bar)
        apply(at.M_dq_q, p.M_a_q[1], p.M_a_q[0], -1.0, second, q_bar)
        apply(at.sigma_q, p.Phi_qT_lam_q[1], p.Phi_qT_lam_q[0], -1.0, second, q_bar)
        position_by_b(entries, b, record, n, tables, second, bars.b, True)
        if len(kept.position) > 0:
            copy(second, kept.position[n])
    apply(at.M_dv_q, p.M_a_q[1], p.M_a_q[0], -1.0, first, q_bar)
    apply(at.rho_q, p.Phi_qT_lam_q[1], p.Phi_qT_lam_q[0], -1.0, first, q_bar)
    velocity_by_b(entries, b, record, n, tables, first, bars.b, True)
    if len(kept.velocity) > 0:
        copy(first, kept.velocity[n])
    if len(turned.q0) > 0:
        subtract(turned.q0[n], q_bar)
    for k in range(nq):
        out.q[n, k, 0] = q_bar[k, 0]
        bars.v[k, 0] = 0.0
    apply(at.M, p.M[1], p.M[0], 1.0, first, bars.v)
    if len(turned.v0) > 0:
        subtract(turned.v0[n], bars.v)
    copy(bars.v, out.v[n])
    return True


@compiled
def velocity_by_b(
    entries: Entries, b: Array, record: Record, n: int, tables: Tables, x: Array, out: Array, transposed: bool
) -> None:
    """Subtract the derivatives by the numbers of the equations of v times x."""
    t, q0, q, by_b, nq = record.t[n], record.q0[n], record.q[n], tables.by_b, record.q.shape[1]
    call_kernels(entries.Phi_qT_lam_b, b, t, q0, record.rho[n], by_b.Phi_qT_lam_b)
    call_kernels(entries.M_a_b, b, q0, record.dv[n], by_b.M_a_b)
    call_kernels(entries.Phi_q_xi_b, b, t, q, record.v[n], by_b.Phi_q_xi_b)
    call_kernels(entries.Phi_t_b, b, t, q, by_b.Phi_t_b)
    move(tables.numbers, 1, -1.0, x, out, 0, transposed)
    move(tables.numbers, 4, -1.0, x, out, 0, transposed)
    move(tables.numbers, 2, -1.0, x, out, nq, transposed)
    move(tables.numbers, 3, -1.0, x, out, nq, transposed)


@compiled
def position_by_b(
    entries: Entries, b: Array, record: Record, n: int, tables: Tables, x: Array, out: Array, transposed: bool
) -> None:
    """Subtract the derivatives by the numbers of the equations of q times x."""
    t, q0, by_b, nq = record.t[n], record.q0[n], tables.by_b, record.q.shape[1]
    call_kernels(entries.Phi_qT_lam_b, b, t, q0, record.sigma[n], by_b.Phi_qT_lam_b)
    call_kernels(entries.M_a_b, b, q0, record.dq[n], by_b.M_a_b)
    call_kernels(entries.Phi_b, b, t, record.q[n], by_b.Phi_b)
    move(tables.numbers, 1, -1.0, x, out, 0, transposed)
    move(tables.numbers, 4, -1.0, x, out, 0, transposed)
    move(tables.numbers, 0, -1.0, x, out, nq, transposed)


@compiled(entry=True)
def backward(
    entries: Entries, b: Array, record: Record, n: int, stage: int, tables: Tables, bars: Bars, given: Given,
    out: Given, beside: Solved, turned: Turned,
) -> tuple[int, int]:  # fmt: skip
    """From gradients by consistent states to those by what they were made of; (n, stage) of what needs new pivots."""
    while n < len(record.t):
        if record.defined[n] > 0.0:
            remember_state(record, n, tables, b)
            if stage == NODE:
                bars.q[:] = 0.0
                bars.v[:] = 0.0
                if not backward_node(entries, b, record, n, tables, bars, given, beside, turned):
                    return n, NODE
                stage = PROJECTION
            if not backward_projection(entries, b, record, n, tables, bars, out, beside, turned):
                return n, PROJECTION
        else:
            copy(given.q[n], out.q[n])
            copy(given.v[n], out.v[n])
        n, stage = n + 1, NODE
    return n, stage


@compiled
def forward_projection(
    entries: Entries, b: Array, record: Record, n: int, tables: Tables, bars: Bars, given: Given,
    beside: Solved, solved: Solved,
) -> bool:  # fmt: skip
    """The changes of q and v of state n, of those of q₀ and v₀, in place; false if pivots must be renewed."""
    if not factor_projection(entries, b, record, n, tables):
        return False
    at, p, nq, room = tables.at_projection, tables.places, len(bars.q), tables.node_arranged
    right, first, other, second = (
        tables.node_right,
        tables.node_solution,
        tables.other_right,
        tables.other_solution,
    )
    copy(given.q[n], bars.q)
    if record.between[n] > 0.0:
        right[:] = 0.0
        apply(at.M, p.M[0], p.M[1], 1.0, given.q[n], right)
        apply(at.M_dq_q, p.M_a_q[0], p.M_a_q[1], -1.0, given.q[n], right)
        apply(at.sigma_q, p.Phi_qT_lam_q[0], p.Phi_qT_lam_q[1], -1.0, given.q[n], right)
        position_by_b(entries, b, record, n, tables, bars.b, right, False)
        if len(beside.position) > 0:
            subtract(beside.position[n], right)
        quiet(right, nq, tables.left_out)
        if (
            not solve_columns(tables.projection, tables.node_by_rows, right, second, room)
            <= tables.trust.change
        ):
            return False
        copy(second[:nq], bars.q)
        copy(second, solved.position[n])
    other[:] = 0.0
    below = other[nq:]
    apply(at.M, p.M[0], p.M[1], 1.0, given.v[n], other)
    apply(at.M_dv_q, p.M_a_q[0], p.M_a_q[1], -1.0, given.q[n], other)
    apply(at.rho_q, p.Phi_qT_lam_q[0], p.Phi_qT_lam_q[1], -1.0, given.q[n], other)
    apply(at.gamma_v, p.gamma_v[0], p.gamma_v[1], 0.5, bars.q, below)
    velocity_by_b(entries, b, record, n, tables, bars.b, other, False)
    if len(beside.velocity) > 0:
        subtract(beside.velocity[n], other)
    quiet(other, nq, tables.left_out)
    if not solve_columns(tables.projection, tables.node_by_rows, other, first, room) <= tables.trust.change:
        return False
    copy(first[:nq], bars.v)
    copy(first, solved.velocity[n])
    return True


@compiled(entry=True)
def forward(
    entries: Entries, b: Array, record: Record, n: int, stage: int, tables: Tables, bars: Bars, given: Given,
    out: Given, beside: Solved, solved: Solved,
) -> tuple[int, int]:  # fmt: skip
    """The changes of consistent states of those of (q₀, v₀), which are given; (n, stage) of what needs new pivots."""
    while n < len(record.t):
        if record.defined[n] > 0.0:
            remember_state(record, n, tables, b)
            if stage == NODE:
                if not forward_projection(entries, b, record, n, tables, bars, given, beside, solved):
                    return n, NODE
                stage = PROJECTION
            if not forward_node(entries, b, record, n, tables, bars, out, beside):
                return n, PROJECTION
        else:
            copy(given.q[n], out.q[n])
            copy(given.v[n], out.v[n])
        n, stage = n + 1, NODE
    return n, stage


class Operands(NamedTuple):
    """What the drivers of `lagrangian` take at every state (nt, …), and directions in which it changes."""

    t: Array
    q: Array
    v: Array
    a: Array
    q_dot: Array
    v_dot: Array
    a_dot: Array
    xi: Array
    lam: Array
    nu: Array
    lam_dot: Array


class Changes(NamedTuple):
    """What they give: the changes of gradients by these (nt, …)."""

    q: Array
    v: Array
    a: Array
    lam: Array


class Room(NamedTuple):
    """Operands and results of one call, in lanes."""

    t: Array
    q: Array
    v: Array
    a: Array
    q_dot: Array
    v_dot: Array
    a_dot: Array
    xi: Array
    lam: Array
    nu: Array
    lam_dot: Array
    by_q: Array
    by_v: Array
    by_a: Array
    by_lam: Array
    by_b: Array


@compiled
def clear(room: Room) -> None:
    """Adjoint variables and results begin with zero."""
    clear_lanes(room.xi)
    clear_lanes(room.nu)
    clear_lanes(room.by_q)
    clear_lanes(room.by_v)
    clear_lanes(room.by_a)
    clear_lanes(room.by_lam)


@compiled
def put(x: Array, lane: int, weight: float, out: Array) -> None:
    """A lane of out = weight x."""
    for k in range(len(x)):
        out[k * LANES + lane] = weight * x[k]


@compiled
def take(x: Array, lane: int, weight: float, out: Array) -> None:
    """Out += weight x of a lane."""
    for k in range(len(x) // LANES):
        out[k] += weight * x[k * LANES + lane]


@compiled(entry=True)
def of_states(
    entry: Entry, b: Array, b_dot: Array, record: Record, many: int, x: Operands, room: Room, found: Changes
) -> None:
    """The changes of the gradients of ℓ at all states, `many` at once; room.by_b has those by the numbers."""
    first = 0
    while first < len(x.t):
        count = min(many, len(x.t) - first)
        for k in range(len(record.places)):
            b[record.places[k]] = record.memory[first, k]
        clear(room)
        for lane in range(LANES):
            n, used = (first + lane, 1.0) if lane < count else (first, 0.0)
            room.t[lane] = x.t[n]
            put(x.q[n], lane, 1.0, room.q)
            put(x.v[n], lane, 1.0, room.v)
            put(x.a[n], lane, 1.0, room.a)
            put(x.q_dot[n], lane, 1.0, room.q_dot)
            put(x.v_dot[n], lane, 1.0, room.v_dot)
            put(x.a_dot[n], lane, 1.0, room.a_dot)
            put(x.lam[n], lane, 1.0, room.lam)
            put(x.lam_dot[n], lane, 1.0, room.lam_dot)
            put(x.xi[n], lane, used, room.xi)
            put(x.nu[n], lane, used, room.nu)
        call_kernels(
            entry, b, room.t, room.q, room.v, room.a, room.q_dot, room.v_dot, room.a_dot,
            room.xi, room.lam, room.nu, room.lam_dot, b_dot,
            room.by_q, room.by_v, room.by_a, room.by_lam, room.by_b,
        )  # fmt: skip
        for lane in range(count):
            take(room.by_q, lane, 1.0, found.q[first + lane])
            take(room.by_v, lane, 1.0, found.v[first + lane])
            take(room.by_a, lane, 1.0, found.a[first + lane])
            take(room.by_lam, lane, 1.0, found.lam[first + lane])
        first += count
