"""Newton's method for one step."""

from __future__ import annotations

import numpy as np

from ...._jit.linking.link import compiled
from ..methods.program import STAGES
from ..stepping.motion_scale import LENGTH, Tolerance
from .coefficients import apply
from .equations import correct, renew, residual
from .records import Run, State

LIMIT = 12  # iterations
# Share of the tolerance that may be left in an iterate, of q and of v: what is left in v adds up
NEWTON_SHARE = 0.03
RENEW, RENEWALS = 0.5, 3  # contraction at which the matrix is renewed within a step, and how often at most
SLOW = 0.3  # contraction at which the matrix is renewed for the next step
EPSILON = 2.0**-52


@compiled
def ignored_round_off(h: float, state: State, tol: Tolerance) -> float:
    """1 where the round-off of Φ, divided by h, is more than Newton's method may leave in v, see `described.finest`."""
    length = tol.size[LENGTH] if tol.size[LENGTH] > 0.0 else 1.0
    largest, total, moving = 0.0, 0.0, len(state.q0) - len(tol.states)
    for i in range(len(tol.bounds)):
        for kind in range(2):
            unit = length if kind == 0 else 1.0
            for k in range(tol.bounds[i, kind], tol.bounds[i, kind + 1]):
                largest = max(largest, abs(state.q0[k]) / unit)
                relative = unit / (tol.atol_v[k] + tol.rtol_v[k] * abs(state.v0[k]))
                total += relative * relative
    size = tol.noise * 2.0 * EPSILON * largest / h * (total / moving) ** 0.5
    return 1.0 if size > NEWTON_SHARE else 0.0


@compiled
def newton(run: Run, t: float, h: float) -> tuple[int, float]:
    """Solve one step. Returns (iterations, contraction): 0 iterations if it fails, -1 for pivots to renew."""
    program, entries, b, state, memory = run.program, run.entries, run.b, run.state, run.memory
    matrix, control, tol = run.matrix, run.control, run.tol
    rate, before, renewals = 0.0, 0.0, 0
    ignored = ignored_round_off(h, state, tol)
    stalled = tol.stalled_repeated if matrix.left_out.any() else tol.stalled
    apply(program, STAGES, state)
    for iteration in range(LIMIT):
        residual(program, entries, b, t, h, state, memory, matrix.left_out, ignored)
        control.residuals += 1
        if control.factored_h != h and not renew(program, entries, b, t, h, state, matrix, control):
            return -1 if renewals == 0 else 0, 0.0
        change = correct(program, state, memory, matrix, tol)
        if not change < 1e30:
            return 0, 2.0
        if before > 0.0:
            rate = max(0.9 * rate, change / before)
        if change <= 1e-4 * tol.newton or (before > 0.0 and change <= 0.1 * tol.newton):
            return iteration + 1, min(rate, SLOW)
        if rate > RENEW and renewals < RENEWALS and change > stalled:  # the guess was too far for its matrix
            renewals += 1
            control.factored_h, rate, before = 0.0, 0.0, 0.0
            continue
        if rate > 0.9:
            return (iteration + 1 if change <= stalled else 0), min(rate, SLOW)
        if before > 0.0 and change * rate / (1.0 - rate) <= tol.newton:
            return iteration + 1, rate
        before = change
    return 0, 1.0


@compiled
def polish(run: Run, t: float, h: float) -> bool:
    """Newton's method down to round-off, for steps of prescribed lengths; false if pivots must be renewed."""
    program, entries, b, state, memory = run.program, run.entries, run.b, run.state, run.memory
    matrix, control, tol = run.matrix, run.control, run.tol
    ignored, before = ignored_round_off(h, state, tol), np.inf
    if not renew(program, entries, b, t, h, state, matrix, control):
        return False
    for _ in range(LIMIT):
        residual(program, entries, b, t, h, state, memory, matrix.left_out, ignored)
        control.residuals += 1
        change = correct(program, state, memory, matrix, tol)
        if not change < 0.5 * before:
            break
        before = change
    return before < np.inf
