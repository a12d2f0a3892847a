"""Derivatives of the steps of the generalized-α method, forward and backward, as functions that are compiled.

With what `alpha_loop` says of a step, its unknowns (a₁, λ₁) solve R(a₁, λ₁; q₀, v₀, ã₀, a₀, b) = 0 with the matrix
J = [M + β'K + γ'C, Φ_qᵀ; Φ_q, 0], K = (M a)_q + (Φ_qᵀλ)_q - Q_q - S_q, C = -Q_v - S_v, at the converged state. So

    J [a₁'; λ₁'] = -[R_b b' + K q* + C v*; (Φ_b b' + Φ_q q*) / β']

where q*, v* are the changes of q₁, v₁ with a₁ held; the adjoint solves with Jᵀ. Columns (of the numbers, or of
responses) are handled together: vectors are arrays (n, columns) backwards; forwards, where there may be many, panel
after panel (`columns_loop`), each all of its rows, or a single column. Step lengths are data. All but these solutions
and products is done for a block of steps at once: `block_loop`. What takes a whole block is called in one place, so
that it becomes part of the caller: handing over all its arrays would take as long as a step of a small system.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..._jit.lanes import fill, load, plus_product, store
from ..._jit.link import compiled
from ..._jit.scalars import Scalars
from ..._jit.vector import LANES
from ...algebra import Array
from ..dynamics.alpha_loop import Scheme, weights_of
from .block_loop import (
    Block,
    Entries,
    Product,
    Record,
    factors_of,
    finish,
    linearize_rescales,
    linearize_steps,
    solve_lane,
    solve_lane_transposed,
    solved_rows,
)
from .by_numbers import Moved
from .columns_loop import ByRows, minus_rows
from .panel_loop import Factors, add, copy

STEP, RESCALE, GRADIENTS = 0, 1, 2  # what is done next
ONE: Any = np.uint64(1)
TWO: Any = np.uint64(2)
# Relative change of a solution by its refinement up to which the others of a block are not refined; with schemes that
# damp round-off in multipliers: γ - ½ beyond a limit, which is (1 - ρ) / (1 + ρ) where steps leave ρ of it
PLAIN, DAMPS = 1e-12, 0.02


class Progress(Scalars):
    """How far a sweep is.

    Attributes
    ----------
    trusted : the last relative change of a solution, up to which the order of the pivots is kept
    panels : forwards, how many panels have made the step, or the change of its size, that is next
    """

    trusted: float
    panels: int


class Work(NamedTuple):
    """Vectors of the unknowns (nq + m, width); of the unknowns with a single column.

    width : of all columns backwards, of a panel forwards
    room : of three vectors of the unknowns, to solve with
    moved, x : forwards, what q and v (2 nq * width), and x, would be without the change of a₁
    progress : see `Progress`
    """

    right: Array
    solution: Array
    room: Array
    moved: Array
    x: Array
    single: Array
    progress: Progress


class Bars(NamedTuple):
    """Derivatives with respect to the state (backward), or of the first one (forward), and to the numbers b."""

    q: Array
    v: Array
    a: Array
    x: Array
    lam: Array
    b: Array


class Kept(NamedTuple):
    """Room for what is solved for in every step and every change of its size (n, nq + m, columns), or none.

    s are the solutions s, σ of the changes themselves (n, nq + m).
    """

    step: Array
    rescale: Array
    s: Array


class Sources(NamedTuple):
    """Changes of the equations besides; or none.

    Backwards those of the adjoint's equations (n, nq + m), (n, nq); forwards, in `step` and `rescale`, those of the
    residuals (n, nq + m, columns).
    """

    step: Array
    step_q: Array
    step_v: Array
    rescale: Array
    rescale_q: Array
    rescale_v: Array


class Given(NamedTuple):
    """Per node gradients of responses, which a sweep takes, or room for derivatives, which one forward gives."""

    q: Array
    v: Array
    a: Array
    lam: Array


class Weighed(NamedTuple):
    """Forwards, the change of responses, so that no derivatives of states need be kept; or none.

    by : their gradients by the states
    ends, rows, values : those of one node that are not zero: where each response's begin and end; room
    total : (panels, responses * width)
    """

    by: Given
    ends: Array
    rows: Array
    values: Array
    total: Array


@compiled
def apply(product: Product, numbers: Array, x: Array, right: Array) -> None:
    """Right = P x, with the numbers of P in a lane, and changes of q and v, one after another."""
    out = right.reshape(right.shape[0] * right.shape[1])
    out[:] = 0.0
    if right.shape[1] == 1:
        for j in range(np.uint64(len(x))):
            for entry in range(product.indptr[j], product.indptr[j + ONE]):
                out[product.indices[entry]] -= numbers[entry] * x[j]
    else:
        minus_rows(product.rows, numbers, x, out)
    for k in range(len(out)):
        out[k] = -out[k]


@compiled
def apply_transposed(block: Block, lane: int, y: Array, q: Array, v: Array) -> None:
    """[q; v] += Pᵀ y, with the product of a lane."""
    numbers, none = block.turned[lane, block.cuts.product :], np.uint64(0)
    add_rows(block.product, numbers, none, y, q)
    add_rows(block.product, numbers, np.uint64(q.shape[0]), y, v)


@compiled
def add_rows(product: Product, numbers: Array, first: Any, y: Array, out: Array) -> None:
    """Out += Aᵀ y for columns of P from `first` on (n, k)."""
    indptr, indices, width = product.indptr, product.indices, y.shape[1]
    for j in range(np.uint64(out.shape[0])):
        for c in range(width):
            total = out[j, c]
            for entry in range(indptr[first + j], indptr[first + j + ONE]):
                total += numbers[entry] * y[indices[entry], c]
            out[j, c] = total


@compiled
def predict(scheme: Scheme, h: float, own: Array, work: Work) -> None:
    """The changes of q, v and x at the end of a step, if that of a₁ were zero."""
    size = len(work.x)
    q, v, a, x = own[:size], own[size : 2 * size], own[2 * size : 3 * size], own[len(own) - size :]
    share_m, share_f = scheme.alpha_m / (1.0 - scheme.alpha_m), scheme.alpha_f / (1.0 - scheme.alpha_m)
    new_q, new_v, new_x = work.moved[:size], work.moved[size:], work.x
    for k in range(size):
        new_x[k] = share_f * a[k] - share_m * x[k]
    for k in range(size):
        new_v[k] = v[k] + h * ((1.0 - scheme.gamma) * x[k] + scheme.gamma * new_x[k])
    for k in range(size):
        new_q[k] = q[k] + h * v[k] + h * h * ((0.5 - scheme.beta) * x[k] + scheme.beta * new_x[k])


@compiled
def correct(change: Array, beta: float, gamma: float, kappa: float, own: Array, work: Work) -> None:
    """Put the change of the state at the end of the step in place of that at its start."""
    size = len(work.x)
    q, v, x = own[:size], own[size : 2 * size], own[len(own) - size :]
    new_q, new_v, new_x = work.moved[:size], work.moved[size:], work.x
    for k in range(size):
        q[k] = beta * change[k] + new_q[k]
    for k in range(size):
        v[k] = gamma * change[k] + new_v[k]
    for k in range(size):
        x[k] = kappa * change[k] + new_x[k]
    rest = own[2 * size : len(own) - size]
    for k in range(len(rest)):
        rest[k] = change[k]


@compiled
def forward_step(
    scheme: Scheme, record: Record, n: int, p: int, matrix: Factors, by_rows: ByRows, block: Block, work: Work,
    own: Array, sources: Sources,
) -> bool:  # fmt: skip
    """The change of the state of a panel p over step n; false if pivots must be renewed."""
    lane, h, kappa = block.lanes.next, record.h[n], (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    beta, gamma = weights_of(scheme, h)
    right, size = work.right, len(work.x)
    predict(scheme, h, own, work)
    apply(block.product, block.turned[lane, block.cuts.product :], work.moved, right)
    flat = right.reshape(right.shape[0] * right.shape[1])
    for k in range(size, len(flat)):
        flat[k] *= -1.0 / beta
    subtract_moved(block.moved, lane, p, size, 1.0 / beta, flat)
    subtract(sources.step, n, p, right)
    solved_rows(record, n, right)
    own_factors = factors_of(matrix, block, lane)
    told = block.refined, block.growth[lane], lane > 0
    if not solve_lane(own_factors, by_rows, *told, right, work.solution, work.room) <= work.progress.trusted:
        return False
    correct(work.solution.reshape(len(flat)), beta, gamma, kappa, own, work)
    return True


@compiled
def forward_panels(
    scheme: Scheme, record: Record, n: int, matrix: Factors, by_rows: ByRows, block: Block, work: Work,
    state: Array, sources: Sources,
) -> bool:  # fmt: skip
    """Step n of all panels that have not made it; false if pivots must be renewed."""
    while work.progress.panels < len(state):
        p = work.progress.panels
        if not forward_step(scheme, record, n, p, matrix, by_rows, block, work, state[p], sources):
            return False
        work.progress.panels += 1
    work.progress.panels = 0
    block.lanes.next += 1
    return True


@compiled
def subtract_moved(moved: Moved, lane: int, p: int, below: int, weight: float, right: Array) -> None:
    """Right -= what the changes of the numbers do in a lane, with a weight of places from `below` on."""
    for k in range(moved.ends[p], moved.ends[p + 1]):
        at = moved.places[k]
        right[at] -= moved.results[k * LANES + lane] * (1.0 if at < below else weight)


@compiled
def subtract(sources: Array, n: int, p: int, right: Array) -> None:
    """Right -= sources of step n (n, nq + m, columns) for panel p, if there are any."""
    if len(sources) > 0:
        first = p * right.shape[1]
        for k in range(right.shape[0]):
            for c in range(min(right.shape[1], sources.shape[2] - first)):
                right[k, c] -= sources[n, k, first + c]


@compiled
def backward_step(
    scheme: Scheme, record: Record, n: int, matrix: Factors, block: Block, work: Work, bars: Bars, kept: Kept,
    sources: Sources,
) -> bool:  # fmt: skip
    """From the gradients by the end of step n to those by its start; false if pivots must be renewed."""
    lane, h, kappa = block.lanes.next, record.h[n], (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
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
    own, told = factors_of(matrix, block, lane), (block.refined, block.growth[lane])
    if not solve_lane_transposed(own, *told, right, mu, work.room) <= work.progress.trusted:
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
    block.lanes.next += 1
    return True


@compiled
def put_adjoint(block: Block, lane: int, mu: Array, sign: float) -> None:
    """ξ and ν of a lane: those in μ, the latter times a sign."""
    nq, m = len(block.q) // LANES, len(block.lam) // LANES
    for c in range(mu.shape[1]):
        for k in range(nq):
            block.xi[c, k * LANES + lane] = mu[k, c]
        for k in range(m):
            block.nu[c, k * LANES + lane] = sign * mu[nq + k, c]


@compiled
def forward_rescale(
    record: Record, n: int, p: int, matrix: Factors, by_rows: ByRows, block: Block, work: Work, own: Array,
    kept: Kept, sources: Sources,
) -> bool:  # fmt: skip
    """The change of the velocities of a panel p by the new step size of step n; false if pivots must be renewed."""
    lane, right, size = block.lanes.next, work.right, len(work.x)
    apply(block.product, block.turned[lane, block.cuts.product :], own[: 2 * size], right)
    subtract_moved(block.moved, lane, p, size, 1.0, right.reshape(right.shape[0] * right.shape[1]))
    subtract(sources.rescale, n, p, right)
    solved_rows(record, n, right)
    own_factors = factors_of(matrix, block, lane)
    told = block.refined, block.growth[lane], lane > 0
    if not solve_lane(own_factors, by_rows, *told, right, work.solution, work.room) <= work.progress.trusted:
        return False
    change = work.solution.reshape(right.shape[0] * right.shape[1])
    if len(kept.rescale) > 0:
        put_panel(change, p, right.shape[1], kept.rescale[n])
    v = own[size : 2 * size]
    for k in range(size):
        v[k] -= record.removed[n] * change[k]
    return True


@compiled
def forward_rescales(
    record: Record, n: int, matrix: Factors, by_rows: ByRows, block: Block, work: Work, state: Array,
    kept: Kept, sources: Sources,
) -> bool:  # fmt: skip
    """The change of the size of step n for all panels that have not made it; false if pivots must be renewed."""
    while work.progress.panels < len(state):
        p = work.progress.panels
        if not forward_rescale(record, n, p, matrix, by_rows, block, work, state[p], kept, sources):
            return False
        work.progress.panels += 1
    work.progress.panels = 0
    block.lanes.next += 1
    return True


@compiled
def put_panel(panel: Array, p: int, width: int, out: Array) -> None:
    """The columns of panel p in their place (n, columns)."""
    first = p * width
    whole = width > 1 and first + width <= out.shape[1]
    for k in range(np.uint64(out.shape[0])):
        if whole:
            row = out[k, first:]
            store(row, np.uint64(0), load(panel, k * TWO))
            store(row, ONE, load(panel, k * TWO + ONE))
        else:
            for c in range(min(width, out.shape[1] - first)):
                out[k, first + c] = panel[k * width + c]


@compiled
def backward_rescale(
    record: Record, n: int, matrix: Factors, block: Block, work: Work, bars: Bars, kept: Kept, sources: Sources,
) -> bool:  # fmt: skip
    """From the gradients by the state after the new step size of step n to those before; false for new pivots."""
    lane, right, z = block.lanes.next, work.right, work.solution
    nq, m, width = bars.q.shape[0], bars.lam.shape[0], bars.q.shape[1]
    for k in range(nq):
        for c in range(width):
            right[k, c] = -record.removed[n] * bars.v[k, c]
    right[nq:] = 0.0
    if len(sources.rescale) > 0:
        for k in range(nq + m):
            right[k, 0] -= sources.rescale[n, k]
    own, told = factors_of(matrix, block, lane), (block.refined, block.growth[lane])
    if not solve_lane_transposed(own, *told, right, z, work.room) <= work.progress.trusted:
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
    block.lanes.next += 1
    return True


@compiled
def add_gradients(given: Given, row: int, bars: Bars) -> None:
    """Add what responses take from one node."""
    add(given.q[row], bars.q)
    add(given.v[row], bars.v)
    add(given.a[row], bars.a)
    add(given.lam[row], bars.lam)


@compiled
def begin(scheme: Scheme, steps: Block, rescales: Block) -> None:
    """Blocks of nothing."""
    limit = PLAIN if scheme.gamma - 0.5 > DAMPS else 0.0
    steps.lanes.used = steps.lanes.next = rescales.lanes.used = rescales.lanes.next = 0
    steps.refined.limit = rescales.refined.limit = limit


@compiled(entry=True)
def backward(
    scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, first: int, stage: int, matrix: Factors,
    by_rows: ByRows, steps: Block, rescales: Block, work: Work, bars: Bars, given: Given, kept: Kept,
    sources: Sources,
) -> tuple[int, int]:  # fmt: skip
    """From the end of step n to the start of step `first`; returns (n, stage) of what needs new pivots.

    `given` holds the gradients of responses by the ends of the steps, one row for each.
    """
    begin(scheme, steps, rescales)
    while n >= first:
        if stage == GRADIENTS:
            add_gradients(given, n - first, bars)
            stage = STEP
        if stage == STEP:
            if steps.lanes.next == steps.lanes.used:
                finish(b, record, steps)
                linearize_steps(scheme, entries, b, record, n, first, -1, matrix, steps)
            if not backward_step(scheme, record, n, matrix, steps, work, bars, kept, sources):
                break
            stage = RESCALE
        if record.removed[n] != 0.0:
            if rescales.lanes.next == rescales.lanes.used:
                finish(b, record, rescales)
                if not linearize_rescales(entries, b, record, n, first, -1, matrix, by_rows, rescales, work):
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


@compiled
def choose_gradients(weighed: Weighed, row: int) -> None:
    """Of the gradients of responses by the state of one node those that are not zero."""
    by, count, nq = weighed.by, 0, weighed.by.q.shape[1]
    for r in range(by.q.shape[2]):
        count = choose(by.q[row], r, 0, weighed, count)
        count = choose(by.v[row], r, nq, weighed, count)
        count = choose(by.a[row], r, 2 * nq, weighed, count)
        count = choose(by.lam[row], r, 3 * nq, weighed, count)
        weighed.ends[r + 1] = count


@compiled
def choose(gradient: Array, r: int, first: int, weighed: Weighed, count: int) -> int:
    """Of those by one kind of states, which begin at a row; how many there are then."""
    for k in range(gradient.shape[0]):
        value = gradient[k, r]
        if value != 0.0:
            weighed.rows[count], weighed.values[count] = first + k, value
            count += 1
    return count


@compiled
def weigh_panel(weighed: Weighed, p: int, width: int, own: Array) -> None:
    """Add the change of responses by that of the state of panel p."""
    total = weighed.total[p]
    for r in range(np.uint64(len(weighed.ends) - 1)):
        first, last = weighed.ends[r], weighed.ends[r + ONE]
        if width == 1:
            for k in range(first, last):
                total[r] += weighed.values[k] * own[weighed.rows[k]]
        else:
            a, b = load(total, r * TWO), load(total, r * TWO + ONE)
            for k in range(first, last):
                value, row = fill(weighed.values[k]), weighed.rows[k] * TWO
                a, b = (
                    plus_product(a, value, load(own, row)),
                    plus_product(b, value, load(own, row + ONE)),
                )
            store(total, r * TWO, a)
            store(total, r * TWO + ONE, b)


@compiled
def put_node(row: int, nq: int, width: int, state: Array, given: Given, weighed: Weighed) -> None:
    """What is asked for at a node: derivatives of its state, or what they do to responses."""
    if len(weighed.by.q) > 0:
        choose_gradients(weighed, row)
    for p in range(len(state)):
        if len(weighed.by.q) > 0:
            weigh_panel(weighed, p, width, state[p])
        if len(given.q) > 0:
            put_state(state[p], p, nq, width, given, row)


@compiled
def put_state(own: Array, p: int, nq: int, width: int, given: Given, row: int) -> None:
    """The derivatives of a state in panel p in their place."""
    size = nq * width
    put_panel(own[:size], p, width, given.q[row])
    put_panel(own[size : 2 * size], p, width, given.v[row])
    put_panel(own[2 * size : 3 * size], p, width, given.a[row])
    put_panel(own[3 * size : len(own) - size], p, width, given.lam[row])


@compiled
def lengthen(ratio: float, size: int, state: Array) -> None:
    """x follows the step size."""
    for p in range(len(state)):
        a, x = state[p, 2 * size : 3 * size], state[p, state.shape[1] - size :]
        for k in range(size):
            x[k] = a[k] + ratio * (x[k] - a[k])


@compiled(entry=True)
def forward(
    scheme: Scheme, entries: Entries, b: Array, record: Record, n: int, last: int, stage: int, matrix: Factors,
    by_rows: ByRows, steps: Block, rescales: Block, work: Work, state: Array, given: Given, weighed: Weighed,
    kept: Kept, sources: Sources,
) -> tuple[int, int]:  # fmt: skip
    """From the start of step n to that of step `last`; returns (n, stage) of what needs new pivots.

    `state` are the derivatives of q, v, a, λ and x in panels (panels, (4 nq + m) width). `given` takes them, a row for
    each step; of gradients in `weighed` there is one row for each, too.
    """
    start, nq, width = last - max(len(given.q), len(weighed.by.q)), record.q.shape[1], work.right.shape[1]
    begin(scheme, steps, rescales)
    while n < last:
        if stage == RESCALE:
            if record.removed[n] != 0.0:
                if rescales.lanes.next == rescales.lanes.used and not linearize_rescales(
                    entries, b, record, n, last - 1, 1, matrix, by_rows, rescales, work
                ):
                    break
                if not forward_rescales(record, n, matrix, by_rows, rescales, work, state, kept, sources):
                    break
            if n > 0 and record.h[n] != record.h[n - 1]:
                lengthen(record.h[n] / record.h[n - 1], nq * width, state)
            stage = STEP
        if steps.lanes.next == steps.lanes.used:
            linearize_steps(scheme, entries, b, record, n, last - 1, 1, matrix, steps)
        if not forward_panels(scheme, record, n, matrix, by_rows, steps, work, state, sources):
            break
        put_node(n - start, nq, width, state, given, weighed)
        n, stage = n + 1, RESCALE
    return n, stage
