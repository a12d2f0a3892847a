"""Newton's method for one step."""

from __future__ import annotations

from ...._jit.linking.link import compiled
from ....algebra import Array
from ..methods.program import STAGES, Program
from ..stepping.motion_scale import LENGTH, Tolerance
from .coefficients import apply
from .equations import correct, renew, residual, settled
from .records import Control, Entries, Matrix, Memory, State

LIMIT = 12  # iterations
# Share of the tolerance that may be left in an iterate, of q and of v: what is left in v adds up
NEWTON_SHARE = 0.03
RENEW, RENEWALS = 0.5, 3  # contraction at which the matrix is renewed within a step, and how often at most
SLOW = 0.3  # contraction at which the matrix is renewed for the next step
# Of the tolerance: what may be left in a step that is stored; where changes may be round-off. Part of the round-off to
# be expected that may be left, too: most of it is never met
EXACT, NOISE, ROUND = 3e-8, 1e-6, 0.02
POLISHES = 8  # most corrections for that
WRONG = 1.0  # of the tolerance: a correction of a step that was solved, which only unsuitable pivots make
EPSILON = 2.0**-52


@compiled
def round_off(h: float, state: State, tol: Tolerance) -> float:
    """How large in v, over the tolerances, the round-off of Φ becomes by h: see `beginning.finest`."""
    length = tol.size[LENGTH] if tol.size[LENGTH] > 0.0 else 1.0
    largest, total, moving = 0.0, 0.0, len(state.q0) - len(tol.states)
    for k in range(moving):
        largest = max(largest, abs(state.q0[k]) / length if k % 7 < 3 else abs(state.q0[k]))
    for k in range(moving):
        unit = length if k % 7 < 3 else 1.0
        relative = unit / (tol.atol_v[k] + tol.rtol_v[k] * abs(state.v0[k]))
        total += relative * relative
    return float(tol.noise * 2.0 * EPSILON * largest / h * (total / moving) ** 0.5)


@compiled
def ignored_round_off(h: float, state: State, tol: Tolerance) -> float:
    """1 where the round-off of Φ is more in v than Newton's method may leave there, as in very short steps, else 0."""
    return 1.0 if round_off(h, state, tol) > NEWTON_SHARE else 0.0


@compiled
def newton(
    program: Program, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory,
    matrix: Matrix, control: Control, tol: Tolerance,
) -> tuple[int, float, float]:  # fmt: skip
    """Solve one step. Returns (iterations, contraction, change): 0 iterations if it fails, -1 for pivots to renew."""
    rate, before, renewals = 0.0, 0.0, 0
    ignored = ignored_round_off(h, state, tol)
    stalled = tol.stalled_repeated if matrix.left_out.any() else tol.stalled
    apply(program, STAGES, state)
    for iteration in range(LIMIT):
        residual(program, entries, b, t, h, state, memory, matrix.left_out, ignored)
        control.residuals += 1
        if control.factored_h != h and not renew(program, entries, b, t, h, state, matrix, control):
            return -1 if renewals == 0 else 0, 0.0, 0.0
        change = correct(program, state, memory, matrix, tol)
        if not change < 1e30:
            return 0, 2.0, change
        if before > 0.0:
            rate = max(0.9 * rate, change / before)
        if change <= 1e-4 * tol.newton or (before > 0.0 and change <= 0.1 * tol.newton):
            return iteration + 1, min(rate, SLOW), change
        if rate > RENEW and renewals < RENEWALS and change > stalled:  # the guess was too far for its matrix
            renewals += 1
            control.factored_h, rate, before = 0.0, 0.0, 0.0
            continue
        if rate > 0.9:
            return (iteration + 1 if change <= stalled else 0), min(rate, SLOW), change
        if before > 0.0 and change * rate / (1.0 - rate) <= tol.newton:
            return iteration + 1, rate, change
        before = change
    return 0, 1.0, before


@compiled
def polish(
    program: Program, entries: Entries, b: Array, t: float, h: float, state: State, memory: Memory,
    matrix: Matrix, control: Control, tol: Tolerance, rate: float, before: float,
) -> int:  # fmt: skip
    """Newton's method to the end, for steps whose derivatives are wanted; returns how many corrections it took.

    Less than 0 if pivots must be renewed. What the last correction leaves follows from how much they contract: none is
    made only to see it. `rate` and `before` are the contraction (0: not known) and the last change so far.
    """
    enough, renewed = max(EXACT, ROUND * round_off(h, state, tol)), False
    ignored = ignored_round_off(h, state, tol)
    for taken in range(POLISHES):
        if before * (rate if rate > 0.0 else 1.0) <= enough and settled(program, state):
            return taken
        residual(program, entries, b, t, h, state, memory, matrix.left_out, ignored)
        control.residuals += 1
        old = before
        if not renewed and before > NOISE and before * rate**tol.further > enough:
            if not renew(program, entries, b, t, h, state, matrix, control):
                return -1
            renewed, old = True, 0.0
        before = correct(program, state, memory, matrix, tol)
        if not before < WRONG:
            return -1
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
        control.factored_h, control.old_factors = 0.0, False
