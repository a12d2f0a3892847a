"""The loop of steps, as one function that is compiled: many steps for one call from Python."""

from __future__ import annotations

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.block_matrix import backsolve
from ..dense_output.sample_loop import MotionSolver, velocity_defect
from ..dense_output.sample_loop import factor as factor_motion
from ..methods.program import BASE, CONTINUED, GUESS, STAGES, Program
from ..stepping.motion_scale import follow_motion
from .coefficients import apply, coefficients
from .crossing import (
    LANDED,
    NONE,
    SEARCHING,
    Step,
    farther_back,
    first_after,
    shorter,
    without,
)
from .equations import TRUSTED
from .error import factor_to, finish, local_error, next_length, smooth
from .newton import newton, polish
from .records import Control, Run, State

RUNNING, FINISHED, REPIVOT, TOO_SMALL, SWITCHED = 0, 1, 2, 3, 4
NEWTON, ERROR = 1, 2  # why a step was last rejected
SHRINK = 0.2  # of a rejected step, at least
SHORTEST = 1e-14  # of the time, or of the time that is left: no step is shorter
IN_A_ROW = 1000  # rejected steps at most: the least factors lead to the shortest step with fewer
ROUND_OFF = 2.0**-50  # of times, relative to the largest
# Iterations, after which the choice among redundant equations is looked at again; not where stages are split: their
# matrix is that of one stage, and long steps need many
MANY = 6


@compiled
def guess(program: Program, h: float, ratio: float, continued: bool, state: State) -> None:
    """Coefficients, first guess of the unknowns, and all stages."""
    coefficients(program, h, ratio, state.r)
    apply(program, CONTINUED if program.continues and continued else GUESS, state)
    apply(program, BASE, state)
    apply(program, STAGES, state)


@compiled
def prepare(run: Run, t: float, h: float) -> None:
    """Coefficients and the state before a step of length h, and the first guess of its unknowns."""
    program, state, matrix, control = run.program, run.state, run.matrix, run.control
    ratio = h / control.last_h if control.last_h > 0.0 else 1.0
    if h != control.x_h or ratio != control.ratio:
        coefficients(program, h, ratio, state.r)
        control.x_h, control.ratio = h, ratio
        weights = matrix.placed.weights
        for k in range(len(weights)):
            if weights[k] != state.r[program.weights[k]]:
                weights[k], control.factored_h = state.r[program.weights[k]], 0.0
        pair = matrix.pair.weights
        for k in range(len(program.pair_weights)):
            pair[4 * k] = weights[k]
            for part in range(2):
                pair[4 * k + 1 + part] = state.r[program.pair_weights[k, part]]
        if program.projects:
            correction = run.memory.correction
            remove_defect(
                run.motion, run.b, t, 1.0 - ratio * ratio, state, correction, matrix.left_out, control
            )
    apply(program, CONTINUED if program.continues and control.continued else GUESS, state)
    apply(program, BASE, state)


@compiled
def remove_defect(
    motion: MotionSolver, b: Array, t: float, part: float, state: State, correction: Array, left_out: Array,
    control: Control,
) -> None:  # fmt: skip
    """Remove a part of the defect d = Φ_q v + Φ_t by the least change of v: M s + Φ_qᵀσ = 0, Φ_q s = d."""
    n, work = len(state.q0), motion.work
    for k in range(n):
        state.v0[k] = state.v_given[k]
    control.defect = 1.0
    if part == 0.0:
        return
    if not control.projected:
        if not factor_motion(motion.entries, b, t, state.q0, motion.matrix) > TRUSTED:
            return
        velocity_defect(motion.entries, b, t, state.q0, state.v0, work)
        for k in range(n):
            work.right[k] = 0.0
        for k in range(len(work.rate)):
            work.right[n + k] = work.rate[k] * (1.0 - left_out[k])
        backsolve(motion.matrix.placed, work.right, correction)
        control.projected = True
    for k in range(n):
        state.v0[k] -= part * correction[k]
    control.defect = 1.0 - part


@compiled
def not_too_soon(h: float, longer: float, control: Control) -> float:
    """The length of the next step, no longer than this one for some steps after a failure of Newton's method."""
    if control.wait > 0:
        control.wait -= 1
        return min(longer, h)
    if control.rejected_since == 0 and h > control.last_h:
        control.hold //= 2
    return longer


@compiled
def last_length(t: float, until: float, before: float) -> float:
    """The length of the last step: that of the step before where they differ by no more than the round-off of times."""
    ahead = until - t
    return before if abs(ahead - before) <= ROUND_OFF * max(abs(t), abs(until)) else ahead


@compiled
def accept(program: Program, h: float, state: State) -> None:
    """The end of the step is the start of the next."""
    x, n, height, share = state.x, len(state.q0), program.after - program.state, 1.0 / h
    slope, lam_slope = x[program.slope : program.slope + n], x[program.lam_slope :]
    before, unknowns = x[program.before : program.before + program.n], x[program.unknowns :]
    first, after, former = x[program.state : program.state + height], x[program.after :], x[program.former :]
    for k in range(len(first) if program.continues else 0):
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
def keep(run: Run, row: int, t: float, h: float) -> None:
    """Write an accepted step into the record."""
    record, state, control, correction = run.record, run.state, run.control, run.memory.correction
    record.t[row], record.h[row], record.removed[row] = t, h, 1.0 - control.defect
    record.rejected[row] = control.rejected_since
    for k in range(len(state.q0)):
        record.q[row, k], record.v[row, k] = state.q1[k], state.v1[k]
        record.a[row, k] = record.node_a[row, k] = state.a1[k]
    for k in range(len(state.lam0)):
        record.lam[row, k] = state.lam1[k]
    for k in range(record.stages.shape[1]):
        record.stages[row, k] = state.x[run.program.stages + k]
    n, factor = record.correction.shape[1], 1.0 if control.defect != 1.0 else 0.0
    for k in range(n):
        record.correction[row, k] = factor * correction[k]
    for k in range(record.impulse.shape[1]):
        record.impulse[row, k] = factor * correction[n + k]


@compiled
def remember(entry: KernelTable, b: Array, places: Array, t: float, q: Array, memory: Array) -> None:
    """Let the elements remember an accepted state."""
    if len(places):
        call_kernels(entry, b, t, q, memory)
        for k in range(len(places)):
            b[places[k]] = memory[k]


@compiled
def advance(run: Run, until: float, limit: int) -> tuple[int, int]:
    """Take steps until a time, at most `limit` of them.

    It returns early where a singular configuration or a poor choice among redundant equations may be near: after a
    failure of Newton's method, and after many iterations.

    Returns
    -------
    a status, and how many steps were taken; the elements' numbers `b` remember the last of them, in `places`
    """
    program, b, state, control, record, tol = run.program, run.b, run.state, run.control, run.record, run.tol
    switching, crossing = run.switching, run.crossing
    taken, free, leave, redundant = 0, len(record.given) == 0, False, bool(run.matrix.left_out.any())
    toward, crossing.stage, crossing.nearer = 0.0, NONE, 0  # length of a step towards a switch
    while control.t < until and taken < limit and not leave and (free or taken < len(record.given)):
        t0 = control.t
        h = min(control.h, run.h_max) if free else record.given[taken]
        ended = t0 + 1.0001 * h >= until and free
        if toward > 0.0:
            h, ended = min(toward, until - t0), toward >= until - t0
        elif ended:
            h = last_length(t0, until, control.last_h)
        elif t0 + 1.9 * h > until and free:  # two equal steps to the end
            h = 0.5 * (until - t0)
        if free and (control.h <= SHORTEST * max(abs(t0), until - t0) or control.rejected_since > IN_A_ROW):
            return TOO_SMALL, taken
        follow_motion(tol, h, state.q0, state.v0, state.a0, control.last_h == 0.0)
        prepare(run, t0, h)
        matrices = control.matrices
        iterations, rate = newton(run, t0 + h, h)
        if iterations < 0:
            return REPIVOT, taken
        if iterations == 0:
            control.rejected += 1
            control.rejected_since += 1
            control.failure = NEWTON
            if control.old_factors:  # with an old matrix: once more with a new one
                control.factored_h, control.old_factors = 0.0, False
                continue
            toward, control.factored_h = farther_back(crossing, h), 0.0
            if toward == 0.0 and free:
                control.h, leave = program.lengths.unsolved * h, True
                control.hold = control.wait = min(max(2 * control.hold, 2), program.lengths.hold)
            elif toward == 0.0:
                return TOO_SMALL, taken
            continue
        again = control.rejected_since > 0 or control.last_h == 0.0
        error = local_error(run, t0 + h, h, again, control.matrices > matrices)
        if error < 0.0:
            return REPIVOT, taken
        wanted = factor_to(program, error, iterations)
        if error > 1.0 and free:
            control.rejected += 1
            control.rejected_since += 1
            control.failure = ERROR
            if crossing.stage == SEARCHING and h > crossing.h:
                toward = without(switching, crossing)  # a shorter step would see that switch again
            else:
                toward, crossing.stage = 0.0, NONE
                control.h = h * max(SHRINK, wanted)
            continue
        if not free and not polish(run, t0 + h, h):
            return REPIVOT, taken
        if not finish(program, run.motion, b, t0 + h, state, not free):
            return REPIVOT, taken
        end = until if ended or taken + 1 == len(record.given) else t0 + h
        keep(run, taken, end, h)
        if len(program.filtered) > 0 and not program.own_accelerations:
            smooth(program, h, state, tol, record.node_a[taken])
        if len(switching.columns):
            ends = state.q0, state.v_given, state.a0, state.q1, state.v1, state.a1
            toward = shorter(switching, Step(b, t0, h, *ends, run.apart), crossing)
            if toward > 0.0:
                control.rejected += 1
                control.rejected_since += 1
                continue
        control.t, control.projected, control.continued = end, False, True
        record.error[taken], record.iterations[taken] = error, iterations
        accept(program, h, state)
        if crossing.stage == LANDED:
            control.h, control.continued = min(control.h, first_after(crossing)), False
        else:
            control.h = not_too_soon(h, next_length(program, h, wanted, error, control), control)
        control.last_h, control.last_error, control.defect = h, error, 1.0
        remember(run.remembered, b, run.places, control.t, state.q0, record.memory[taken])
        control.old_factors = True
        control.steps += 1
        control.rejected_since = 0
        taken += 1
        if rate > tol.slow:
            control.factored_h, control.old_factors = 0.0, False
        leave = redundant and iterations > MANY and len(program.T) == 0
        switching.ignored[:] = 0.0
        crossing.since += 1
        if crossing.stage == LANDED:
            crossing.since = 0
            if switching.returns[crossing.number]:
                return SWITCHED, taken
            crossing.stage = NONE
    return (FINISHED if control.t >= until else RUNNING), taken
