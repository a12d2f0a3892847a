"""The time loop of Radau IIA on the stabilized index-2 equations, compiled: many steps for one call from Python.

Unknowns are the increments of q and v from the start of the step to its three stages, and λ and μ at the stages.
Simplified Newton: with W = T⁻¹ Z the 3 N equations of a step fall apart into N real and N complex ones,

    [ W                   -W            0     Φ_qᵀ ] [ w_q     ]
    [ (...)_q / s²    M + (...)_v / s   Φ_qᵀ  0    ] [ w_v / s ]
    [ Φ_q                  0            0     0    ] [ w_λ / s²]
    [ (Φ_q v + Φ_t)_q / s  Φ_q          0     0    ] [ w_μ / s ],     s = (γ or α + i β) / h,

scaled so that their condition does not depend on h.
"""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.kernels.pointer import Entry, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.block_matrix import Placed, backsolve, leave_out, refactor
from ..stepping.alpha_loop import FINISHED, REPIVOT, RUNNING, TOO_SMALL, TRUSTED, remember
from ..stepping.alpha_loop import evaluate as evaluate_index_3
from ..stepping.motion_scale import Tolerance, follow_motion
from ..stepping.stabilized_matrix import weigh
from ..stepping.step_control import StepControl

PRECISE = 1e-4  # the same where a and λ are solved for, whose round-off is not corrected by iterations
NEWTON_LIMIT = 10  # iterations
STALLED = 0.1  # of the tolerance: corrections that are smaller and no longer fall are round-off
REPEATED = 1.0  # the same where equations repeat others, whose combination may be weak
SLOW = 0.03  # contraction above which the matrices are renewed for the next step
SAFETY, SHRINK, GROW = 0.9, 0.2, 8.0
HERMITE = 64.0  # a change of the acceleration at an end by e moves the quintic by e h² / HERMITE at most
KEEP = 1.2  # the step and the factors are not changed for less than this


class Scheme(NamedTuple):
    """Nodes c, A⁻¹, the transformation T and its inverse, eigenvalues γ and α + iβ, weights of the error estimate."""

    c: Array
    inverse: Array
    T: Array
    T_inverse: Array
    gamma: float
    pair: complex
    error: Array


class State(NamedTuple):
    """Arrays at the start of a step (0), at its three stages, their increments, and those of the step before."""

    q0: Array
    v0: Array
    a0: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    mu: Array
    zq: Array
    zv: Array
    zq_before: Array
    zv_before: Array
    lam_before: Array


class Memory(NamedTuple):
    """Operators' outputs and work arrays; `unit` is W, see `kinematic_weights`."""

    Phi: Array
    Phi_qT_lam: Array
    Phi_qT_mu: Array
    M_a: Array
    S: Array
    Q: Array
    rate: Array
    Phi_t: Array
    gamma: Array
    residual: Array
    real: Array
    real_solution: Array
    pair: Array
    pair_solution: Array
    right: Array
    solution: Array
    end: Array
    unit: Array


class Matrices(NamedTuple):
    """The numbers of all operators, and the three matrices: of both Newton systems, and of the accelerations."""

    values: Array
    Phi_q: Array
    Phi_qT_lam_q: Array
    M: Array
    M_a_q: Array
    S_q: Array
    S_v: Array
    Q_q: Array
    Q_v: Array
    gamma_v: Array
    row_of: Array
    left_out: Array
    real: Placed
    pair: Placed
    motion: Placed


class Indices(NamedTuple):
    """Index tables of the operator groups."""

    residual: Entry
    momentum: Entry
    force: Entry
    velocity: Entry
    jacobian: Entry
    inertia: Entry
    stiffness: Entry
    turning: Entry
    bending: Entry
    remember: Entry


class Control(StepControl):
    """See `StepControl`.

    Attributes
    ----------
    last_error : the estimated error of the last step, relative to the tolerance
    stages_h : the length of step that the stages belong to [s]; 0 where there are none
    factored_h : the length of step that the factors belong to [s]; 0 where they are to be renewed
    old_matrices : whether the matrices are those of an earlier step
    new_pivots : whether the order of the pivots was chosen since the last step
    """

    last_error: float
    stages_h: float
    factored_h: float
    old_matrices: bool
    new_pivots: bool


class Record(NamedTuple):
    """Accepted steps, row by row, as many as the buffers hold.

    t, h : end and length of each
    q, v, a, lam : the state at its end, with the accelerations of the equations of motion
    memory : what elements remember there
    error, iterations, rejected : its error (1 is the tolerance), Newton iterations, and the steps rejected before it
    stage_q, stage_v, stage_lam, stage_mu : the stages, if there are buffers for them
    given : lengths to take, without error control (none: chosen to meet the tolerances)
    """

    t: Array
    h: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    memory: Array
    error: Array
    iterations: Array
    rejected: Array
    stage_q: Array
    stage_v: Array
    stage_lam: Array
    stage_mu: Array
    given: Array


@compiled
def stages(scheme: Scheme, h: float, state: State) -> None:
    """q, v and a at the stages, of their increments."""
    for i in range(3):
        for k in range(len(state.q0)):
            state.q[i, k] = state.q0[k] + state.zq[i, k]
            state.v[i, k] = state.v0[k] + state.zv[i, k]
            slope = 0.0
            for j in range(3):
                slope += scheme.inverse[i, j] * state.zv[j, k]
            state.a[i, k] = slope / h


@compiled
def residual(
    scheme: Scheme, index: Indices, b: Array, t0: float, h: float, state: State, memory: Memory,
    left_out: Array,
) -> None:  # fmt: skip
    """[W (q' - v) + Φ_qᵀμ; M a + Φ_qᵀλ - Q - S; Φ; Φ_q v + Φ_t] at every stage."""
    n, m = len(state.q0), len(left_out)
    stages(scheme, h, state)
    for i in range(3):
        t, q, v = t0 + scheme.c[i] * h, state.q[i], state.v[i]
        call_kernels(index.residual, b, t, q, state.mu[i], memory.Phi, memory.Phi_qT_mu)
        call_kernels(index.residual, b, t, q, state.lam[i], memory.Phi, memory.Phi_qT_lam)
        call_kernels(index.momentum, b, q, v, state.a[i], memory.M_a, memory.S)
        call_kernels(index.force, b, t, q, v, memory.Q)
        call_kernels(index.velocity, b, t, q, v, memory.rate, memory.Phi_t)
        for k in range(n):
            slope = 0.0
            for j in range(3):
                slope += scheme.inverse[i, j] * state.zq[j, k]
            memory.residual[i, k] = memory.unit[k] * (slope / h - v[k]) + memory.Phi_qT_mu[k]
            memory.residual[i, n + k] = memory.M_a[k] + memory.Phi_qT_lam[k] - memory.Q[k] - memory.S[k]
        for k in range(m):
            stored = 1.0 - left_out[k]
            memory.residual[i, 2 * n + k] = stored * memory.Phi[k]
            memory.residual[i, 2 * n + m + k] = stored * (memory.rate[k] + memory.Phi_t[k])


@compiled
def evaluate(
    index: Indices, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, matrices: Matrices
) -> None:
    """All derivatives at one state."""
    evaluate_index_3(index, b, t, q, v, a, lam, matrices)  # type: ignore[arg-type]
    call_kernels(index.turning, b, t, q, v, matrices.gamma_v)


@compiled
def factor(scheme: Scheme, h: float, matrices: Matrices) -> float:
    """Factor the real and the complex Newton matrix of the derivatives at hand; returns their lesser trust."""
    s, pair = scheme.gamma / h, scheme.pair / h
    weigh(matrices.real.weights, 1.0 / (s * s), 1.0 / s)
    weigh(matrices.pair.weights, 1.0 / (pair * pair), 1.0 / pair)
    return min(refactor(matrices.values, matrices.real), refactor(matrices.values, matrices.pair))


@compiled
def scaled(right: Array, n: int, m: int, s: complex) -> None:
    """The right side of a Newton system, its rows scaled as those of the matrix."""
    for k in range(n):
        right[k] /= s
        right[n + k] /= s * s
    for k in range(m):
        right[2 * n + m + k] /= s


@compiled
def unscaled(solution: Array, n: int, m: int, s: complex) -> None:
    """Back from w_v / s, w_λ / s², w_μ / s."""
    for k in range(n):
        solution[n + k] *= s
    for k in range(m):
        solution[2 * n + k] *= s * s
        solution[2 * n + m + k] *= s


@compiled
def size(change: Array, q: Array, v: Array, tol: Tolerance) -> float:
    """Root mean square of the changes of q and of v, the greater; each entry over its tolerance."""
    n, in_q, in_v = len(q), 0.0, 0.0
    for k in range(n):
        in_q += (change[k] / (tol.atol_q[k] + tol.rtol_q[k] * abs(q[k]))) ** 2
        in_v += (change[n + k] / (tol.atol_v[k] + tol.rtol_v[k] * abs(v[k]))) ** 2
    return float((max(in_q, in_v) / n) ** 0.5 + 0.0 * (in_q + in_v))  # max may hide what is not a number


@compiled
def improve(
    scheme: Scheme, h: float, state: State, memory: Memory, matrices: Matrices, tol: Tolerance
) -> float:
    """One Newton step for all stages; returns its size."""
    n, m, T, back = len(state.q0), len(matrices.left_out), scheme.T, scheme.T_inverse
    for k in range(2 * (n + m)):
        r0, r1, r2 = memory.residual[0, k], memory.residual[1, k], memory.residual[2, k]
        memory.real[k] = back[0, 0] * r0 + back[0, 1] * r1 + back[0, 2] * r2
        memory.pair[k] = (back[1, 0] * r0 + back[1, 1] * r1 + back[1, 2] * r2) + 1j * (
            back[2, 0] * r0 + back[2, 1] * r1 + back[2, 2] * r2
        )
    scaled(memory.real, n, m, scheme.gamma / h)
    scaled(memory.pair, n, m, scheme.pair / h)
    backsolve(matrices.real, memory.real, memory.real_solution)
    backsolve(matrices.pair, memory.pair, memory.pair_solution)
    unscaled(memory.real_solution, n, m, scheme.gamma / h)
    unscaled(memory.pair_solution, n, m, scheme.pair / h)
    largest = 0.0
    for i in range(3):
        for k in range(2 * (n + m)):
            w = memory.pair_solution[k]
            memory.residual[i, k] = T[i, 0] * memory.real_solution[k] + T[i, 1] * w.real + T[i, 2] * w.imag
        one = size(memory.residual[i], state.q0, state.v0, tol)
        largest = max(largest, one) + 0.0 * one
        for k in range(n):
            state.zq[i, k] -= memory.residual[i, k]
            state.zv[i, k] -= memory.residual[i, n + k]
        for k in range(m):
            state.lam[i, k] -= memory.residual[i, 2 * n + k]
            state.mu[i, k] -= memory.residual[i, 2 * n + m + k]
    return largest


@compiled
def newton(
    scheme: Scheme, index: Indices, b: Array, t: float, h: float, state: State, memory: Memory,
    matrices: Matrices, control: Control, tol: Tolerance, enough: float,
) -> tuple[int, float]:  # fmt: skip
    """Solve the stages of one step. Returns (iterations, contraction): no iterations if it fails."""
    before, rate = 0.0, 0.0
    for iteration in range(NEWTON_LIMIT):
        residual(scheme, index, b, t, h, state, memory, matrices.left_out)
        control.residuals += 3
        change = improve(scheme, h, state, memory, matrices, tol)
        if not change < 1e30:
            return 0, 2.0
        if iteration > 0:
            rate = max(0.5 * rate, change / before) if before > 0.0 else 0.0
            if rate >= 0.99 and change > (REPEATED if matrices.left_out.any() else STALLED):
                return 0, rate
            if rate >= 0.99:  # round-off, of which shorter steps make more: constraints are divided by h
                stages(scheme, h, state)
                return iteration + 1, SLOW
        if change <= 1e-3 * enough or (iteration > 0 and change * rate / (1.0 - rate) <= enough):
            stages(scheme, h, state)
            return iteration + 1, rate
        before = change
    return 0, 1.0


@compiled
def estimate(
    scheme: Scheme, index: Indices, b: Array, h: float, again: bool, state: State, memory: Memory,
    matrices: Matrices, tol: Tolerance,
) -> float:  # fmt: skip
    """Size of the error of a step; with `again` it is filtered twice, for stiff beginnings."""
    n, m, s = len(state.q0), len(matrices.left_out), scheme.gamma / h
    right, found = memory.real, memory.real_solution
    right[:] = 0.0
    for k in range(n):
        in_q, in_v = 0.0, 0.0
        for j in range(3):
            in_q += scheme.error[j] * state.zq[j, k]
            in_v += scheme.error[j] * state.zv[j, k]
        right[k] = memory.unit[k] * (in_q / h + state.v0[k]) / s
        memory.end[k] = (in_v / h + state.a0[k]) / (s * s)
    call_kernels(index.momentum, b, state.q0, state.v0, memory.end, memory.M_a, memory.S)
    copied(memory.M_a, right[n : 2 * n])
    backsolve(matrices.real, right, found)
    unscaled(found, n, m, s)
    error = size(found, state.q[2], state.v[2], tol)
    if again and error >= 1.0:
        right[:] = 0.0
        for k in range(n):
            right[k], memory.end[k] = memory.unit[k] * found[k], found[n + k] / s
        call_kernels(index.momentum, b, state.q0, state.v0, memory.end, memory.M_a, memory.S)
        copied(memory.M_a, right[n : 2 * n])
        backsolve(matrices.real, right, found)
        unscaled(found, n, m, s)
        error = size(found, state.q[2], state.v[2], tol)
    return error


@compiled
def copied(x: Array, to: Array) -> None:
    """Copy numbers."""
    for k in range(len(to)):
        to[k] = x[k]


@compiled
def lagrange(scheme: Scheme, j: int, x: float, with_zero: bool) -> float:
    """The polynomial that is 1 at the node c_j and 0 at the others (and at 0), at x."""
    c = scheme.c
    value = x / c[j] if with_zero else 1.0
    for i in range(3):
        if i != j:
            value *= (x - c[i]) / (c[j] - c[i])
    return value


@compiled
def predict(scheme: Scheme, ratio: float, state: State) -> None:
    """First guess of the stages: the polynomials of the last step go on; `ratio` is the new step over the last."""
    for i in range(3):
        state.zq[i], state.zv[i], state.lam[i], state.mu[i] = 0.0, 0.0, 0.0, 0.0
        x = 1.0 + ratio * scheme.c[i]
        for j in range(3):
            w = lagrange(scheme, j, x, True) - lagrange(scheme, j, 1.0, True)
            u = lagrange(scheme, j, x, False)
            for k in range(len(state.q0)):
                state.zq[i, k] += w * state.zq_before[j, k]
                state.zv[i, k] += w * state.zv_before[j, k]
            for k in range(state.lam.shape[1]):
                state.lam[i, k] += u * state.lam_before[j, k]


@compiled
def first_guess(scheme: Scheme, h: float, state: State) -> None:
    """The stages of the first step: v and a go on, and λ stays."""
    for i in range(3):
        x = scheme.c[i] * h
        for k in range(len(state.q0)):
            state.zq[i, k] = x * (state.v0[k] + 0.5 * x * state.a0[k])
            state.zv[i, k] = x * state.a0[k]
        copied(state.lam_before[2], state.lam[i])
        state.mu[i] = 0.0


@compiled
def accept(state: State) -> None:
    """The end of the step is the start of the next."""
    copied(state.q[2], state.q0)
    copied(state.v[2], state.v0)
    copied(state.a[2], state.a0)
    for i in range(3):
        copied(state.zq[i], state.zq_before[i])
        copied(state.zv[i], state.zv_before[i])
        copied(state.lam[i], state.lam_before[i])


@compiled
def motion(
    index: Indices, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, memory: Memory,
    matrices: Matrices,
) -> float:  # fmt: skip
    """a and λ of the equations of motion at a state; returns how far the pivots can be trusted."""
    n = len(q)
    call_kernels(index.bending, b, t, q, v, matrices.Phi_q, memory.gamma)
    leave_out(matrices.Phi_q, matrices.row_of, matrices.left_out)
    call_kernels(index.inertia, b, q, v, a, matrices.M, matrices.M_a_q, matrices.S_q, matrices.S_v)
    memory.solution[:] = 0.0
    call_kernels(index.momentum, b, q, v, memory.solution[:n], memory.M_a, memory.S)
    call_kernels(index.force, b, t, q, v, memory.Q)
    trust = refactor(matrices.values, matrices.motion)
    for k in range(n):
        memory.right[k] = memory.Q[k] + memory.S[k]
    for k in range(len(lam)):
        memory.right[n + k] = memory.gamma[k] * (1.0 - matrices.left_out[k])
    backsolve(matrices.motion, memory.right, memory.solution)
    copied(memory.solution[:n], a)
    copied(memory.solution[n:], lam)
    return trust


@compiled
def keep(record: Record, row: int, t: float, h: float, state: State, end: Array, control: Control) -> None:
    """Write an accepted step into the record."""
    record.t[row], record.h[row], record.rejected[row] = t, h, control.rejected_since
    copied(state.q[2], record.q[row])
    copied(state.v[2], record.v[row])
    copied(end, record.a[row])
    for i in range(3 if len(record.stage_q) > 0 else 0):
        copied(state.q[i], record.stage_q[row, i])
        copied(state.v[i], record.stage_v[row, i])
        copied(state.lam[i], record.stage_lam[row, i])
        copied(state.mu[i], record.stage_mu[row, i])


@compiled
def smooth(h: float, state: State, end: Array, tol: Tolerance) -> None:
    """Accelerations between which states are interpolated: of the equations of motion, which are the most accurate.

    Where a stiff force on a light body makes them useless, they are the slopes of the stages.
    """
    for k in range(len(end)):
        allowed = tol.atol_q[k] + tol.rtol_q[k] * abs(state.q[2, k])
        if not h * h * abs(end[k] - state.a[2, k]) <= HERMITE * allowed:
            end[k] = state.a[2, k]


@compiled(entry=True)
def advance(
    scheme: Scheme, index: Indices, b: Array, places: Array, until: float, limit: int, h_max: float,
    state: State, memory: Memory, matrices: Matrices, control: Control, record: Record, stored: bool,
    tol: Tolerance, enough: float,
) -> tuple[int, int]:  # fmt: skip
    """Take steps until a time, at most `limit` of them. Returns a status and how many were taken."""
    taken, rejected, free = 0, False, len(record.given) == 0
    while control.t < until and taken < limit and (free or taken < len(record.given)):
        t0, h = control.t, min(control.h, h_max) if free else record.given[taken]
        if free and t0 + 1.0001 * h >= until:
            h = until - t0
        elif free and t0 + 1.9 * h > until:  # two equal steps to the end
            h = 0.5 * (until - t0)
        if control.h <= 1e-14 * max(abs(t0), until - t0):
            return TOO_SMALL, taken
        follow_motion(tol, h, state.q0, state.v0, state.a0, control.last_h == 0.0)
        if control.stages_h > 0.0:
            predict(scheme, h / control.stages_h, state)
        else:
            first_guess(scheme, h, state)
        if control.factored_h != h:
            stages(scheme, h, state)  # the middle one, as predicted, represents all
            evaluate(
                index, b, t0 + scheme.c[1] * h, state.q[1], state.v[1], state.a[1], state.lam[1], matrices
            )
            control.matrices += 1
            if not factor(scheme, h, matrices) > TRUSTED:
                if not control.new_pivots:
                    control.h = h
                    return REPIVOT, taken
                if free:
                    control.h = 0.5 * h
                    continue
            control.factored_h, control.old_matrices = h, False
        iterations, rate = newton(scheme, index, b, t0, h, state, memory, matrices, control, tol, enough)
        if iterations == 0:
            control.rejected += 1
            control.rejected_since += 1
            if not control.old_matrices:
                control.h = 0.5 * h
                if not free:
                    return TOO_SMALL, taken
            control.factored_h = 0.0
            rejected = True
            continue
        first = rejected or control.last_h == 0.0
        error = estimate(scheme, index, b, h, first, state, memory, matrices, tol)
        error = max(error, 1e-10)
        safety = SAFETY * (1 + 2 * NEWTON_LIMIT) / (iterations + 2 * NEWTON_LIMIT)
        wanted = min(max(safety * error**-0.25, SHRINK), GROW) if error < 1e30 else SHRINK
        if free and not error < 1.0:
            control.rejected += 1
            control.rejected_since += 1
            control.h = h * (0.1 if control.last_h == 0.0 else wanted)
            rejected = True
            continue
        needed, end = TRUSTED if control.new_pivots else PRECISE, memory.end
        if (
            not motion(index, b, t0 + h, state.q[2], state.v[2], end, record.lam[taken], memory, matrices)
            > needed
        ):
            if not control.new_pivots:
                control.h, control.factored_h = h, 0.0
                return REPIVOT, taken
            if free:
                control.h = 0.5 * h
                continue
        if not stored:
            smooth(h, state, end, tol)
        if control.last_h > 0.0:  # Gustafsson's prediction
            trend = SAFETY * (h / control.last_h) * (control.last_error / (error * error)) ** 0.25
            wanted = min(max(min(wanted, trend), SHRINK), GROW)
        if rejected:
            wanted = min(wanted, 1.0)
        rejected = False
        ended = h == until - t0 if free else taken + 1 == len(record.given)
        control.t = until if ended else t0 + h
        keep(record, taken, control.t, h, state, end, control)
        record.error[taken], record.iterations[taken] = error, iterations
        remember(index, b, places, control.t, state.q[2], record.memory[taken])  # type: ignore[arg-type]
        accept(state)
        control.last_error, control.last_h, control.stages_h = max(error, 1e-2), h, h
        control.old_matrices, control.new_pivots = True, False
        control.steps += 1
        control.rejected_since = 0
        taken += 1
        if wanted < 1.0 or wanted > KEEP:
            control.h = h * wanted
        if rate > SLOW or iterations > 5:
            control.factored_h = 0.0
    return (FINISHED if control.t >= until else RUNNING), taken
