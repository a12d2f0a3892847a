"""Derivatives of the steps of the generalized-α method, forward and backward, as functions that are compiled.

With what `alpha_loop` says of a step, its unknowns (a₁, λ₁) solve R(a₁, λ₁; q₀, v₀, ã₀, a₀, b) = 0 with the matrix
J = [M + β'K + γ'C, Φ_qᵀ; Φ_q, 0], K = (M a)_q + (Φ_qᵀλ)_q - Q_q - S_q, C = -Q_v - S_v, at the converged state. So

    J [a₁'; λ₁'] = -[R_b b' + K q* + C v*; (Φ_b b' + Φ_q q*) / β']

where q*, v* are the changes of q₁, v₁ with a₁ held; the adjoint solves with Jᵀ. Columns (of the numbers, or of
responses) are handled together: vectors here are arrays (n, columns). Step lengths are data. All but these solutions
and products is done for a block of steps at once: `block_loop`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..._jit.vector import LANES
from .block_loop import (
    finish,
    linearize_rescales,
    linearize_steps,
    solve_lane,
    solve_lane_transposed,
    solved_rows,
)
from .panel_loop import add, copy

weights_of: Any = None  # of `dynamics.alpha_loop`, put in place when this is compiled
STEP, RESCALE, GRADIENTS = 0, 1, 2  # what is done next
ONE: Any = np.uint64(1)
# Relative change of a solution by its refinement up to which the others of a block are not refined; with schemes that
# damp round-off in multipliers: γ - ½ beyond a limit, which is (1 - ρ) / (1 + ρ) where steps leave ρ of it
PLAIN, DAMPS = 1e-12, 0.02


class Work(NamedTuple):
    """Vectors with columns: of the unknowns (nq + m), and of coordinates; of the unknowns with a single one.

    room : of three vectors with columns, for `solve_columns`
    trusted : the last relative change of a solution, up to which the order of the pivots is kept
    """

    right: Any
    solution: Any
    room: Any
    q: Any
    v: Any
    x: Any
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


def apply(block: Any, lane: Any, q: Any, v: Any, out: Any) -> None:
    """Out = P [q; v], the product of a lane with columns."""
    numbers, none = block.turned[lane, block.cuts[2] :], np.uint64(0)
    out[:] = 0.0
    add_columns(block.product, numbers, none, q, out)
    add_columns(block.product, numbers, np.uint64(q.shape[0]), v, out)


def add_columns(product: Any, numbers: Any, first: Any, x: Any, out: Any) -> None:
    """Out += A x for columns of P from `first` on (n, k)."""
    indptr, indices, width = product.indptr, product.indices, x.shape[1]
    for j in range(np.uint64(x.shape[0])):
        for entry in range(indptr[first + j], indptr[first + j + ONE]):
            value, row = numbers[entry], indices[entry]
            for c in range(width):
                out[row, c] += value * x[j, c]


def apply_transposed(block: Any, lane: Any, y: Any, q: Any, v: Any) -> None:
    """[q; v] += Pᵀ y, with the product of a lane."""
    numbers, none = block.turned[lane, block.cuts[2] :], np.uint64(0)
    add_rows(block.product, numbers, none, y, q)
    add_rows(block.product, numbers, np.uint64(q.shape[0]), y, v)


def add_rows(product: Any, numbers: Any, first: Any, y: Any, out: Any) -> None:
    """Out += Aᵀ y for columns of P from `first` on (n, k)."""
    indptr, indices, width = product.indptr, product.indices, y.shape[1]
    for j in range(np.uint64(out.shape[0])):
        for c in range(width):
            total = out[j, c]
            for entry in range(indptr[first + j], indptr[first + j + ONE]):
                total += numbers[entry] * y[indices[entry], c]
            out[j, c] = total


def forward_step(
    scheme: Any, record: Any, n: Any, matrix: Any, block: Any, work: Any, bars: Any, sources: Any
) -> Any:
    """The change of the state over step n; false if pivots must be renewed."""
    lane, h, kappa = block.used[1], record.h[n], (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
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
    right = work.right
    apply(block, lane, work.q, work.v, right)
    for c in range(width):
        for k in range(nq):
            right[k, c] -= block.by_q[c, k * LANES + lane]
        for k in range(m):
            right[nq + k, c] = -(right[nq + k, c] + block.by_rows[c, k * LANES + lane]) / beta
    subtract(sources.step, n, right)
    solved_rows(record, n, right)
    if not solve_lane(matrix, block, lane, right, work.solution, work.room) <= work.trusted[0]:
        return False
    for k in range(nq):
        for c in range(width):
            change = work.solution[k, c]
            bars.a[k, c] = change
            bars.x[k, c] = kappa * change + work.x[k, c]
            bars.v[k, c] = gamma * change + work.v[k, c]
            bars.q[k, c] = beta * change + work.q[k, c]
    copy(work.solution[nq:], bars.lam)
    block.used[1] += 1
    return True


def subtract(sources: Any, n: Any, right: Any) -> None:
    """Right -= sources of step n (n, nq + m, columns), if there are any."""
    if len(sources) > 0:
        for k in range(right.shape[0]):
            for c in range(right.shape[1]):
                right[k, c] -= sources[n, k, c]


def backward_step(
    scheme: Any, record: Any, n: Any, matrix: Any, block: Any, work: Any, bars: Any, kept: Any, sources: Any
) -> Any:
    """From the gradients by the end of step n to those by its start; false if pivots must be renewed."""
    lane, h, kappa = block.used[1], record.h[n], (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    beta, gamma = weights_of(scheme, h)
    nq, m, width = bars.q.shape[0], bars.lam.shape[0], bars.q.shape[1]
    right, mu, size = work.right, work.solution, nq * width
    q, v, a, x = bars.q.reshape(size), bars.v.reshape(size), bars.a.reshape(size), bars.x.reshape(size)
    above = right[:nq].reshape(size)
    for k in range(size):
        above[k] = a[k] + kappa * x[k] + gamma * v[k] + beta * q[k]
    copy(bars.lam, right[nq:])
    if len(sources.step) > 0:
        for k in range(nq + m):
            right[k, 0] -= sources.step[n, k]
    if not solve_lane_transposed(matrix, block, lane, right, mu, work.room) <= work.trusted[0]:
        return False
    bars.lam[:] = 0.0
    if len(sources.step) > 0:
        for k in range(nq):
            bars.q[k, 0] -= sources.step_q[n, k]
            bars.v[k, 0] -= sources.step_v[n, k]
    solved_rows(record, n, mu)
    if len(kept.step) > 0:
        copy(mu, kept.step[n])
    for k in range(m):
        for c in range(width):
            mu[nq + k, c] /= -beta
    put_adjoint(block, lane, mu, -1.0)
    apply_transposed(block, lane, mu, bars.q, bars.v)
    share_m, share_f = scheme.alpha_m / (1.0 - scheme.alpha_m), scheme.alpha_f / (1.0 - scheme.alpha_m)
    for k in range(size):
        by_q, by_v = q[k], v[k]
        by_x = x[k] + h * h * scheme.beta * by_q + h * scheme.gamma * by_v
        v[k] = by_v + h * by_q
        x[k] = h * h * (0.5 - scheme.beta) * by_q + h * (1.0 - scheme.gamma) * by_v - share_m * by_x
        a[k] = share_f * by_x
    block.used[1] += 1
    return True


def put_adjoint(block: Any, lane: Any, mu: Any, sign: Any) -> None:
    """ξ and ν of a lane: those in μ, the latter times a sign."""
    nq, m = len(block.q) // LANES, len(block.lam) // LANES
    for c in range(mu.shape[1]):
        for k in range(nq):
            block.xi[c, k * LANES + lane] = mu[k, c]
        for k in range(m):
            block.nu[c, k * LANES + lane] = sign * mu[nq + k, c]


def forward_rescale(
    record: Any, n: Any, matrix: Any, block: Any, work: Any, bars: Any, kept: Any, sources: Any
) -> Any:
    """The change of the velocities by the new step size of step n; false if pivots must be renewed."""
    lane, right = block.used[1], work.right
    nq, m, width = bars.q.shape[0], bars.lam.shape[0], bars.q.shape[1]
    apply(block, lane, bars.q, bars.v, right)
    for c in range(width):
        for k in range(nq):
            right[k, c] -= block.by_q[c, k * LANES + lane]
        for k in range(m):
            right[nq + k, c] -= block.by_rows[c, k * LANES + lane]
    subtract(sources.rescale, n, right)
    solved_rows(record, n, right)
    if not solve_lane(matrix, block, lane, right, work.solution, work.room) <= work.trusted[0]:
        return False
    if len(kept.rescale) > 0:
        copy(work.solution, kept.rescale[n])
    for k in range(nq):
        for c in range(width):
            bars.v[k, c] -= record.removed[n] * work.solution[k, c]
    block.used[1] += 1
    return True


def backward_rescale(
    record: Any, n: Any, matrix: Any, block: Any, work: Any, bars: Any, kept: Any, sources: Any
) -> Any:
    """From the gradients by the state after the new step size of step n to those before; false for new pivots."""
    lane, right, z = block.used[1], work.right, work.solution
    nq, m, width = bars.q.shape[0], bars.lam.shape[0], bars.q.shape[1]
    for k in range(nq):
        for c in range(width):
            right[k, c] = -record.removed[n] * bars.v[k, c]
    right[nq:] = 0.0
    if len(sources.rescale) > 0:
        for k in range(nq + m):
            right[k, 0] -= sources.rescale[n, k]
    if not solve_lane_transposed(matrix, block, lane, right, z, work.room) <= work.trusted[0]:
        return False
    if len(sources.rescale) > 0:
        for k in range(nq):
            bars.q[k, 0] -= sources.rescale_q[n, k]
            bars.v[k, 0] -= sources.rescale_v[n, k]
    solved_rows(record, n, z)
    if len(kept.rescale) > 0:
        copy(z, kept.rescale[n])
        for k in range(nq):
            kept.s[n, k] = block.a[k * LANES + lane]
        for k in range(m):
            kept.s[n, nq + k] = block.lam[k * LANES + lane]
    put_adjoint(block, lane, z, 1.0)
    apply_transposed(block, lane, z, bars.q, bars.v)
    block.used[1] += 1
    return True


def add_gradients(given: Any, row: Any, bars: Any) -> None:
    """Add what responses take from one node."""
    add(given.q[row], bars.q)
    add(given.v[row], bars.v)
    add(given.a[row], bars.a)
    add(given.lam[row], bars.lam)


def backward(
    scheme: Any, entries: Any, b: Any, record: Any, n: Any, first: Any, stage: Any, matrix: Any, steps: Any,
    rescales: Any, work: Any, bars: Any, given: Any, kept: Any, sources: Any,
) -> Any:  # fmt: skip
    """From the end of step n to the start of step `first`; returns (n, stage) of what needs new pivots.

    `given` holds the gradients of responses by the ends of the steps, one row for each.
    """
    steps.used[:], rescales.used[:] = 0, 0
    steps.refined[2] = rescales.refined[2] = PLAIN if scheme.gamma - 0.5 > DAMPS else 0.0
    while n >= first:
        if stage == GRADIENTS:
            add_gradients(given, n - first, bars)
            stage = STEP
        if stage == STEP:
            if steps.used[1] == steps.used[0]:
                finish(b, record, steps)
                linearize_steps(scheme, entries, b, record, n, first, -1, matrix, steps)
            if not backward_step(scheme, record, n, matrix, steps, work, bars, kept, sources):
                break
            stage = RESCALE
        if record.removed[n] != 0.0:
            if rescales.used[1] == rescales.used[0]:
                finish(b, record, rescales)
                if not linearize_rescales(entries, b, record, n, first, -1, matrix, rescales, work):
                    break
            if not backward_rescale(record, n, matrix, rescales, work, bars, kept, sources):
                break
        if n > 0 and record.h[n] != record.h[n - 1]:
            ratio = record.h[n] / record.h[n - 1]
            for k in range(bars.x.shape[0]):
                for c in range(bars.x.shape[1]):
                    bars.a[k, c] += (1.0 - ratio) * bars.x[k, c]
                    bars.x[k, c] *= ratio
        n, stage = n - 1, GRADIENTS
    finish(b, record, steps)
    finish(b, record, rescales)
    return n, stage


def forward(
    scheme: Any, entries: Any, b: Any, record: Any, n: Any, last: Any, stage: Any, matrix: Any, steps: Any,
    rescales: Any, work: Any, bars: Any, given: Any, kept: Any, sources: Any,
) -> Any:  # fmt: skip
    """From the start of step n to that of step `last`; returns (n, stage) of what needs new pivots.

    `given` takes the derivatives, one row for each step.
    """
    start = last - len(given.q)
    steps.used[:], rescales.used[:] = 0, 0
    while n < last:
        if stage == RESCALE:
            if record.removed[n] != 0.0:
                if rescales.used[1] == rescales.used[0] and not linearize_rescales(
                    entries, b, record, n, last - 1, 1, matrix, rescales, work
                ):
                    break
                if not forward_rescale(record, n, matrix, rescales, work, bars, kept, sources):
                    break
            if n > 0 and record.h[n] != record.h[n - 1]:
                ratio = record.h[n] / record.h[n - 1]
                for k in range(bars.x.shape[0]):
                    for c in range(bars.x.shape[1]):
                        bars.x[k, c] = bars.a[k, c] + ratio * (bars.x[k, c] - bars.a[k, c])
            stage = STEP
        if steps.used[1] == steps.used[0]:
            linearize_steps(scheme, entries, b, record, n, last - 1, 1, matrix, steps)
        if not forward_step(scheme, record, n, matrix, steps, work, bars, sources):
            break
        row = n - start
        copy(bars.q, given.q[row])
        copy(bars.v, given.v[row])
        copy(bars.a, given.a[row])
        copy(bars.lam, given.lam[row])
        n, stage = n + 1, RESCALE
    return n, stage
