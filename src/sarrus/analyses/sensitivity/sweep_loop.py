"""Derivatives of the steps of the generalized-α method, forward and backward, as functions that are compiled.

With what `alpha_loop` says of a step, its unknowns (a₁, λ₁) solve R(a₁, λ₁; q₀, v₀, ã₀, a₀, b) = 0 with the matrix
J = [M + β'K + γ'C, Φ_qᵀ; Φ_q, 0], K = (M a)_q + (Φ_qᵀλ)_q - Q_q - S_q, C = -Q_v - S_v, at the converged state. So

    J [a₁'; λ₁'] = -[R_b b' + K q* + C v*; (Φ_b b' + Φ_q q*) / β']

where q*, v* are the changes of q₁, v₁ with a₁ held; the adjoint solves with Jᵀ. Columns (of the numbers, or of
responses) are handled together: all vectors here are arrays (n, columns). Step lengths are data.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .panel_loop import copy, solve_columns, solve_columns_transposed

VELOCITY: Any = None  # drivers and solvers, put in place when this is compiled
JACOBIAN: Any = None
INERTIA: Any = None
GAMMA_V: Any = None
PHI_B: Any = None
PHI_QT_LAM_B: Any = None
PHI_Q_XI_B: Any = None
PHI_T_B: Any = None
M_A_B: Any = None
S_B: Any = None
Q_B: Any = None
weights_of: Any = None  # of `dynamics.alpha_loop`
factor: Any = None
leave_out: Any = None  # of `dynamics.placed`
STEP, RESCALE, GRADIENTS = 0, 1, 2  # what is done next


class Record(NamedTuple):
    """The steps as they were taken; see `sarrus.results.Steps`."""

    t: Any
    h: Any
    removed: Any
    q: Any
    v: Any
    a: Any
    lam: Any
    left_out: Any
    places: Any
    memory: Any


class Blocks(NamedTuple):
    """Which entry of an operator each number is, and which numbers are an operator's (from, to).

    values, rows, columns, segments : the operators of the Newton matrix
    b_values : the operators by b; chosen : those that are not multiplied by zero, and their b_rows, b_columns;
        b_segments : each operator's parts of these
    """

    values: Any
    rows: Any
    columns: Any
    segments: Any
    b_values: Any
    b_rows: Any
    b_columns: Any
    b_segments: Any
    chosen: Any
    gamma_v: Any
    gamma_v_rows: Any
    gamma_v_columns: Any
    gamma_v_segment: Any


class Views(NamedTuple):
    """The operators' parts of the flat arrays of numbers."""

    M: Any
    M_a_q: Any
    S_q: Any
    S_v: Any
    Q_q: Any
    Q_v: Any
    Phi_qT_lam_q: Any
    left_out: Any
    Phi_q: Any
    Phi_b: Any
    Phi_qT_lam_b: Any
    Phi_q_xi_b: Any
    Phi_t_b: Any
    M_a_b: Any
    S_b: Any
    Q_b: Any


class Entries(NamedTuple):
    """The drivers of the operators, by address, and their entries."""

    velocity: Any
    jacobian: Any
    inertia: Any
    stiffness: Any
    gamma_v: Any
    Phi_b: Any
    Phi_qT_lam_b: Any
    Phi_q_xi_b: Any
    Phi_t_b: Any
    M_a_b: Any
    S_b: Any
    Q_b: Any


class Work(NamedTuple):
    """Vectors with columns: of the unknowns (nq + m), and of coordinates; without columns, and with a single one.

    room : of three vectors with columns, for `solve_columns`
    trusted : the last relative change of a solution, up to which the order of the pivots is kept
    """

    right: Any
    solution: Any
    room: Any
    q: Any
    v: Any
    x: Any
    s: Any
    sigma: Any
    defect: Any
    Phi_t: Any
    single: Any
    trusted: Any


class Bars(NamedTuple):
    """Derivatives with respect to the state (backward), or of it (forward), and to the numbers b; all with columns."""

    q: Any
    v: Any
    a: Any
    x: Any
    lam: Any
    b: Any


class Kept(NamedTuple):
    """Room for what is solved for in every step and every change of its size (n, nq + m, columns), or none.

    s are the solutions s, σ of the changes themselves (n, nq + m).
    """

    step: Any
    rescale: Any
    s: Any


class Sources(NamedTuple):
    """Changes of the equations besides; or none.

    Backwards those of the adjoint's equations (n, nq + m), (n, nq); forwards, in `step` and `rescale`, those of the
    residuals (n, nq + m, columns).
    """

    step: Any
    step_q: Any
    step_v: Any
    rescale: Any
    rescale_q: Any
    rescale_v: Any


class Given(NamedTuple):
    """Per node what the sweep takes or gives: gradients of responses (backward), or room for derivatives (forward)."""

    q: Any
    v: Any
    a: Any
    lam: Any


def times(values: Any, rows: Any, columns: Any, segment: Any, weight: Any, x: Any, out: Any) -> None:
    """Out += weight A x for the entries of A in a segment, from, to."""
    width = x.shape[1]
    for k in range(segment[0], segment[1]):
        value, row, column = weight * values[k], rows[k], columns[k]
        if width == 1:
            out[row, 0] += value * x[column, 0]
        else:
            for c in range(width):
                out[row, c] += value * x[column, c]


def by_numbers(blocks: Any, n: Any, weight: Any, x: Any, out: Any) -> None:
    """Out += weight A x, for an operator A by b."""
    width = x.shape[1]
    for place in range(blocks.b_segments[n, 0], blocks.b_segments[n, 1]):
        k = blocks.chosen[place]
        value, row, column = weight * blocks.b_values[k], blocks.b_rows[place], blocks.b_columns[place]
        if width == 1:
            out[row, 0] += value * x[column, 0]
        else:
            for c in range(width):
                out[row, c] += value * x[column, c]


def by_numbers_transposed(blocks: Any, n: Any, weight: Any, x: Any, out: Any) -> None:
    """Out += weight Aᵀ x, for an operator A by b."""
    width = x.shape[1]
    for place in range(blocks.b_segments[n, 0], blocks.b_segments[n, 1]):
        k = blocks.chosen[place]
        value, row, column = weight * blocks.b_values[k], blocks.b_rows[place], blocks.b_columns[place]
        if width == 1:
            out[column, 0] += value * x[row, 0]
        else:
            for c in range(width):
                out[column, c] += value * x[row, c]


def linearize(scheme: Any, entries: Any, b: Any, record: Any, n: Any, matrix: Any, views: Any) -> Any:
    """Factor the Newton matrix at the end of step n, and evaluate the operators by b; false for new pivots."""
    t, q, v, a, lam = record.t[n + 1], record.q[n + 1], record.v[n + 1], record.a[n + 1], record.lam[n + 1]
    beta, gamma = weights_of(scheme, record.h[n])
    if not factor(entries, b, t, q, v, a, lam, matrix, beta, gamma):
        return False
    PHI_B(entries.Phi_b, b, t, q, views.Phi_b)
    PHI_QT_LAM_B(entries.Phi_qT_lam_b, b, t, q, lam, views.Phi_qT_lam_b)
    M_A_B(entries.M_a_b, b, q, a, views.M_a_b)
    S_B(entries.S_b, b, q, v, views.S_b)
    Q_B(entries.Q_b, b, t, q, v, views.Q_b)
    return True


def forward_step(
    scheme: Any, entries: Any, b: Any, record: Any, n: Any, matrix: Any, blocks: Any, views: Any, work: Any,
    bars: Any, sources: Any,
) -> Any:  # fmt: skip
    """The change of the state over step n; false if pivots must be renewed."""
    if not linearize(scheme, entries, b, record, n, matrix, views):
        return False
    h, kappa = record.h[n], (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    beta, gamma = weights_of(scheme, h)
    nq, m, width = bars.q.shape[0], bars.lam.shape[0], bars.q.shape[1]
    share_m, share_f = scheme.alpha_m / (1.0 - scheme.alpha_m), scheme.alpha_f / (1.0 - scheme.alpha_m)
    for k in range(nq):
        for c in range(width):
            x0 = bars.x[k, c]
            x = share_f * bars.a[k, c] - share_m * x0
            work.x[k, c] = x
            work.q[k, c] = (
                bars.q[k, c] + h * bars.v[k, c] + h * h * ((0.5 - scheme.beta) * x0 + scheme.beta * x)
            )
            work.v[k, c] = bars.v[k, c] + h * ((1.0 - scheme.gamma) * x0 + scheme.gamma * x)
    right, values, rows, columns, at = work.right, blocks.values, blocks.rows, blocks.columns, blocks.segments
    right[:] = 0.0
    times(values, rows, columns, at[1], -1.0, work.q, right)  # (M a)_q
    times(values, rows, columns, at[2], 1.0, work.q, right)  # S_q
    times(values, rows, columns, at[4], 1.0, work.q, right)  # Q_q
    times(values, rows, columns, at[6], -1.0, work.q, right)  # (Φ_qᵀλ)_q
    times(values, rows, columns, at[3], 1.0, work.v, right)  # S_v
    times(values, rows, columns, at[5], 1.0, work.v, right)  # Q_v
    by_numbers(blocks, 1, -1.0, bars.b, right)  # (Φ_qᵀλ)_b
    by_numbers(blocks, 4, -1.0, bars.b, right)  # (M a)_b
    by_numbers(blocks, 5, 1.0, bars.b, right)  # S_b
    by_numbers(blocks, 6, 1.0, bars.b, right)  # Q_b
    below = right[nq:]
    times(values, rows, columns, at[8], -1.0, work.q, below)  # Φ_q
    by_numbers(blocks, 0, -1.0, bars.b, below)  # Φ_b
    for k in range(m):
        for c in range(width):
            below[k, c] /= beta
    if len(sources.step) > 0:
        for k in range(nq + m):
            for c in range(width):
                right[k, c] -= sources.step[n, k, c]
    for k in range(m):
        if views.left_out[k] > 0.0:
            for c in range(width):
                below[k, c] = 0.0
    if not solve_columns(matrix.placed, right, work.solution, work.room) <= work.trusted[0]:
        return False
    for k in range(nq):
        for c in range(width):
            change = work.solution[k, c]
            bars.a[k, c] = change
            bars.x[k, c] = kappa * change + work.x[k, c]
            bars.v[k, c] = gamma * change + work.v[k, c]
            bars.q[k, c] = beta * change + work.q[k, c]
    for k in range(m):
        for c in range(width):
            bars.lam[k, c] = work.solution[nq + k, c]
    return True


def backward_step(
    scheme: Any, entries: Any, b: Any, record: Any, n: Any, matrix: Any, blocks: Any, views: Any, work: Any,
    bars: Any, kept: Any, sources: Any,
) -> Any:  # fmt: skip
    """From the gradients by the end of step n to those by its start; false if pivots must be renewed."""
    if not linearize(scheme, entries, b, record, n, matrix, views):
        return False
    h, kappa = record.h[n], (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    beta, gamma = weights_of(scheme, h)
    nq, m, width = bars.q.shape[0], bars.lam.shape[0], bars.q.shape[1]
    right, mu = work.right, work.solution
    for k in range(nq):
        for c in range(width):
            right[k, c] = bars.a[k, c] + kappa * bars.x[k, c] + gamma * bars.v[k, c] + beta * bars.q[k, c]
    for k in range(m):
        for c in range(width):
            right[nq + k, c] = bars.lam[k, c]
    if len(sources.step) > 0:
        for k in range(nq + m):
            right[k, 0] -= sources.step[n, k]
    if not solve_columns_transposed(matrix.placed, right, mu, work.room) <= work.trusted[0]:
        return False
    bars.lam[:] = 0.0
    if len(sources.step) > 0:
        for k in range(nq):
            bars.q[k, 0] -= sources.step_q[n, k]
            bars.v[k, 0] -= sources.step_v[n, k]
    for k in range(m):
        if views.left_out[k] > 0.0:
            for c in range(width):
                mu[nq + k, c] = 0.0
    if len(kept.step) > 0:
        copy(mu, kept.step[n])
    below = right[nq:]
    for k in range(m):
        for c in range(width):
            below[k, c] = -mu[nq + k, c] / beta
    by_numbers_transposed(blocks, 1, -1.0, mu, bars.b)  # (Φ_qᵀλ)_b
    by_numbers_transposed(blocks, 4, -1.0, mu, bars.b)  # (M a)_b
    by_numbers_transposed(blocks, 5, 1.0, mu, bars.b)  # S_b
    by_numbers_transposed(blocks, 6, 1.0, mu, bars.b)  # Q_b
    by_numbers_transposed(blocks, 0, 1.0, below, bars.b)  # Φ_b
    values, rows, columns, at = blocks.values, blocks.rows, blocks.columns, blocks.segments
    times(values, columns, rows, at[1], -1.0, mu, bars.q)  # (M a)_q
    times(values, columns, rows, at[2], 1.0, mu, bars.q)  # S_q
    times(values, columns, rows, at[4], 1.0, mu, bars.q)  # Q_q
    times(values, columns, rows, at[6], -1.0, mu, bars.q)  # (Φ_qᵀλ)_q
    times(values, columns, rows, at[8], 1.0, below, bars.q)  # Φ_q
    times(values, columns, rows, at[3], 1.0, mu, bars.v)  # S_v
    times(values, columns, rows, at[5], 1.0, mu, bars.v)  # Q_v
    share_m, share_f = scheme.alpha_m / (1.0 - scheme.alpha_m), scheme.alpha_f / (1.0 - scheme.alpha_m)
    for k in range(nq):
        for c in range(width):
            by_q, by_v = bars.q[k, c], bars.v[k, c]
            by_x = bars.x[k, c] + h * h * scheme.beta * by_q + h * scheme.gamma * by_v
            bars.v[k, c] = by_v + h * by_q
            start = h * h * (0.5 - scheme.beta) * by_q + h * (1.0 - scheme.gamma) * by_v
            bars.x[k, c] = start - share_m * by_x
            bars.a[k, c] = share_f * by_x
    return True


def defect_change(
    entries: Any, b: Any, record: Any, n: Any, matrix: Any, blocks: Any, views: Any, work: Any
) -> Any:
    """Factor [M, Φ_qᵀ; Φ_q, 0] before step n, and evaluate the derivatives of s and σ; false for new pivots.

    M s + Φ_qᵀσ = 0, Φ_q s = d = Φ_q v + Φ_t. Derivatives: of the first line (M s)_q + (Φ_qᵀσ)_q, of the second line
    less d: -G with G = (Φ_q (v - s))_q + Φ_tq = -½ γ_v(q, v - s).
    """
    t, q, v, a, lam = record.t[n], record.q[n], record.v[n], record.a[n], record.lam[n]
    if not factor(entries, b, t, q, v, a, lam, matrix, 0.0, 0.0):
        return False
    nq, m = len(q), len(lam)
    rate, Phi_t, single = work.defect, work.Phi_t, work.single
    VELOCITY(entries.velocity, b, t, q, v, rate, Phi_t)
    right, found, room = single[0], single[1], single[2:]
    for k in range(nq):
        right[k, 0] = 0.0
    for k in range(m):
        right[nq + k, 0] = (rate[k] + Phi_t[k]) * (1.0 - views.left_out[k])
    if not solve_columns(matrix.placed, right, found, room) <= work.trusted[0]:
        return False
    s, sigma = work.s, work.sigma
    for k in range(nq):
        s[k] = found[k, 0]
    for k in range(m):
        sigma[k] = found[nq + k, 0]
    JACOBIAN(entries.jacobian, b, t, q, sigma, views.Phi_q, views.Phi_qT_lam_q)
    INERTIA(entries.inertia, b, q, v, s, views.M, views.M_a_q, views.S_q, views.S_v)
    leave_out(matrix.Phi_q, matrix.row_of, matrix.left_out)
    PHI_QT_LAM_B(entries.Phi_qT_lam_b, b, t, q, sigma, views.Phi_qT_lam_b)
    M_A_B(entries.M_a_b, b, q, s, views.M_a_b)
    for k in range(nq):
        s[k] = v[k] - s[k]
    GAMMA_V(entries.gamma_v, b, t, q, s, blocks.gamma_v)
    PHI_Q_XI_B(entries.Phi_q_xi_b, b, t, q, s, views.Phi_q_xi_b)
    PHI_T_B(entries.Phi_t_b, b, t, q, views.Phi_t_b)
    return True


def forward_rescale(
    entries: Any, b: Any, record: Any, n: Any, matrix: Any, blocks: Any, views: Any, work: Any,
    bars: Any, kept: Any, sources: Any,
) -> Any:  # fmt: skip
    """The change of the state by the new step size of step n; false if pivots must be renewed."""
    nq, m, width = len(work.s), len(work.sigma), bars.q.shape[1]
    if record.removed[n] != 0.0:
        if not defect_change(entries, b, record, n, matrix, blocks, views, work):
            return False
        right, values, rows, columns, at = (
            work.right, blocks.values, blocks.rows, blocks.columns, blocks.segments,
        )  # fmt: skip
        right[:] = 0.0
        below = right[nq:]
        times(values, rows, columns, at[1], -1.0, bars.q, right)
        times(values, rows, columns, at[6], -1.0, bars.q, right)
        by_numbers(blocks, 1, -1.0, bars.b, right)
        by_numbers(blocks, 4, -1.0, bars.b, right)
        turned = (blocks.gamma_v, blocks.gamma_v_rows, blocks.gamma_v_columns)
        times(turned[0], turned[1], turned[2], blocks.gamma_v_segment, -0.5, bars.q, below)
        times(values, rows, columns, at[8], 1.0, bars.v, below)
        by_numbers(blocks, 2, 1.0, bars.b, below)
        by_numbers(blocks, 3, 1.0, bars.b, below)
        if len(sources.rescale) > 0:
            for k in range(nq + m):
                for c in range(width):
                    right[k, c] -= sources.rescale[n, k, c]
        for k in range(m):
            if views.left_out[k] > 0.0:
                for c in range(width):
                    right[nq + k, c] = 0.0
        if not solve_columns(matrix.placed, right, work.solution, work.room) <= work.trusted[0]:
            return False
        if len(kept.rescale) > 0:
            copy(work.solution, kept.rescale[n])
        for k in range(nq):
            for c in range(width):
                bars.v[k, c] -= record.removed[n] * work.solution[k, c]
    if n > 0:
        ratio = record.h[n] / record.h[n - 1]
        for k in range(nq):
            for c in range(width):
                bars.x[k, c] = bars.a[k, c] + ratio * (bars.x[k, c] - bars.a[k, c])
    return True


def backward_rescale(
    entries: Any, b: Any, record: Any, n: Any, matrix: Any, blocks: Any, views: Any, work: Any,
    bars: Any, kept: Any, sources: Any,
) -> Any:  # fmt: skip
    """From the gradients by the state after the new step size of step n to those before; false for new pivots."""
    nq, m, width = len(work.s), len(work.sigma), bars.q.shape[1]
    if record.removed[n] != 0.0:
        if not defect_change(entries, b, record, n, matrix, blocks, views, work):
            return False
        right, z = work.right, work.solution
        for k in range(nq):
            for c in range(width):
                right[k, c] = -record.removed[n] * bars.v[k, c]
        for k in range(m):
            for c in range(width):
                right[nq + k, c] = 0.0
        if len(sources.rescale) > 0:
            for k in range(nq + m):
                right[k, 0] -= sources.rescale[n, k]
        if not solve_columns_transposed(matrix.placed, right, z, work.room) <= work.trusted[0]:
            return False
        if len(sources.rescale) > 0:
            for k in range(nq):
                bars.q[k, 0] -= sources.rescale_q[n, k]
                bars.v[k, 0] -= sources.rescale_v[n, k]
        for k in range(m):
            if views.left_out[k] > 0.0:
                for c in range(width):
                    z[nq + k, c] = 0.0
        if len(kept.rescale) > 0:
            copy(z, kept.rescale[n])
            for k in range(nq + m):
                kept.s[n, k] = work.single[1][k, 0]
        values, rows, columns, at, below = (
            blocks.values, blocks.rows, blocks.columns, blocks.segments, z[nq:],
        )  # fmt: skip
        times(values, columns, rows, at[1], -1.0, z, bars.q)
        times(values, columns, rows, at[6], -1.0, z, bars.q)
        by_numbers_transposed(blocks, 1, -1.0, z, bars.b)
        by_numbers_transposed(blocks, 4, -1.0, z, bars.b)
        turned = (blocks.gamma_v, blocks.gamma_v_rows, blocks.gamma_v_columns)
        times(turned[0], turned[2], turned[1], blocks.gamma_v_segment, -0.5, below, bars.q)
        times(values, columns, rows, at[8], 1.0, below, bars.v)
        by_numbers_transposed(blocks, 2, 1.0, below, bars.b)
        by_numbers_transposed(blocks, 3, 1.0, below, bars.b)
    if n > 0:
        ratio = record.h[n] / record.h[n - 1]
        for k in range(nq):
            for c in range(width):
                bars.a[k, c] += (1.0 - ratio) * bars.x[k, c]
                bars.x[k, c] *= ratio
    return True


def add_gradients(given: Any, row: Any, bars: Any) -> None:
    """Add what responses take from one node."""
    for k in range(bars.q.shape[0]):
        for c in range(bars.q.shape[1]):
            bars.q[k, c] += given.q[row, k, c]
            bars.v[k, c] += given.v[row, k, c]
            bars.a[k, c] += given.a[row, k, c]
    for k in range(bars.lam.shape[0]):
        for c in range(bars.lam.shape[1]):
            bars.lam[k, c] += given.lam[row, k, c]


def remember(record: Any, n: Any, views: Any, b: Any) -> None:
    """What elements remembered during step n, and which equations were left out."""
    for k in range(len(record.places)):
        b[record.places[k]] = record.memory[n, k]
    if len(record.left_out) > 0:
        for k in range(len(views.left_out)):
            views.left_out[k] = record.left_out[n + 1, k]


def backward(
    scheme: Any, entries: Any, b: Any, record: Any, n: Any, first: Any, stage: Any, matrix: Any,
    blocks: Any, views: Any, work: Any, bars: Any, given: Any, kept: Any, sources: Any,
) -> Any:  # fmt: skip
    """From the end of step n to the start of step `first`; returns (n, stage) of what needs new pivots.

    `given` holds the gradients of responses by the ends of the steps, one row for each.
    """
    while n >= first:
        remember(record, n, views, b)
        if stage == GRADIENTS:
            add_gradients(given, n - first, bars)
            stage = STEP
        if stage == STEP:
            if not backward_step(
                scheme, entries, b, record, n, matrix, blocks, views, work, bars, kept, sources
            ):
                return n, STEP
            stage = RESCALE
        if not backward_rescale(entries, b, record, n, matrix, blocks, views, work, bars, kept, sources):
            return n, RESCALE
        n, stage = n - 1, GRADIENTS
    return n, GRADIENTS


def forward(
    scheme: Any, entries: Any, b: Any, record: Any, n: Any, last: Any, stage: Any, matrix: Any,
    blocks: Any, views: Any, work: Any, bars: Any, given: Any, kept: Any, sources: Any,
) -> Any:  # fmt: skip
    """From the start of step n to that of step `last`; returns (n, stage) of what needs new pivots.

    `given` takes the derivatives, one row for each step.
    """
    start = last - len(given.q)
    while n < last:
        remember(record, n, views, b)
        if stage == RESCALE:
            if not forward_rescale(entries, b, record, n, matrix, blocks, views, work, bars, kept, sources):
                return n, RESCALE
            stage = STEP
        if not forward_step(scheme, entries, b, record, n, matrix, blocks, views, work, bars, sources):
            return n, STEP
        row = n - start
        for k in range(bars.q.shape[0]):
            for c in range(bars.q.shape[1]):
                given.q[row, k, c], given.v[row, k, c] = bars.q[k, c], bars.v[k, c]
                given.a[row, k, c] = bars.a[k, c]
        for k in range(bars.lam.shape[0]):
            for c in range(bars.lam.shape[1]):
                given.lam[row, k, c] = bars.lam[k, c]
        n, stage = n + 1, RESCALE
    return n, RESCALE
