"""One step of any described method, compiled once for all: see `methods.program` for its tables and the work array x.

Step control, Newton's method and everything else that is not defined here (`advance`, `newton`, `polish`, ...) is that
of `alpha_loop`, compiled with these functions. The whole matrix of a step is assembled from the operators of its
equations.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...._jit.formulas.curves import (
    ACOS,
    ADD,
    ASIN,
    ATAN,
    CONSTANT,
    COS,
    DIV,
    EXP,
    INPUT,
    LOG,
    MUL,
    NEG,
    POSITIVE,
    SIN,
    SQRT,
    SUB,
    TAN,
)
from ...._jit.kernels.pointer import Entry, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.block_matrix import Placed, backsolve, refactor
from ..dense_output import sample_loop
from ..dense_output.sample_loop import REFINEMENTS, solve_motion, velocity_defect
from ..dense_output.sample_loop import factor as factor_motion
from ..methods.program import (
    BASE,
    CHANGE,
    CONTINUED,
    EQUATIONS,
    ERROR,
    GUESS,
    MOMENTUM,
    OF_EQUATIONS,
    RESIDUAL,
    STAGES,
    UPDATE,
    VELOCITY,
    Program,
)
from ..methods.tables import GAMMA_Q_V, INERTIA, JACOBIAN, STIFFNESS
from ..stepping.alpha_loop import SETTLED, TRUSTED, Control, size
from ..stepping.motion_scale import Tolerance

INFINITE = 1e300
PRECISE = 1e-4  # pivot over column, above which a and λ need no refinement
LEAST_ERROR = 1e-8  # smaller ones are taken to be this
HERMITE = 64.0  # a change of the acceleration at an end by e moves the quintic by e h² / HERMITE at most


class Entries(NamedTuple):
    """The kernels of all groups of operators one after another, see `_jit.kernels.pointer`.

    bounds : where those of each group begin: of the equations, in the order of `methods.program`, then of the matrix
    remember, motion : what elements remember, and the kernels of the equations of motion
    """

    addresses: Array
    starts: Array
    tables: Array
    bounds: Array
    remember: Entry
    motion: sample_loop.Entries


class State(NamedTuple):
    """The work array x and the registers r of a program; parts of x: the state before a step (0), and after it (1).

    v_given : velocities before a step, where those in x have a part of the defect of their constraints removed
    past, past_a : the last nodes, the newest first: how long before the step they are (infinite: there is none), and
        their accelerations; as many as the error estimate needs
    """

    x: Array
    r: Array
    q0: Array
    v0: Array
    a0: Array
    lam0: Array
    q1: Array
    v1: Array
    a1: Array
    lam1: Array
    v_given: Array
    past: Array
    past_a: Array


class Memory(NamedTuple):
    """Right side (in x) and solution of Newton's method; round-off of Φ; the removed defect (s, σ); W (nq,).

    real, pair : right sides and solutions of the systems of stages that are split
    """

    right: Array
    solution: Array
    noise: Array
    correction: Array
    unit: Array
    motion: sample_loop.Work
    real: Array
    real_solution: Array
    pair: Array
    pair_solution: Array


class Matrix(NamedTuple):
    """The values of all operators, the matrix of a step and its factors; that of the equations of motion.

    Where stages are split, the matrix of the real eigenvalue, and that of the pair.
    """

    values: Array
    left_out: Array
    placed: Placed
    pair: Placed
    motion: sample_loop.Matrix


class Record(NamedTuple):
    """Accepted steps, row by row: see `alpha_loop.Record`; `stages` are the quantities of all stages."""

    t: Array
    h: Array
    removed: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    correction: Array
    impulse: Array
    stages: Array
    memory: Array
    error: Array
    iterations: Array
    rejected: Array
    given: Array


@compiled
def formula(code: int, x: float, y: float) -> float:
    """One operation of a formula."""
    if code == ADD:
        return x + y
    if code == SUB:
        return x - y
    if code == MUL:
        return x * y
    if code == DIV:
        return x / y
    if code == NEG:
        return -x
    if code == POSITIVE:
        return 1.0 if x > 0.0 else 0.0
    return elementary(code, x)


@compiled
def elementary(code: int, x: float) -> float:
    """A function of one number."""
    if code == SQRT:
        return math.sqrt(x)
    if code == SIN:
        return math.sin(x)
    if code == COS:
        return math.cos(x)
    if code == TAN:
        return math.tan(x)
    if code == ASIN:
        return math.asin(x)
    if code == ACOS:
        return math.acos(x)
    if code == ATAN:
        return math.atan(x)
    if code == EXP:
        return math.exp(x)
    if code == LOG:
        return math.log(x)
    return math.tanh(x)


@compiled
def coefficients(scheme: Program, h: float, ratio: float, r: Array) -> None:
    """All coefficients for a step size and its ratio to the one before."""
    for n in range(len(scheme.tape)):
        code, i, j = scheme.tape[n, 0], scheme.tape[n, 1], scheme.tape[n, 2]
        if code == CONSTANT:
            r[n] = scheme.constants[n]
        elif code == INPUT:
            r[n] = ratio if i == 1 else h
        else:
            r[n] = formula(code, r[i], r[j])


@compiled
def apply(scheme: Program, which: int, state: State) -> None:
    """One of the affine maps."""
    x, terms = state.x, scheme.terms
    for n in range(scheme.bounds[which], scheme.bounds[which + 1]):
        to, of, count, base, factor = terms[n, 0], terms[n, 1], terms[n, 2], terms[n, 4], state.r[terms[n, 3]]
        target, source, first = x[to : to + count], x[of : of + count], x[base : base + count]
        for k in range(len(target)):
            target[k] = first[k] + factor * source[k]


@compiled
def update(scheme: Program, h: float, state: State) -> None:
    """The stages, and q and v after the step, of the unknowns; see `UPDATE` for the rest of the state."""
    apply(scheme, STAGES, state)


@compiled(entry=True)
def guess(scheme: Program, h: float, ratio: float, continued: bool, state: State) -> None:
    """Coefficients, first guess of the unknowns, and all stages."""
    coefficients(scheme, h, ratio, state.r)
    apply(scheme, CONTINUED if scheme.continues and continued else GUESS, state)
    apply(scheme, BASE, state)
    update(scheme, h, state)


@compiled
def call_operators(scheme: Program, entries: Entries, b: Array, t: float, h: float, x: Array) -> None:
    """The operators in the equations of all stages of a step that ends at t. Outputs are cleared as far as they go."""
    for n in range(len(scheme.calls)):
        row = scheme.calls[n]
        group, time = row[0], t + (scheme.times[row[1]] - 1.0) * h
        first, last = entries.bounds[group], entries.bounds[group + 1]
        kernels = Entry(entries.addresses[first:last], entries.starts[first : last + 1], entries.tables)
        q, second, third, out, other = (
            x[row[2] :],
            x[row[3] :],
            x[row[4] :],
            x[row[5] : row[6]],
            x[row[7] : row[8]],
        )
        if group in (RESIDUAL, VELOCITY):
            call_kernels(kernels, b, time, q, second, out, other)
        elif group == MOMENTUM:
            call_kernels(kernels, b, q, second, third, out, other)
        else:
            call_kernels(kernels, b, time, q, second, out)


@compiled
def residual(
    scheme: Program, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, left_out: Array,
    beta: float, ignored: float,
) -> None:  # fmt: skip
    """All equations of a step, scaled; see `alpha_loop.residual` for the round-off of Φ that is left out."""
    x, right = state.x, memory.right
    call_operators(scheme, entries, b, t, h, x)
    for n in range(len(scheme.rates)):
        of, to = scheme.rates[n, 0], scheme.rates[n, 1]
        for k in range(len(memory.unit)):
            x[to + k] = memory.unit[k] * x[of + k]
    apply(scheme, EQUATIONS, state)
    for n in range(len(scheme.positions) if ignored > 0.0 else 0):
        row, factor = scheme.positions[n, 0], ignored * abs(state.r[scheme.positions[n, 1]])
        for k in range(len(memory.noise)):
            gap, noise = right[row + k], factor * memory.noise[k]
            right[row + k] = gap - noise if gap > noise else (gap + noise if gap < -noise else 0.0)
    for n in range(len(scheme.multipliers)):
        row, of = scheme.multipliers[n, 0], scheme.multipliers[n, 1]
        for k in range(len(left_out)):
            if left_out[k] != 0.0:
                right[row + k] = x[of + k]


@compiled(entry=True)
def evaluate(
    scheme: Program, entries: Entries, b: Array, t: float, h: float, x: Array, values: Array, left_out: Array
) -> None:
    """The operators of the matrix, at all stages of a step that ends at t."""
    for n in range(len(scheme.operators)):
        row = scheme.operators[n]
        group, time = row[0], t + (scheme.times[row[1]] - 1.0) * h
        first, last = entries.bounds[OF_EQUATIONS + group], entries.bounds[OF_EQUATIONS + group + 1]
        kernels = Entry(entries.addresses[first:last], entries.starts[first : last + 1], entries.tables)
        q, second, third = x[row[2] :], x[row[3] :], x[row[4] :]
        one, two = values[row[5] : row[6]], values[row[7] : row[8]]
        if group == INERTIA:
            three, four = values[row[9] : row[10]], values[row[11] : row[12]]
            call_kernels(kernels, b, q, second, third, one, two, three, four)
        elif group in (JACOBIAN, STIFFNESS, GAMMA_Q_V):
            call_kernels(kernels, b, time, q, second, one, two)
        else:
            call_kernels(kernels, b, time, q, second, one)
    for n in range(len(scheme.constrained)):
        values[scheme.constrained[n, 0]] *= 1.0 - left_out[scheme.constrained[n, 1]]


@compiled
def renew(
    scheme: Program, entries: Entries, b: Array, t: float, h: float, state: State, matrix: Matrix, control: Control,
    beta: float, gamma: float,
) -> bool:  # fmt: skip
    """Factor the matrix of the step as it is now; false if pivots must be renewed."""
    control.matrices += 1
    evaluate(scheme, entries, b, t, h, state.x, matrix.values, matrix.left_out)
    if not refactor(matrix.values, matrix.placed) > TRUSTED:
        return False
    if len(scheme.T) > 0 and not refactor(matrix.values, matrix.pair) > TRUSTED:
        return False
    control.beta, control.corrections, control.solved_steps = beta, 0, 0
    return True


@compiled
def weights_of(scheme: Program, h: float) -> tuple[float, float]:
    """The ratios that identify the factors of one step size; see `prepare`."""
    return h, 1.0


@compiled
def solve(scheme: Program, memory: Memory, matrix: Matrix) -> None:
    """The changes of all unknowns; those of stages that are split by Z = T W."""
    if len(scheme.T) == 0:
        backsolve(matrix.placed, memory.right, memory.solution)
        return
    T, back, n, right, to = scheme.T, scheme.T_inverse, len(memory.real), memory.right, memory.solution
    for k in range(n):
        r0, r1, r2 = right[k], right[n + k], right[2 * n + k]
        memory.real[k] = back[0, 0] * r0 + back[0, 1] * r1 + back[0, 2] * r2
        memory.pair[k] = (back[1, 0] * r0 + back[1, 1] * r1 + back[1, 2] * r2) + 1j * (
            back[2, 0] * r0 + back[2, 1] * r1 + back[2, 2] * r2
        )
    backsolve(matrix.placed, memory.real, memory.real_solution)
    backsolve(matrix.pair, memory.pair, memory.pair_solution)
    for i in range(3):
        for k in range(n):
            w = memory.pair_solution[k]
            to[i * n + k] = T[i, 0] * memory.real_solution[k] + T[i, 1] * w.real + T[i, 2] * w.imag


@compiled
def correct(
    scheme: Program, h: float, state: State, memory: Memory, matrix: Matrix, beta: float, gamma: float,
    tol: Tolerance,
) -> float:  # fmt: skip
    """One correction of the unknowns by the residual and the factors at hand; returns its size."""
    x = state.x
    solve(scheme, memory, matrix)
    unknowns, change = (
        x[scheme.unknowns : scheme.unknowns + scheme.n],
        x[scheme.change : scheme.change + scheme.n],
    )
    for k in range(len(unknowns)):
        unknowns[k] -= memory.solution[k]
        change[k] = memory.solution[k]
    update(scheme, h, state)
    return size_of_change(scheme, state, tol)


@compiled
def size_of_change(scheme: Program, state: State, tol: Tolerance) -> float:
    """The size of changes of q₁ and v₁ by those of the unknowns."""
    n, x, first = len(state.q0), state.x, scheme.moved
    apply(scheme, CHANGE, state)
    in_q = size(x[first : first + n], 1.0, state.q0, state.q1, tol.rtol_q, tol.atol_q)
    in_v = size(x[first + n : first + 2 * n], 1.0, state.v0, state.v1, tol.rtol_v, tol.atol_v)
    return max(in_q, in_v) + 0.0 * in_v  # max may hide what is not a number


@compiled
def settled(scheme: Program, state: State, memory: Memory) -> bool:
    """Whether the last correction changed the multipliers λ by less than `SETTLED` of the largest."""
    largest, change, x = 0.0, 0.0, state.x
    for n in range(len(scheme.forces)):
        lam, by, factor = scheme.forces[n, 0], scheme.forces[n, 1], state.r[scheme.forces[n, 2]]
        for k in range(len(state.lam0)):
            largest, change = max(largest, abs(x[lam + k])), max(change, abs(factor * x[by + k]))
    return change <= SETTLED * largest


@compiled
def prepare(
    scheme: Program, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, matrix: Matrix,
    control: Control,
) -> None:  # fmt: skip
    """Coefficients and the state before a step of length h, and the first guess of its unknowns."""
    ratio = h / control.last_h if control.last_h > 0.0 else 1.0
    if h != control.x_h or ratio != control.ratio:
        coefficients(scheme, h, ratio, state.r)
        control.x_h, control.ratio = h, ratio
        weights = matrix.placed.weights
        for k in range(len(weights)):
            if weights[k] != state.r[scheme.weights[k]]:
                weights[k], control.beta = state.r[scheme.weights[k]], 0.0
        pair = matrix.pair.weights
        for k in range(len(pair)):
            pair[k] = state.r[scheme.pair_weights[k, 0]] + 1j * state.r[scheme.pair_weights[k, 1]]
        if scheme.projects:
            remove_defect(entries, b, t, 1.0 - ratio * ratio, state, memory, matrix, control)
    apply(scheme, CONTINUED if scheme.continues and control.continued else GUESS, state)
    apply(scheme, BASE, state)


@compiled
def remove_defect(
    entries: Entries, b: Array, t: float, part: float, state: State, memory: Memory, matrix: Matrix,
    control: Control,
) -> None:  # fmt: skip
    """Remove a part of the defect d = Φ_q v + Φ_t by the least change of v: M s + Φ_qᵀσ = 0, Φ_q s = d."""
    n, work = len(state.q0), memory.motion
    for k in range(n):
        state.v0[k] = state.v_given[k]
    control.defect = 1.0
    if part == 0.0:
        return
    if not control.projected:
        if not factor_motion(entries.motion, b, t, state.q0, matrix.motion) > TRUSTED:
            return
        velocity_defect(entries.motion, b, t, state.q0, state.v0, work)
        for k in range(n):
            work.right[k] = 0.0
        for k in range(len(work.rate)):
            work.right[n + k] = work.rate[k] * (1.0 - matrix.left_out[k])
        backsolve(matrix.motion.placed, work.right, memory.correction)
        control.projected = True
    for k in range(n):
        state.v0[k] -= part * memory.correction[k]
    control.defect = 1.0 - part


@compiled
def accelerations(entries: Entries, b: Array, t: float, state: State, memory: Memory, matrix: Matrix) -> bool:
    """a and λ of the equations of motion after a step; false if pivots must be renewed."""
    for k in range(len(state.a1)):
        state.a1[k] = state.a0[k]
    for k in range(len(state.lam1)):
        state.lam1[k] = state.lam0[k]
    trust = factor_motion(entries.motion, b, t, state.q1, matrix.motion)
    if not trust > TRUSTED:
        return False
    solve_motion(
        entries.motion, b, t, state.q1, state.v1, state.a1, state.lam1, memory.motion, matrix.motion,
        1 if trust > PRECISE else REFINEMENTS,
    )  # fmt: skip
    return True


@compiled
def local_error(
    scheme: Program, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, matrix: Matrix,
    tol: Tolerance, again: bool,
) -> float:  # fmt: skip
    """Size of the error of a step, over the tolerances; less than 0 if pivots must be renewed."""
    apply(scheme, UPDATE, state)
    if len(scheme.filtered) > 0:
        return filtered_error(scheme, entries, b, state, memory, matrix, tol, again)
    if not scheme.own_accelerations and not accelerations(entries, b, t, state, memory, matrix):
        return -1.0
    if scheme.estimated:
        apply(scheme, ERROR, state)
    else:
        leading_term(scheme, h, state)
    estimate, k = state.x[scheme.error : scheme.error + len(state.q0)], scheme.exponent
    error = size(estimate, 1.0, state.q0, state.q1, tol.rtol_q, tol.atol_q)
    if tol.speed > 0.0:
        speed = size(estimate, 1.0 / h, state.v0, state.v1, tol.rtol_v, tol.atol_v)
        error = max(error, speed ** (k / (k - 1.0)))  # it falls with one power of h less
    return error


@compiled
def smooth(scheme: Program, h: float, state: State, tol: Tolerance) -> None:
    """Accelerations between which states are interpolated: of the equations of motion, which are the most accurate.

    Where a stiff force on a light body makes them useless, they are those of the last stage.
    """
    for k in range(len(state.a1)):
        allowed, slope = tol.atol_q[k] + tol.rtol_q[k] * abs(state.q1[k]), state.x[scheme.end_slope + k]
        if not h * h * abs(state.a1[k] - slope) <= HERMITE * allowed:
            state.a1[k] = slope


@compiled
def filtered_error(
    scheme: Program, entries: Entries, b: Array, state: State, memory: Memory, matrix: Matrix, tol: Tolerance,
    again: bool,
) -> float:  # fmt: skip
    """Size of the error by a `FilteredEstimate`; one that is too large is filtered `again`, for stiff beginnings."""
    n, x, r, of = len(state.q0), state.x, state.r, scheme.filtered
    apply(scheme, ERROR, state)
    for k in range(n):
        x[scheme.error + k] *= memory.unit[k] * r[of[2]]
        x[scheme.error + n + k] *= r[of[3]]
    error = solve_for_error(scheme, entries, b, state, memory, matrix, tol)
    if again and error >= 1.0:
        for k in range(n):
            x[scheme.error + k] = memory.unit[k] * r[of[0]] * memory.real_solution[of[6] + k]
            x[scheme.error + n + k] = r[of[1]] * memory.real_solution[of[7] + k]
        error = solve_for_error(scheme, entries, b, state, memory, matrix, tol)
    return error


@compiled
def solve_for_error(
    scheme: Program, entries: Entries, b: Array, state: State, memory: Memory, matrix: Matrix, tol: Tolerance
) -> float:
    """Solve for the error of a step; returns its size."""
    n, x, of, M_a, S = len(state.q0), state.x, scheme.filtered, scheme.inertia, scheme.inertia + len(state.q0)
    first, end, a = entries.bounds[MOMENTUM], entries.bounds[MOMENTUM + 1], x[scheme.error + n :]
    kernels = Entry(entries.addresses[first:end], entries.starts[first : end + 1], entries.tables)
    call_kernels(kernels, b, state.q0, state.v0, a, x[M_a : M_a + n], x[S : S + n])
    memory.real[:] = 0.0
    for k in range(n):
        memory.real[of[4] + k] = x[scheme.error + k]
        memory.real[of[5] + k] = x[M_a + k]
    backsolve(matrix.placed, memory.real, memory.real_solution)
    last = scheme.change + scheme.n - len(memory.real)
    for k in range(len(memory.real)):
        x[last + k] = memory.real_solution[k]
    return size_of_change(scheme, state, tol)


@compiled
def leading_term(scheme: Program, h: float, state: State) -> None:
    """Constant times h^k q^(k), by the divided difference of the accelerations at the last k - 1 nodes.

    Before there are so many of them, a lower derivative, with its power of h, is taken: it is the greater term.
    """
    x, first, count = state.x, scheme.error, 0
    while count < len(state.past) and state.past[count] < INFINITE:
        count += 1
    factor = scheme.constant * h ** (count + 2.0)
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
def factor_to(scheme: Program, error: float, iterations: int) -> float:
    """By how much a step may be longer than one with this error."""
    safety, n = scheme.lengths.safety, 2.0 * scheme.lengths.iterations
    if n > 0.0:
        safety *= (1.0 + n) / (iterations + n)
    return float(safety * max(error, LEAST_ERROR) ** (-1.0 / scheme.exponent))


@compiled
def next_length(scheme: Program, h: float, wanted: float, error: float, control: Control) -> float:
    """The length of the step after an accepted one of length h, see `StepLengths`."""
    rule = scheme.lengths
    if rule.predictive and control.last_h > 0.0:
        fall = max(control.last_error, 1e-2) / max(error, LEAST_ERROR) ** 2
        wanted = min(wanted, rule.safety * (h / control.last_h) * fall ** (1.0 / scheme.exponent))
    if rule.predictive and control.rejected_since > 0:
        wanted = min(wanted, 1.0)
    if wanted < rule.below:
        return h * max(wanted, rule.shrink)
    return max(control.h, h * min(wanted, rule.grow)) if wanted > rule.above else control.h


@compiled
def finish(
    scheme: Program, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, matrix: Matrix,
    tol: Tolerance, exact: bool,
) -> bool:  # fmt: skip
    """Accelerations of an accepted step, as far as they are not known; false if pivots must be renewed."""
    if exact:
        apply(scheme, UPDATE, state)
    filtered = len(scheme.filtered) > 0
    if (exact or filtered) and not scheme.own_accelerations:
        if not accelerations(entries, b, t, state, memory, matrix):
            return False
        if not exact:
            smooth(scheme, h, state, tol)
    return True


@compiled
def accept(scheme: Program, h: float, state: State) -> None:
    """The end of the step is the start of the next."""
    x, n, height, share = state.x, len(state.q0), scheme.after - scheme.state, 1.0 / h
    slope, lam_slope = x[scheme.slope : scheme.slope + n], x[scheme.lam_slope :]
    before, unknowns = x[scheme.before : scheme.before + scheme.n], x[scheme.unknowns :]
    first, after, former = x[scheme.state : scheme.state + height], x[scheme.after :], x[scheme.former :]
    for k in range(len(first) if scheme.continues else 0):
        former[k] = first[k]
    for i in range(len(state.past) - 1, 0, -1):
        state.past[i] = state.past[i - 1] + h
        for k in range(n):
            state.past_a[i, k] = state.past_a[i - 1, k]
    for k in range(n):
        slope[k] = (state.a1[k] - state.a0[k]) * share
        state.v_given[k] = state.v1[k]
    for k in range(len(state.lam0)):
        lam_slope[k] = (state.lam1[k] - state.lam0[k]) * share
    for k in range(len(first)):
        first[k] = after[k]
    for k in range(len(before)):
        before[k] = unknowns[k]
    for k in range(n if len(state.past) > 0 else 0):
        state.past_a[0, k] = state.a0[k]


@compiled
def keep(
    scheme: Program,
    record: Record,
    row: int,
    t: float,
    h: float,
    state: State,
    memory: Memory,
    control: Control,
) -> None:
    """Write an accepted step into the record."""
    record.t[row], record.h[row], record.removed[row] = t, h, 1.0 - control.defect
    record.rejected[row] = control.rejected_since
    for k in range(len(state.q0)):
        record.q[row, k], record.v[row, k], record.a[row, k] = state.q1[k], state.v1[k], state.a1[k]
    for k in range(len(state.lam0)):
        record.lam[row, k] = state.lam1[k]
    for k in range(record.stages.shape[1]):
        record.stages[row, k] = state.x[scheme.stages + k]
    n, factor = record.correction.shape[1], 1.0 if control.defect != 1.0 else 0.0
    for k in range(n):
        record.correction[row, k] = factor * memory.correction[k]
    for k in range(record.impulse.shape[1]):
        record.impulse[row, k] = factor * memory.correction[n + k]
    control.projected, control.continued = False, True
