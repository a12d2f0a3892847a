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
from ..dense_output.sample_loop import factor as factor_motion
from ..dense_output.sample_loop import solve_motion, velocity_defect
from ..methods.program import (
    BASE,
    CHANGE,
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
from ..stepping.alpha_loop import SAFETY, SETTLED, TRUSTED, Control, size
from ..stepping.motion_scale import Tolerance

INFINITE = 1e300


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
    """Right side (in x) and solution of Newton's method; round-off of Φ; the removed defect (s, σ); W (nq,)."""

    right: Array
    solution: Array
    noise: Array
    correction: Array
    unit: Array
    motion: sample_loop.Work


class Matrix(NamedTuple):
    """The values of all operators, the matrix of a step and its factors; that of the equations of motion."""

    values: Array
    left_out: Array
    placed: Placed
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
def guess(scheme: Program, h: float, ratio: float, state: State) -> None:
    """Coefficients, first guess of the unknowns, and all stages."""
    coefficients(scheme, h, ratio, state.r)
    apply(scheme, GUESS, state)
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
    control.beta, control.corrections, control.solved_steps = beta, 0, 0
    return True


@compiled
def weights_of(scheme: Program, h: float) -> tuple[float, float]:
    """The ratios that identify the factors of one step size; see `prepare`."""
    return h, 1.0


@compiled
def correct(
    scheme: Program, h: float, state: State, memory: Memory, matrix: Matrix, beta: float, gamma: float,
    tol: Tolerance,
) -> float:  # fmt: skip
    """One correction of the unknowns by the residual and the factors at hand; returns its size."""
    n, x, first = len(state.q0), state.x, scheme.moved
    backsolve(matrix.placed, memory.right, memory.solution)
    unknowns, change = (
        x[scheme.unknowns : scheme.unknowns + scheme.n],
        x[scheme.change : scheme.change + scheme.n],
    )
    for k in range(len(unknowns)):
        unknowns[k] -= memory.solution[k]
        change[k] = memory.solution[k]
    update(scheme, h, state)
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
        if scheme.projects:
            remove_defect(entries, b, t, 1.0 - ratio * ratio, state, memory, matrix, control)
    apply(scheme, GUESS, state)
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
    if not factor_motion(entries.motion, b, t, state.q1, matrix.motion) > TRUSTED:
        return False
    solve_motion(entries.motion, b, t, state.q1, state.v1, state.a1, state.lam1, memory.motion, matrix.motion)
    return True


@compiled
def local_error(
    scheme: Program, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, matrix: Matrix,
    tol: Tolerance,
) -> float:  # fmt: skip
    """Size of the error of a step, over the tolerances; less than 0 if pivots must be renewed."""
    apply(scheme, UPDATE, state)
    if not scheme.own_accelerations:
        for k in range(len(state.a1)):
            state.a1[k] = state.a0[k]
        for k in range(len(state.lam1)):
            state.lam1[k] = state.lam0[k]
        if not accelerations(entries, b, t, state, memory, matrix):
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
def factor_to(scheme: Program, error: float) -> float:
    """By how much the next step may be longer than one with this error."""
    return float(SAFETY * max(error, 1e-8) ** (-1.0 / scheme.exponent))


@compiled
def finish(
    scheme: Program, entries: Entries, b: Array, t: float, state: State, memory: Memory, matrix: Matrix
) -> bool:
    """Accelerations of a step that was solved to the end; false if pivots must be renewed."""
    apply(scheme, UPDATE, state)
    return scheme.own_accelerations or accelerations(entries, b, t, state, memory, matrix)


@compiled
def accept(scheme: Program, h: float, state: State) -> None:
    """The end of the step is the start of the next."""
    x, n = state.x, len(state.q0)
    for i in range(len(state.past) - 1, 0, -1):
        state.past[i] = state.past[i - 1] + h
        for k in range(n):
            state.past_a[i, k] = state.past_a[i - 1, k]
    for k in range(n):
        x[scheme.slope + k] = (state.a1[k] - state.a0[k]) / h
        state.v_given[k] = state.v1[k]
    for k in range(len(state.lam0)):
        x[scheme.lam_slope + k] = (state.lam1[k] - state.lam0[k]) / h
    for k in range(scheme.after - scheme.state):
        x[scheme.state + k] = x[scheme.after + k]
    for k in range(scheme.n):
        x[scheme.before + k] = x[scheme.unknowns + k]
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
    control.projected = False
