"""The time loop of the generalized-α method, as one function that is compiled: many steps for one call from Python.

Unknowns of a step are the accelerations a and multipliers λ at its end (Arnold and Brüls 2007); the update uses the
method's own acceleration ã, (1 - α_m) ã₁ + α_m ã₀ = (1 - α_f) a₁ + α_f a₀, and

    q₁ = q₀ + h v₀ + h² ((½ - β) ã₀ + β ã₁),    v₁ = v₀ + h ((1 - γ) ã₀ + γ ã₁).

Constraint residuals are divided by β' = β h² κ, κ = (1 - α_f) / (1 - α_m), so that the Newton matrix stays well
conditioned as h falls (Bottasso, Bauchau and Cardona 2007). When h changes, ã₀ - a₀, which is proportional to h, and
the defect of the velocity constraints, which is proportional to h², are rescaled; the latter in the metric of M.

Every step is a smooth function of the state before it and of the numbers b; a `Record` keeps what its derivatives need.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...._jit.kernels.pointer import Entry, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.block_matrix import Placed, PlacedMatrix, backsolve, leave_out, refactor
from .motion_scale import LENGTH, Tolerance, follow_motion
from .newton_matrix import weigh
from .step_control import StepControl

RUNNING, FINISHED, REPIVOT, TOO_SMALL = 0, 1, 2, 3
NEWTON, ERROR = 1, 2  # why a step was last rejected
NEWTON_LIMIT = 12  # iterations
# Share of the tolerance that may be left in an iterate, of q and of v: what is left in v adds up
NEWTON_SHARE = 0.03
RENEW, RENEWALS = 0.5, 3  # contraction at which the matrix is renewed within a step, and how often at most
SLOW = 0.3  # contraction at which the matrix is renewed for the next step
SAFETY, SHRINK, GROW = 0.85, 0.2, 3.0
# Of the tolerance: what may be left in a step that is stored; where changes may be round-off. Part of the round-off to
# be expected that may be left, too: most of it is never met
EXACT, NOISE, ROUND = 3e-8, 1e-6, 0.02
SETTLED = 1e-6  # of the largest multiplier: the last change of the multipliers of a step that is stored
TRUSTED = 1e-9  # pivot over column, below which the order of the pivots is chosen anew
POLISHES = 8  # most corrections for that
EPSILON = 2.0**-52
KEEP = 1.3  # the step is not enlarged by less than this
MANY = 6  # iterations, after which the choice among redundant equations is looked at again


class Scheme(NamedTuple):
    """Coefficients of the method, and of its local error in q: error h³ ȧ."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    error: float


class State(NamedTuple):
    """Arrays at the start (0) and the end (1) of a step, and what a and λ changed in the last one."""

    q0: Array
    v0: Array
    a0: Array
    x0: Array
    lam0: Array
    q1: Array
    v1: Array
    a1: Array
    x1: Array
    lam1: Array
    a_change: Array
    lam_change: Array


class Memory(NamedTuple):
    """Operators' outputs and work arrays.

    noise : the round-off of every equation of Φ
    correction : s and σ of `rescale` for the whole defect that the velocities had at the start of the step
    """

    Phi: Array
    Phi_qT_lam: Array
    M_a: Array
    S: Array
    Q: Array
    rate: Array
    Phi_t: Array
    right: Array
    solution: Array
    previous: Array
    noise: Array
    correction: Array


class Matrix(NamedTuple):
    """The numbers of all operators; the Newton matrix and its factors."""

    values: Array
    Phi_q: Array
    Phi_qT_lam_q: Array
    M: Array
    M_a_q: Array
    S_q: Array
    S_v: Array
    Q_q: Array
    Q_v: Array
    row_of: Array
    left_out: Array
    placed: Placed


def matrix_of(matrix: PlacedMatrix) -> Matrix:
    """A `PlacedMatrix` with `newton_matrix.NUMBERS` among its numbers, as the loop takes it."""
    numbers = matrix.numbers
    rest = (numbers.row_of, numbers.left_out, matrix.placed)
    return Matrix._make([numbers.values, *numbers.of(Matrix._fields[1:-3]), *rest])


class Entries(NamedTuple):
    """The kernels of the groups of operators, see `_jit.kernels.pointer`."""

    residual: Entry
    momentum: Entry
    force: Entry
    jacobian: Entry
    inertia: Entry
    stiffness: Entry
    velocity: Entry
    remember: Entry


class Control(StepControl):
    """See `StepControl`.

    Attributes
    ----------
    x_h : the length of step that ã₀ belongs to [s]
    defect : what part of the defect of the velocity constraints is left since the last step
    beta : β' of the factors; 0 where they are to be renewed
    old_factors : whether the factors are those of an earlier step
    corrections, solved_steps : corrections with these factors, and steps solved with them
    failure : why a step was last rejected, `NEWTON` or `ERROR`
    last_error : the error of the last step, over the tolerance
    ratio, projected, continued : of described methods: the ratio of steps that the coefficients belong to; whether the
        defect of the velocities before the step has been computed; whether there is a step from which the next goes on
    """

    x_h: float
    defect: float
    beta: float
    old_factors: bool
    corrections: int
    solved_steps: int
    failure: int
    last_error: float
    ratio: float
    projected: bool
    continued: bool


class Record(NamedTuple):
    """Stored steps, row by row, as many as the buffers hold; and lengths of steps that are prescribed.

    h, removed : length of each step, and which part of the defect of the velocity constraints was removed before it
    error, iterations, rejected : its error (1 is the tolerance), Newton iterations, and the steps rejected before it
    t, q, v, a, x, lam : its end
    correction, impulse : s and σ of `rescale`, if there are buffers for them; zero where nothing was removed
    memory : what elements remember there
    given : lengths to take, without error control (none: chosen to meet the tolerances)
    """

    t: Array
    h: Array
    removed: Array
    q: Array
    v: Array
    a: Array
    x: Array
    lam: Array
    correction: Array
    impulse: Array
    memory: Array
    error: Array
    iterations: Array
    rejected: Array
    given: Array


@compiled
def update(scheme: Scheme, h: float, state: State) -> None:
    """q₁, v₁, ã₁ of a₁."""
    m, f = scheme.alpha_m, scheme.alpha_f
    for k in range(len(state.q0)):
        x0 = state.x0[k]
        x1 = ((1.0 - f) * state.a1[k] + f * state.a0[k] - m * x0) / (1.0 - m)
        state.x1[k] = x1
        state.q1[k] = state.q0[k] + h * state.v0[k] + h * h * ((0.5 - scheme.beta) * x0 + scheme.beta * x1)
        state.v1[k] = state.v0[k] + h * ((1.0 - scheme.gamma) * x0 + scheme.gamma * x1)


@compiled
def residual(
    scheme: Scheme, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, left_out: Array,
    beta: float, ignored: float,
) -> None:  # fmt: skip
    """[M a + Φ_qᵀλ - Q - S; Φ / β'] at the end of the step.

    `ignored` times the round-off of Φ is left out: in very short steps β' would make accelerations
    of it.
    """
    n = len(state.q0)
    call_kernels(entries.residual, b, t, state.q1, state.lam1, memory.Phi, memory.Phi_qT_lam)
    call_kernels(entries.momentum, b, state.q1, state.v1, state.a1, memory.M_a, memory.S)
    call_kernels(entries.force, b, t, state.q1, state.v1, memory.Q)
    for k in range(n):
        memory.right[k] = memory.M_a[k] + memory.Phi_qT_lam[k] - memory.Q[k] - memory.S[k]
    for k in range(len(memory.Phi)):
        gap, noise = memory.Phi[k], ignored * memory.noise[k]
        gap = gap - noise if gap > noise else (gap + noise if gap < -noise else 0.0)
        memory.right[n + k] = gap / beta if left_out[k] == 0.0 else state.lam1[k]


@compiled
def evaluate(
    entries: Entries, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, matrix: Matrix
) -> None:
    """The numbers of all operators at one state."""
    call_kernels(entries.jacobian, b, t, q, lam, matrix.Phi_q, matrix.Phi_qT_lam_q)
    call_kernels(entries.inertia, b, q, v, a, matrix.M, matrix.M_a_q, matrix.S_q, matrix.S_v)
    call_kernels(entries.stiffness, b, t, q, v, matrix.Q_q, matrix.Q_v)
    leave_out(matrix.Phi_q, matrix.row_of, matrix.left_out)


@compiled
def factor(
    entries: Entries, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array, matrix: Matrix, beta: float,
    gamma: float,
) -> float:  # fmt: skip
    """Evaluate, assemble and factor the Newton matrix; returns how far the pivots can be trusted.

    With β' = γ' = 0 it is [M, Φ_qᵀ; Φ_q, 0].
    """
    evaluate(entries, b, t, q, v, a, lam, matrix)
    weigh(matrix.placed.weights, beta, gamma)
    return refactor(matrix.values, matrix.placed)


@compiled
def size(change: Array, factor: float, q0: Array, q1: Array, rtol: Array, atol: Array) -> float:
    """Root mean square of factor x change, each entry over its tolerance."""
    total = 0.0
    for k in range(len(q0)):
        entry = factor * change[k] / (atol[k] + rtol[k] * max(abs(q0[k]), abs(q1[k])))
        total += entry * entry
    return float((total / len(q0)) ** 0.5)


@compiled
def correct(
    scheme: Scheme, h: float, state: State, memory: Memory, matrix: Matrix, beta: float, gamma: float,
    tol: Tolerance,
) -> float:  # fmt: skip
    """One correction of a₁ and λ₁ by the residual and the factors at hand; returns its size."""
    n = len(state.q0)
    backsolve(matrix.placed, memory.right, memory.solution)
    for k in range(n):
        state.a1[k] -= memory.solution[k]
    for k in range(len(state.lam0)):
        state.lam1[k] -= memory.solution[n + k]
    update(scheme, h, state)
    change = size(memory.solution, beta, state.q0, state.q1, tol.rtol_q, tol.atol_q)
    return max(change, size(memory.solution, gamma, state.v0, state.v1, tol.rtol_v, tol.atol_v))


@compiled
def weights_of(scheme: Scheme, h: Any) -> tuple[Any, Any]:
    """β' and γ' of a step."""
    kappa = (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    return scheme.beta * h * h * kappa, scheme.gamma * h * kappa


@compiled
def renew(
    scheme: Scheme, entries: Entries, b: Array, t: float, h: float, state: State, matrix: Matrix, control: Control,
    beta: float, gamma: float,
) -> bool:  # fmt: skip
    """Factor the matrix at the end of the step, as it is now; false if pivots must be renewed."""
    control.matrices += 1
    q, v, a, lam = state.q1, state.v1, state.a1, state.lam1
    if not factor(entries, b, t, q, v, a, lam, matrix, beta, gamma) > TRUSTED:
        return False
    control.beta, control.corrections, control.solved_steps = beta, 0, 0
    return True


@compiled
def round_off(h: float, state: State, tol: Tolerance) -> float:
    """How large in v, over the tolerances, the round-off of Φ becomes by h: see `AlphaStepper._finest`."""
    length = tol.size[LENGTH] if tol.size[LENGTH] > 0.0 else 1.0
    largest, total = 0.0, 0.0
    for k in range(len(state.q0)):
        largest = max(largest, abs(state.q0[k]) / length if k % 7 < 3 else abs(state.q0[k]))
    for k in range(len(state.v0)):
        unit = length if k % 7 < 3 else 1.0
        relative = unit / (tol.atol_v[k] + tol.rtol_v[k] * abs(state.v0[k]))
        total += relative * relative
    return float(tol.noise * 2.0 * EPSILON * largest / h * (total / len(state.v0)) ** 0.5)


@compiled
def ignored_round_off(h: float, state: State, tol: Tolerance) -> float:
    """1 where the round-off of Φ is more in v than Newton's method may leave there, as in very short steps, else 0."""
    return 1.0 if round_off(h, state, tol) > NEWTON_SHARE else 0.0


@compiled
def settled(scheme: Scheme, state: State, memory: Memory) -> bool:
    """Whether the last correction changed the multipliers by less than `SETTLED` of the largest.

    `size` sees accelerations alone.
    """
    largest, change = 0.0, 0.0
    for k in range(len(state.lam1)):
        largest, change = (
            max(largest, abs(state.lam1[k])),
            max(change, abs(memory.solution[len(state.q0) + k])),
        )
    return change <= SETTLED * largest


@compiled
def polish(
    scheme: Scheme, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory,
    matrix: Matrix, control: Control, tol: Tolerance, rate: float, before: float,
) -> int:  # fmt: skip
    """Newton's method to the end, for steps whose derivatives are wanted; returns how many corrections it took.

    Less than 0 if pivots must be renewed. What the last correction leaves follows from how much they contract: none is
    made only to see it. `rate` and `before` are the contraction (0: not known) and the last change so far.
    """
    beta, gamma = weights_of(scheme, h)
    enough, renewed = max(EXACT, ROUND * round_off(h, state, tol)), False
    ignored = ignored_round_off(h, state, tol)
    for taken in range(POLISHES):
        if before * (rate if rate > 0.0 else 1.0) <= enough and settled(scheme, state, memory):
            return taken
        residual(scheme, entries, b, t, h, state, memory, matrix.left_out, beta, ignored)
        control.residuals += 1
        old = before
        if not renewed and before > NOISE and before * rate**tol.further > enough:
            if not renew(scheme, entries, b, t, h, state, matrix, control, beta, gamma):
                return -1
            renewed, old = True, 0.0
        before = correct(scheme, h, state, memory, matrix, beta, gamma, tol)
        rate = max(0.5 * rate, before / old) if old > 0.0 else 0.0
        if old > 0.0 and rate > SLOW and (renewed or before <= NOISE):
            return taken + 1
    return POLISHES


@compiled
def replace(iterations: int, control: Control, worth: float) -> None:
    """New factors for the next step, where the last one took more corrections than steps with these did on average.

    The average counts the factors, too, as `worth` so many corrections; it falls at first and
    rises from where they are better replaced.
    """
    control.corrections += iterations
    control.solved_steps += 1
    if control.solved_steps > 1 and iterations * control.solved_steps > worth + control.corrections:
        control.beta, control.old_factors = 0.0, False


@compiled
def newton(
    scheme: Scheme, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory,
    matrix: Matrix, control: Control, tol: Tolerance,
) -> tuple[int, float, float]:  # fmt: skip
    """Solve one step. Returns (iterations, contraction, change): 0 iterations if it fails, -1 for pivots to renew."""
    beta, gamma = weights_of(scheme, h)
    rate, before, renewals = 0.0, 0.0, 0
    ignored = ignored_round_off(h, state, tol)
    stalled = tol.stalled_repeated if matrix.left_out.any() else tol.stalled
    update(scheme, h, state)
    for iteration in range(NEWTON_LIMIT):
        residual(scheme, entries, b, t, h, state, memory, matrix.left_out, beta, ignored)
        control.residuals += 1
        if control.beta != beta and not renew(scheme, entries, b, t, h, state, matrix, control, beta, gamma):
            return -1 if renewals == 0 else 0, 0.0, 0.0
        change = correct(scheme, h, state, memory, matrix, beta, gamma, tol)
        if not change < 1e30:
            return 0, 2.0, change
        if before > 0.0:
            rate = max(0.9 * rate, change / before)
        if change <= 1e-4 * tol.newton or (before > 0.0 and change <= 0.1 * tol.newton):
            return iteration + 1, min(rate, SLOW), change
        if rate > RENEW and renewals < RENEWALS and change > stalled:  # the guess was too far for its matrix
            renewals += 1
            control.beta, rate, before = 0.0, 0.0, 0.0
            continue
        if rate > 0.9:
            return (iteration + 1 if change <= stalled else 0), min(rate, SLOW), change
        if before > 0.0 and change * rate / (1.0 - rate) <= tol.newton:
            return iteration + 1, rate, change
        before = change
    return 0, 1.0, before


@compiled
def predict(ratio: float, state: State) -> None:
    """First guess of a₁ and λ₁: their last change, once more."""
    for k in range(len(state.a0)):
        state.a1[k] = state.a0[k] + ratio * state.a_change[k]
    for k in range(len(state.lam0)):
        state.lam1[k] = state.lam0[k] + ratio * state.lam_change[k]


@compiled
def accept(scheme: Scheme, h: float, state: State) -> None:
    """The end of the step is the start of the next."""
    for k in range(len(state.a0)):
        state.a_change[k] = state.a1[k] - state.a0[k]
        state.q0[k], state.v0[k], state.a0[k] = state.q1[k], state.v1[k], state.a1[k]
        state.x0[k] = state.x1[k]
    for k in range(len(state.lam0)):
        state.lam_change[k] = state.lam1[k] - state.lam0[k]
        state.lam0[k] = state.lam1[k]


@compiled
def stretch(ratio: float, state: State) -> None:
    """ã₀ - a₀ goes with h."""
    for k in range(len(state.x0)):
        state.x0[k] = state.a0[k] + ratio * (state.x0[k] - state.a0[k])


@compiled
def rescale(
    entries: Entries, b: Array, t: float, ratio: float, state: State, memory: Memory, matrix: Matrix,
    control: Control,
) -> None:  # fmt: skip
    """A new step size: ã₀ - a₀ goes with h, the defect of the velocity constraints with h².

    A part of the defect d = Φ_q v + Φ_t is removed by the least change of v in the metric of M: M s + Φ_qᵀσ = 0,
    Φ_q s = d. The factors at hand are replaced.
    """
    n = len(state.q0)
    stretch(ratio, state)
    control.beta = 0.0
    if control.last_h == 0.0:
        return
    if not factor(entries, b, t, state.q0, state.v0, state.a0, state.lam0, matrix, 0.0, 0.0) > TRUSTED:
        return
    call_kernels(entries.velocity, b, t, state.q0, state.v0, memory.rate, memory.Phi_t)
    for k in range(n):
        memory.right[k] = 0.0
    for k in range(len(memory.rate)):
        memory.right[n + k] = (memory.rate[k] + memory.Phi_t[k]) * (1.0 - matrix.left_out[k])
    backsolve(matrix.placed, memory.right, memory.solution)
    if control.defect == 1.0:
        for k in range(len(memory.correction)):
            memory.correction[k] = memory.solution[k]
    for k in range(n):
        state.v0[k] -= (1.0 - ratio * ratio) * memory.solution[k]
    control.defect *= ratio * ratio


@compiled
def prepare(
    scheme: Scheme, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, matrix: Matrix,
    control: Control,
) -> None:  # fmt: skip
    """The state before a step of length h, and the first guess of its unknowns."""
    if h != control.x_h:
        rescale(entries, b, t, h / control.x_h, state, memory, matrix, control)
        control.x_h = h
    predict(h / control.last_h if control.last_h > 0.0 else 0.0, state)


@compiled
def local_error(
    scheme: Scheme, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, matrix: Matrix,
    tol: Tolerance, again: bool,
) -> float:  # fmt: skip
    """Size of the error of a step, over the tolerances; less than 0 if pivots must be renewed.

    again : for first steps, and those that follow a rejected one
    """
    for k in range(len(state.x0)):
        memory.previous[k] = state.x1[k] - state.x0[k]
    error = size(memory.previous, scheme.error * h * h, state.q0, state.q1, tol.rtol_q, tol.atol_q)
    if tol.speed > 0.0:
        speed = size(memory.previous, scheme.error * h, state.v0, state.v1, tol.rtol_v, tol.atol_v)
        error = max(error, speed * speed**0.5)  # it falls with h²: as if it fell with h³
    return error


@compiled
def factor_to(scheme: Scheme, error: float, iterations: int) -> float:
    """By how much a step may be longer than one with this error."""
    return float(SAFETY * max(error, 1e-8) ** (-1.0 / 3.0))


@compiled
def next_length(scheme: Scheme, h: float, wanted: float, error: float, control: Control) -> float:
    """The length of the step after an accepted one of length h."""
    if wanted < 0.8:
        return h * max(wanted, SHRINK)
    return max(control.h, h * min(wanted, GROW)) if wanted > KEEP else control.h


@compiled
def finish(
    scheme: Scheme, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory, matrix: Matrix,
    tol: Tolerance, exact: bool,
) -> bool:  # fmt: skip
    """What follows from an accepted step; false if pivots must be renewed."""
    return True


@compiled
def keep(
    scheme: Scheme,
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
        record.q[row, k], record.v[row, k] = state.q1[k], state.v1[k]
        record.a[row, k], record.x[row, k] = state.a1[k], state.x1[k]
    for k in range(len(state.lam0)):
        record.lam[row, k] = state.lam1[k]
    if len(record.correction) > 0:
        n, factor = len(state.q0), 1.0 if control.defect != 1.0 else 0.0
        for k in range(n):
            record.correction[row, k] = factor * memory.correction[k]
        for k in range(len(state.lam0)):
            record.impulse[row, k] = factor * memory.correction[n + k]


@compiled
def remember(entries: Entries, b: Array, places: Array, t: float, q: Array, memory: Array) -> None:
    """Let the elements remember an accepted state."""
    if len(places):
        call_kernels(entries.remember, b, t, q, memory)
        for k in range(len(places)):
            b[places[k]] = memory[k]


@compiled(entry=True)
def advance(
    scheme: Scheme, entries: Entries, b: Array, places: Array, until: float, limit: int, h_max: float,
    state: State, memory: Memory, matrix: Matrix, control: Control, record: Record, exact: bool, tol: Tolerance,
) -> tuple[int, int]:  # fmt: skip
    """Take steps until a time, at most `limit` of them.

    It returns early where a singular configuration or a poor choice among redundant equations may be near: after a
    failure of Newton's method, and after many iterations.

    Returns
    -------
    a status, and how many steps were taken; the elements' numbers `b` remember the last of them, in `places`
    """
    taken, free, leave, redundant = 0, len(record.given) == 0, False, bool(matrix.left_out.any())
    while control.t < until and taken < limit and not leave and (free or taken < len(record.given)):
        t0 = control.t
        h = min(control.h, h_max) if free else record.given[taken]
        if t0 + 1.0001 * h >= until and free:
            h = until - t0
        elif t0 + 1.9 * h > until and free:  # two equal steps to the end
            h = 0.5 * (until - t0)
        if control.h <= 1e-14 * max(abs(t0), until - t0) and free:
            return TOO_SMALL, taken
        follow_motion(tol, h, state.q0, state.v0, state.a0, control.last_h == 0.0)
        prepare(scheme, entries, b, t0, h, state, memory, matrix, control)
        iterations, rate, change = newton(scheme, entries, b, t0 + h, h, state, memory, matrix, control, tol)
        if iterations < 0:
            return REPIVOT, taken
        if iterations == 0:
            control.rejected += 1
            control.rejected_since += 1
            control.failure = NEWTON
            if control.old_factors:  # with an old matrix: once more with a new one
                control.beta, control.old_factors = 0.0, False
            elif free:
                control.h, control.beta, leave = 0.25 * h, 0.0, True
            else:
                return TOO_SMALL, taken
            continue
        again = control.rejected_since > 0 or control.last_h == 0.0
        error = local_error(scheme, entries, b, t0 + h, h, state, memory, matrix, tol, again)
        if error < 0.0:
            return REPIVOT, taken
        wanted = factor_to(scheme, error, iterations)
        if error > 1.0 and free:
            control.rejected += 1
            control.rejected_since += 1
            control.failure = ERROR
            control.h = h * max(SHRINK, wanted)
            continue
        polished = 0
        if exact:
            polished = polish(
                scheme, entries, b, t0 + h, h, state, memory, matrix, control, tol, rate, change
            )
            if polished < 0:
                return REPIVOT, taken
            wanted = factor_to(scheme, error, iterations + polished)
        if not finish(scheme, entries, b, t0 + h, h, state, memory, matrix, tol, exact):
            return REPIVOT, taken
        ended = h == until - t0 if free else taken + 1 == len(record.given)
        control.t = until if ended else t0 + h
        keep(scheme, record, taken, control.t, h, state, memory, control)
        record.error[taken], record.iterations[taken] = error, iterations
        accept(scheme, h, state)
        control.h = next_length(scheme, h, wanted, error, control)
        control.last_h, control.last_error, control.defect = h, error, 1.0
        remember(entries, b, places, control.t, state.q0, record.memory[taken])
        control.old_factors = True
        control.steps += 1
        control.rejected_since = 0
        taken += 1
        if exact:
            replace(iterations + polished, control, tol.factors)
        if rate > tol.slow:
            control.beta, control.old_factors = 0.0, False
        leave = redundant and iterations > MANY
    return (FINISHED if control.t >= until else RUNNING), taken
