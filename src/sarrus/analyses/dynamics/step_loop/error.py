"""The error of a step, and the length of the next one."""

from __future__ import annotations

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.paired_matrix import solve_real
from ..dense_output.sample_loop import REFINEMENTS, MotionSolver, solve_motion
from ..dense_output.sample_loop import factor as factor_motion
from ..methods.program import ERROR, MOMENTUM, OF_EQUATIONS, UPDATE, Program
from ..methods.tables import STIFFNESS
from ..stepping.motion_scale import Tolerance
from .coefficients import apply
from .equations import TRUSTED, evaluate, factored, size, size_of_change
from .records import Control, Entries, Matrix, Memory, Run, State

INFINITE = 1e300
PRECISE = 1e-4  # pivot over column, above which a and λ need no refinement
LEAST_ERROR = 1e-8  # smaller ones are taken to be this
HERMITE = 64.0  # a change of the acceleration at an end by e moves the quintic by e h² / HERMITE at most


@compiled
def accelerations(motion: MotionSolver, b: Array, t: float, state: State) -> bool:
    """a and λ of the equations of motion after a step; false if pivots must be renewed."""
    for k in range(len(state.a1)):
        state.a1[k] = state.a0[k]
    for k in range(len(state.lam1)):
        state.lam1[k] = state.lam0[k]
    trust = factor_motion(motion.entries, b, t, state.q1, motion.matrix)
    if not trust > TRUSTED:
        return False
    rounds = 1 if trust > PRECISE else REFINEMENTS
    solve_motion(motion, b, t, state.q1, state.v1, state.a1, state.lam1, rounds)
    return True


@compiled
def local_error(run: Run, t: float, h: float, again: bool, renewed: bool) -> float:
    """Size of the error of a step, over the tolerances; less than 0 if pivots must be renewed.

    `renewed`: whether the matrix has been renewed within the step.
    """
    program, state, tol = run.program, run.state, run.tol
    apply(program, UPDATE, state)
    if len(program.filtered) > 0:
        error = filtered_error(program, run.entries, run.b, state, run.memory, run.matrix, tol, again)
        if renewed and error <= 1.0 and unfiltered_error(program, h, state, tol) > 1.0:
            other = error_from_start(run, t, h, again)
            error = max(error, other) if other >= 0.0 else other
        return error
    if not program.own_accelerations and not accelerations(run.motion, run.b, t, state):
        return -1.0
    if program.estimated:
        apply(program, ERROR, state)
    else:
        leading_term(program, h, state)
    estimate, k = state.x[program.error : program.error + len(state.q0)], program.exponent
    error = size(estimate, 1.0, state.q0, state.q1, tol.rtol_q, tol.atol_q)
    if tol.speed > 0.0:
        speed = size(estimate, 1.0 / h, state.v0, state.v1, tol.rtol_v, tol.atol_v)
        error = max(error, speed ** (k / (k - 1.0)))  # it falls with one power of h less
    return error


@compiled
def smooth(program: Program, h: float, state: State, tol: Tolerance, node: Array) -> None:
    """Accelerations between which states are interpolated: of the equations of motion, which are the most accurate.

    Where a stiff force on a light body makes them useless, they are those of the last stage.
    """
    for k in range(len(state.a1)):
        allowed, slope = tol.atol_q[k] + tol.rtol_q[k] * abs(state.q1[k]), state.x[program.end_slope + k]
        if not h * h * abs(state.a1[k] - slope) <= HERMITE * allowed:
            state.a1[k] = node[k] = slope


@compiled
def filtered_error(
    program: Program, entries: Entries, b: Array, state: State, memory: Memory, matrix: Matrix, tol: Tolerance,
    again: bool,
) -> float:  # fmt: skip
    """Size of the error by a `FilteredEstimate`; one that is too large is filtered `again`, for stiff beginnings."""
    n, x, r, of = len(state.q0), state.x, state.r, program.filtered
    apply(program, ERROR, state)
    for k in range(n):
        x[program.error + k] *= memory.unit[k] * r[of[2]]
        x[program.error + n + k] *= r[of[3]]
    error = solve_for_error(program, entries, b, state, memory, matrix, tol)
    if again and error >= 1.0:
        for k in range(n):
            x[program.error + k] = memory.unit[k] * r[of[0]] * memory.real_solution[of[6] + k]
            x[program.error + n + k] = r[of[1]] * memory.real_solution[of[7] + k]
        error = solve_for_error(program, entries, b, state, memory, matrix, tol)
    return error


@compiled
def unfiltered_error(program: Program, h: float, state: State, tol: Tolerance) -> float:
    """The same without forces that vary with the state."""
    n, x, r, of = len(state.q0), state.x, state.r, program.filtered
    apply(program, ERROR, state)
    in_q, in_v = x[program.error : program.error + n], x[program.error + n : program.error + 2 * n]
    return max(
        size(in_q, abs(r[of[2]] / r[of[0]]), state.q0, state.q1, tol.rtol_q, tol.atol_q),
        size(in_v, abs(r[of[3]] / r[of[1]]) / h, state.v0, state.v1, tol.rtol_v, tol.atol_v),
    )


@compiled
def error_from_start(run: Run, t: float, h: float, again: bool) -> float:
    """The filtered error with the stiffness at the begin of the step, as in Hairer and Wanner (IV.8.19).

    With that of a contact in which a flight ends, the filter removes the error of the whole step.
    """
    program, entries, b, state, matrix = run.program, run.entries, run.b, run.state, run.matrix
    for n in range(len(program.operators)):
        row = program.operators[n]
        if row[0] == STIFFNESS:
            first, last = entries.bounds[OF_EQUATIONS + row[0]], entries.bounds[OF_EQUATIONS + row[0] + 1]
            kernels = KernelTable(
                entries.addresses[first:last], entries.starts[first : last + 1], entries.tables
            )
            one, two = matrix.values[row[5] : row[6]], matrix.values[row[7] : row[8]]
            call_kernels(kernels, b, t - h, state.q0, state.v0, one, two)
    if not factored(program, matrix):
        return -1.0
    error = filtered_error(program, entries, b, state, run.memory, matrix, run.tol, again)
    evaluate(program, entries, b, t, h, state.x, matrix.values, matrix.left_out)
    return error if factored(program, matrix) else -1.0


@compiled
def solve_for_error(
    program: Program, entries: Entries, b: Array, state: State, memory: Memory, matrix: Matrix, tol: Tolerance
) -> float:
    """Solve for the error of a step; returns its size."""
    n, x, of, M_a, S = (
        len(state.q0),
        state.x,
        program.filtered,
        program.inertia,
        program.inertia + len(state.q0),
    )
    first, end, a = entries.bounds[MOMENTUM], entries.bounds[MOMENTUM + 1], x[program.error + n :]
    kernels = KernelTable(entries.addresses[first:end], entries.starts[first : end + 1], entries.tables)
    call_kernels(kernels, b, state.q0, state.v0, a, x[M_a : M_a + n], x[S : S + n])
    memory.real[:] = 0.0
    for k in range(n):
        memory.real[of[4] + k] = x[program.error + k]
        memory.real[of[5] + k] = x[M_a + k]
    solve_real(matrix.pair, memory.real, memory.real_solution)
    last = program.change + program.n - len(memory.real)
    for k in range(len(memory.real)):
        x[last + k] = memory.real_solution[k]
    return size_of_change(program, state, tol)


@compiled
def leading_term(program: Program, h: float, state: State) -> None:
    """Constant times h^k q^(k), by the divided difference of the accelerations at the last k - 1 nodes.

    Before there are so many of them, a lower derivative, with its power of h, is taken: it is the greater term.
    """
    x, first, count = state.x, program.error, 0
    while count < len(state.past) and state.past[count] < INFINITE:
        count += 1
    factor = program.constant * h ** (count + 2.0)
    for k in range(2, count + 1):
        factor *= k
    for i in range(-1, count):
        time, weight = (h if i < 0 else -state.past[i]), factor
        for j in range(-1, count):
            if j != i:
                weight /= time - (h if j < 0 else -state.past[j])
        for k in range(len(state.q0)):
            a = state.a1[k] if i < 0 else state.past_a[i, k]
            x[first + k] = weight * a + (x[first + k] if i >= 0 else 0.0)


@compiled
def factor_to(program: Program, error: float, iterations: int) -> float:
    """By how much a step may be longer than one with this error."""
    safety, n = program.lengths.safety, 2.0 * program.lengths.iterations
    if n > 0.0:
        safety *= (1.0 + n) / (iterations + n)
    return float(safety * max(error, LEAST_ERROR) ** (-1.0 / program.exponent))


@compiled
def next_length(program: Program, h: float, wanted: float, error: float, control: Control) -> float:
    """The length of the step after an accepted one of length h, see `StepLengths`."""
    rule = program.lengths
    if rule.predictive and control.last_h > 0.0:
        fall = max(control.last_error, 1e-2) / max(error, LEAST_ERROR) ** 2
        wanted = min(wanted, rule.safety * (h / control.last_h) * fall ** (1.0 / program.exponent))
    if rule.predictive and control.rejected_since > 0:
        wanted = min(wanted, 1.0)
    if wanted < rule.below:
        return h * max(wanted, rule.shrink)
    return max(control.h, h * min(wanted, rule.grow)) if wanted > rule.above else control.h


@compiled
def finish(program: Program, motion: MotionSolver, b: Array, t: float, state: State, polished: bool) -> bool:
    """The state after an accepted step, as far as it is not known; false if pivots must be renewed."""
    if polished:
        apply(program, UPDATE, state)
    needed = (polished or len(program.filtered) > 0) and not program.own_accelerations
    return not needed or accelerations(motion, b, t, state)
