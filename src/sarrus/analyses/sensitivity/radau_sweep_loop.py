"""Derivatives of the steps of Radau IIA, forward and backward, as functions that are compiled.

With what `radau_loop` says of a step, its unknowns are q, v, λ, μ at the three stages; with σᵢ = Σⱼ (A⁻¹)ᵢⱼ, they solve

    F₁ = (Σⱼ (A⁻¹)ᵢⱼ qⱼ - σᵢ q₀) / h - vᵢ + Φ_qᵀμᵢ,    F₃ = Φ,
    F₂ = M aᵢ + Φ_qᵀλᵢ - Q - S,                         F₄ = Φ_q vᵢ + Φ_t,    aᵢ = (Σⱼ (A⁻¹)ᵢⱼ vⱼ - σᵢ v₀) / h,

and the state at the end is q₃, v₃. The matrix J of all stages is exact, each stage with its own derivatives; rows are
multiplied by h, h², 1, h and columns by 1, 1/h, 1/h², 1/h, so that its condition does not depend on h. A change of
b, q₀, v₀ changes the unknowns by J x = -F_b b' + [σᵢ q₀' / h; σᵢ M v₀' / h; 0; 0]; the adjoint solves with Jᵀ.

Accelerations and multipliers of a node are those of the equations of motion there,

    M a + Φ_qᵀλ = Q + S,    Φ_q a = γ.

Columns (of the numbers, or of responses) are handled together: all vectors are arrays (n, columns).
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.link import compiled
from ..._jit.pointer import Entry, call_kernels
from ..._jit.scalars import Scalars
from ...algebra import Array
from ..dynamics.placed import leave_out
from ..dynamics.radau_loop import Scheme
from .columns_loop import ByRows, solve_columns
from .panel_loop import Factors, copy, refactor, solve_columns_transposed

STEP, NODE = 0, 1  # what is done next


class Record(NamedTuple):
    """The steps as they were taken, with their stages; see `sarrus.results.RadauSteps`."""

    t: Array
    h: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    stage_q: Array
    stage_v: Array
    stage_a: Array
    stage_lam: Array
    stage_mu: Array
    left_out: Array
    places: Array
    memory: Array


class Stage(NamedTuple):
    """The operators' numbers at one stage, parts of the values of the step's matrix."""

    Phi_q: Array
    Phi_qT_lam_q: Array
    Phi_qT_mu_q: Array
    M: Array
    M_a_q: Array
    S_q: Array
    S_v: Array
    Q_q: Array
    Q_v: Array
    gamma_v: Array


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


class Tables(NamedTuple):
    """All that does not change from step to step: matrices, operators' numbers, and room to work.

    step, node : the matrices (`step_matrix.Factors`), and the values from which they are assembled
    trust : see `Trust`
    places : rows and columns (2, entries) of the numbers of each operator
    left_out, node_left_out : 1 for equations that others imply, parts of both values
    step_by_rows, node_by_rows : the matrices by rows, for panels of columns forward
    """

    step: Factors
    step_values: Array
    node: Factors
    node_values: Array
    stages: tuple[Stage, ...]
    at_node: Node
    places: Node
    numbers: Numbers
    by_b: ByNumbers
    left_out: Array
    node_left_out: Array
    Phi_q_again: Array
    trust: Trust
    right: Array
    solution: Array
    arranged: Array
    node_right: Array
    node_solution: Array
    node_arranged: Array
    step_by_rows: ByRows
    node_by_rows: ByRows


class Bars(NamedTuple):
    """Derivatives with respect to the state (backward), or of it (forward), and to the numbers b; all with columns."""

    q: Array
    v: Array
    b: Array


class Beside(NamedTuple):
    """Forwards, changes of the equations besides; backwards, room for what is solved for; or none.

    step : of the stages of each step (n, 6 (nq + m), columns)
    node : of the equations of motion at each node (n + 1, nq + m, columns)
    """

    step: Array
    node: Array


class Turned(NamedTuple):
    """Backwards, what the change of an adjoint takes from the gradients; or none. See `radau_hessian_loop`.

    step : by the unknowns of each step (n, 6 (nq + m), 1)
    v : by the velocities that it begins with (n, nq, 1)
    node : by accelerations and multipliers of each node (n + 1, nq + m, 1)
    node_q, node_v : by its state (n + 1, nq, 1)
    """

    step: Array
    v: Array
    node: Array
    node_q: Array
    node_v: Array


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
def remember(record: Record, n: int, tables: Tables, b: Array) -> None:
    """What elements remembered during step n, and which equations were left out."""
    for k in range(len(record.places)):
        b[record.places[k]] = record.memory[n, k]
    if len(record.left_out) > 0:
        for k in range(len(tables.left_out)):
            tables.left_out[k] = record.left_out[n + 1, k]
            tables.node_left_out[k] = record.left_out[n + 1, k]


@compiled
def factor_step(scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, tables: Tables) -> bool:
    """Evaluate and factor the matrix of all stages of step n; false if that cannot be."""
    h, places = record.h[n], tables.places
    for i in range(3):
        t, stage = record.t[n] + scheme.c[i] * h, tables.stages[i]
        q, v, a = record.stage_q[n, i], record.stage_v[n, i], record.stage_a[n, i]
        again = tables.Phi_q_again
        call_kernels(entries.jacobian, b, t, q, record.stage_mu[n, i], again, stage.Phi_qT_mu_q)
        call_kernels(entries.jacobian, b, t, q, record.stage_lam[n, i], stage.Phi_q, stage.Phi_qT_lam_q)
        call_kernels(entries.inertia, b, q, v, a, stage.M, stage.M_a_q, stage.S_q, stage.S_v)
        call_kernels(entries.stiffness, b, t, q, v, stage.Q_q, stage.Q_v)
        call_kernels(entries.gamma_v, b, t, q, v, stage.gamma_v)
        leave_out(stage.Phi_q, places.Phi_q[0], tables.left_out)
        leave_out(stage.gamma_v, places.gamma_v[0], tables.left_out)
    step_weights(scheme, h, tables.step.weights)
    return refactor(tables.step_values, tables.step)


@compiled
def apply(values: Array, rows: Array, columns: Array, weight: float, x: Array, out: Array) -> None:
    """Out += weight A x; with rows and columns exchanged, Aᵀ x."""
    for k in range(len(values)):
        value, row, column = weight * values[k], rows[k], columns[k]
        for c in range(x.shape[1]):
            out[row, c] += value * x[column, c]


@compiled
def step_weights(scheme: Scheme, h: float, weights: Array) -> None:
    """Weights of the parts of the matrix, in the order of `radau_sweep.step_parts`."""
    at = 0
    for i in range(3):
        for j in range(3):
            weights[at], weights[at + 1] = scheme.inverse[i, j], scheme.inverse[i, j]
            at += 2
        weights[at], weights[at + 1], weights[at + 2] = -1.0, h, 1.0
        weights[at + 3], weights[at + 4] = h * h, h * h
        weights[at + 5], weights[at + 6] = -h * h, -h * h
        weights[at + 7], weights[at + 8] = -h, -h
        weights[at + 9], weights[at + 10], weights[at + 11] = 1.0, 1.0, -0.5 * h
        weights[at + 12], weights[at + 13], weights[at + 14] = 1.0, 1.0, 1.0
        at += 15


@compiled
def scale(x: Array, nq: int, m: int, on_q: float, on_v: float, on_lam: float, on_mu: float) -> None:
    """Multiply the parts of the unknowns, or of the equations, of every stage."""
    for i in range(3):
        at = 2 * i * (nq + m)
        for c in range(x.shape[1]):
            for k in range(nq):
                x[at + k, c] *= on_q
                x[at + nq + k, c] *= on_v
            for k in range(m):
                x[at + 2 * nq + k, c] *= on_lam
                x[at + 2 * nq + m + k, c] *= on_mu


@compiled
def silence(x: Array, nq: int, m: int, left_out: Array) -> None:
    """Nothing stands for the equations that others imply."""
    for i in range(3):
        at = 2 * i * (nq + m) + 2 * nq
        for k in range(m):
            if left_out[k] > 0.0:
                for c in range(x.shape[1]):
                    x[at + k, c] = 0.0
                    x[at + m + k, c] = 0.0


@compiled
def stage_by_b(
    scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, i: int, tables: Tables, x: Array,
    out: Array, transposed: bool,
) -> None:  # fmt: skip
    """Subtract F_b x (forward), or F_bᵀ x (backward), of stage i of step n."""
    t, q, v = record.t[n] + scheme.c[i] * record.h[n], record.stage_q[n, i], record.stage_v[n, i]
    nq, m, by_b, numbers = len(q), len(tables.left_out), tables.by_b, tables.numbers
    call_kernels(entries.Phi_b, b, t, q, by_b.Phi_b)
    call_kernels(entries.Phi_q_xi_b, b, t, q, v, by_b.Phi_q_xi_b)
    call_kernels(entries.Phi_t_b, b, t, q, by_b.Phi_t_b)
    call_kernels(entries.M_a_b, b, q, record.stage_a[n, i], by_b.M_a_b)
    call_kernels(entries.S_b, b, q, v, by_b.S_b)
    call_kernels(entries.Q_b, b, t, q, v, by_b.Q_b)
    first = 2 * i * (nq + m)
    second, third, fourth = first + nq, first + 2 * nq, first + 2 * nq + m
    call_kernels(entries.Phi_qT_lam_b, b, t, q, record.stage_mu[n, i], by_b.Phi_qT_lam_b)
    move(numbers, 1, -1.0, x, out, first, transposed)
    call_kernels(entries.Phi_qT_lam_b, b, t, q, record.stage_lam[n, i], by_b.Phi_qT_lam_b)
    move(numbers, 1, -1.0, x, out, second, transposed)
    move(numbers, 4, -1.0, x, out, second, transposed)
    move(numbers, 5, 1.0, x, out, second, transposed)
    move(numbers, 6, 1.0, x, out, second, transposed)
    move(numbers, 0, -1.0, x, out, third, transposed)
    move(numbers, 2, -1.0, x, out, fourth, transposed)
    move(numbers, 3, -1.0, x, out, fourth, transposed)


@compiled
def move(numbers: Numbers, n: int, weight: float, x: Array, out: Array, at: int, transposed: bool) -> None:
    """Add an operator by b, whose rows begin at a place of the equations, to these or, transposed, to the numbers."""
    if transposed:
        times_numbers(numbers, n, numbers.b_columns, numbers.b_rows, weight, x[at:], out)
    else:
        times_numbers(numbers, n, numbers.b_rows, numbers.b_columns, weight, x, out[at:])


@compiled
def forward_step(
    scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, tables: Tables, bars: Bars,
    beside: Beside, stages: Array,
) -> bool:  # fmt: skip
    """The change of q and v over step n, and perhaps of its stages; false if pivots must be renewed."""
    if not factor_step(scheme, entries, b, record, n, tables):
        return False
    h, nq, m, right, places = record.h[n], len(bars.q), len(tables.left_out), tables.right, tables.places
    right[:] = 0.0
    for i in range(3):
        at = 2 * i * (nq + m)
        share = (scheme.inverse[i, 0] + scheme.inverse[i, 1] + scheme.inverse[i, 2]) / h
        for k in range(nq):
            for c in range(right.shape[1]):
                right[at + k, c] = share * bars.q[k, c]
        M = tables.stages[i].M
        apply(M, places.M[0], places.M[1], share, bars.v, right[at + nq :])
        stage_by_b(scheme, entries, b, record, n, i, tables, bars.b, right, False)
    if len(beside.step) > 0:
        subtract(beside.step[n], right)
    silence(right, nq, m, tables.left_out)
    scale(right, nq, m, h, h * h, 1.0, h)
    change = solve_columns(tables.step, tables.step_by_rows, right, tables.solution, tables.arranged)
    if not change <= tables.trust.change:
        return False
    last = 4 * (nq + m)
    for k in range(nq):
        for c in range(right.shape[1]):
            bars.q[k, c] = tables.solution[last + k, c]
            bars.v[k, c] = tables.solution[last + nq + k, c] / h
    if len(stages) > 0:
        copy(tables.solution, stages[n])
        scale(stages[n], nq, m, 1.0, 1.0 / h, 1.0 / (h * h), 1.0 / h)
    return True


@compiled
def backward_step(
    scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, tables: Tables, bars: Bars,
    beside: Beside, turned: Turned,
) -> bool:  # fmt: skip
    """From the gradients by the end of step n to those by its start; false if pivots must be renewed."""
    if not factor_step(scheme, entries, b, record, n, tables):
        return False
    h, nq, m, right, w = record.h[n], len(bars.q), len(tables.left_out), tables.right, tables.solution
    right[:] = 0.0
    last = 4 * (nq + m)
    for k in range(nq):
        for c in range(right.shape[1]):
            right[last + k, c] = bars.q[k, c]
            right[last + nq + k, c] = bars.v[k, c] / h
    if len(turned.step) > 0:
        copy(turned.step[n], w)
        scale(w, nq, m, 1.0, 1.0 / h, 1.0 / (h * h), 1.0 / h)
        subtract(w, right)
    if not solve_columns_transposed(tables.step, right, w, tables.arranged)[1] <= tables.trust.change:
        return False
    bars.q[:] = 0.0
    bars.v[:] = 0.0
    scale(w, nq, m, h, h * h, 1.0, h)
    silence(w, nq, m, tables.left_out)
    for i in range(3):
        at = 2 * i * (nq + m)
        share = (scheme.inverse[i, 0] + scheme.inverse[i, 1] + scheme.inverse[i, 2]) / h
        for k in range(nq):
            for c in range(right.shape[1]):
                bars.q[k, c] += share * w[at + k, c]
        M, places = tables.stages[i].M, tables.places.M
        apply(M, places[1], places[0], share, w[at + nq :], bars.v)
        stage_by_b(scheme, entries, b, record, n, i, tables, w, bars.b, True)
    if len(turned.v) > 0:
        subtract(turned.v[n], bars.v)
    if len(beside.step) > 0:
        copy(w, beside.step[n])
    return True


@compiled
def subtract(source: Array, right: Array) -> None:
    """Right -= source."""
    for k in range(right.shape[0]):
        for c in range(right.shape[1]):
            right[k, c] -= source[k, c]


@compiled
def factor_node(entries: Entries, b: Array, record: Record, n: int, tables: Tables) -> bool:
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
    entries: Entries, b: Array, record: Record, n: int, tables: Tables, bars: Bars, given: Given,
    beside: Beside,
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
    entries: Entries, b: Array, record: Record, n: int, tables: Tables, bars: Bars, given: Given,
    beside: Beside, turned: Turned,
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


@compiled(entry=True)
def forward(
    scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, stage: int, tables: Tables, bars: Bars,
    given: Given, beside: Beside, stages: Array,
) -> tuple[int, int]:  # fmt: skip
    """From node n to the last one, derivatives written at all; returns (n, stage) of what needs new pivots."""
    last = len(record.h)
    while n <= last:
        if stage == NODE:
            remember(record, max(n - 1, 0), tables, b)
            if not forward_node(entries, b, record, n, tables, bars, given, beside):
                return n, NODE
            stage = STEP
        if n == last:
            return last + 1, NODE
        remember(record, n, tables, b)
        if not forward_step(scheme, entries, b, record, n, tables, bars, beside, stages):
            return n, STEP
        n, stage = n + 1, NODE
    return n, stage


@compiled(entry=True)
def backward(
    scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, stage: int, tables: Tables, bars: Bars,
    given: Given, beside: Beside, turned: Turned,
) -> tuple[int, int]:  # fmt: skip
    """From node n, whose gradients are given, to the start; returns (n, stage) of what needs new pivots."""
    while n >= 0:
        if stage == NODE:
            remember(record, max(n - 1, 0), tables, b)
            if not backward_node(entries, b, record, n, tables, bars, given, beside, turned):
                return n, NODE
            stage = STEP
        if n == 0:
            return -1, NODE
        remember(record, n - 1, tables, b)
        if not backward_step(scheme, entries, b, record, n - 1, tables, bars, beside, turned):
            return n, STEP
        n, stage = n - 1, NODE
    return n, stage
