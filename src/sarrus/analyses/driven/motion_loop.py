"""The motion of a fully driven system from time to time: position, velocity, acceleration; functions that are compiled.

Φ(q, t) = 0 by Newton's method, Φ_q v = -Φ_t and Φ_q a = γ, Eqs. (2) to (4), with the factors of as many independent
equations as there are coordinates. `Path` explains the constants' use, and Python takes over where a step is unusual.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.kernels.pointer import KernelTable, call_kernels
from ..._jit.kernels.scalars import Scalars
from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import INFINITE, Entries, Samples, Work, energies, size_of
from ..dynamics.dense_output.winding_loop import Work as WindingWork
from ..dynamics.dense_output.winding_loop import count
from ..equations.block_matrix import PRECISE, Assembler, backsolve, backsolve_transposed, refactor
from ..equations.minimum_norm import Omissions, gradient, shorten
from ..equations.projection import ROUND_OFF

OPEN, FOUND, MISSED, PIVOTS, CROSSED, STUCK, PAUSED = range(7)
CHUNK = 100  # times for one call
ITERATIONS = 12
CONTRACTION = 0.5  # each Newton step must be so much shorter than the one before
SETTLED = 1e-11  # a last Newton step, relative to the size of q, whose square is below round-off
JUMP = 0.1  # farthest that Newton may go from the predicted place: Euler parameters, and parts of the model's size
SINGULAR = 1e-5  # smallest singular value, below which Newton's method finds only half of the digits
SHORTEST = 1e-6  # of a grid interval: steps are halved down to this before a lock-up is looked for
ROUNDS = 6  # of inverse iteration; the smallest singular value is needed to one digit
TOLERANCE, ACCEPTED = 1e-13, 1e-10  # of |Φ| as in `constraint_projection`


class Control(Scalars):
    """Scalars of a driven motion.

    t, sign : of the state reached: time, sign of the Jacobian's determinant, 0 on a singular configuration
    t_found, sign_found : of the state that a step found
    h, interval : next step, time from grid point to grid point
    least : pivot over column, below which the order of the pivots is chosen anew
    parity : of the orders of rows and columns
    verdict : FOUND or MISSED, where Python has decided on a step, or OPEN
    next : grid time to reach
    """

    t: float
    sign: float
    t_found: float
    sign_found: float
    h: float
    interval: float
    least: float
    parity: float
    verdict: int
    next: int
    steps: int
    iterations: int


class State(NamedTuple):
    """Coordinates, velocities and accelerations (nq,)."""

    q: Array
    v: Array
    a: Array


class Jacobian(NamedTuple):
    """Φ_q at a state, and the factors of the chosen equations.

    Attributes
    ----------
    values : what the matrix is assembled of, with the numbers `Phi_q` among them
    chosen : (nq,) places of the equations in Φ
    others : the equations that are left out, with the pattern of Φ_q
    by_r, by_p, terms : (m,) squared norms of the derivatives by displacements and Euler parameters, and Σ |Φ_q| |q|
    limits : (m,) of |Φ|
    force, answer, weak, direction : (nq,) work arrays; left and right direction of the smallest singular value
    is_length : which coordinates are displacements (nq,)
    length : their unit, the extent of the model
    """

    values: Array
    Phi_q: Array
    placed: Assembler
    chosen: Array
    others: Omissions
    by_r: Array
    by_p: Array
    terms: Array
    limits: Array
    force: Array
    answer: Array
    weak: Array
    direction: Array
    is_length: Array
    length: float


class Joints(NamedTuple):
    """Kernels and parameters of the joints' coordinates, and two states between which revolutions are counted."""

    residual: KernelTable
    velocity: KernelTable
    b: Array
    angles: Array
    last: Array
    work: WindingWork
    t: Array
    q: Array
    v: Array
    revolutions: Array


class Solver(NamedTuple):
    """All that a step needs."""

    entries: Entries
    b: Array
    places: Array
    jacobian: Jacobian
    joints: Joints
    work: Work
    now: State
    found: State


@compiled
def measure(J: Jacobian, q: Array) -> None:
    """The norms of the rows of Φ_q at q."""
    others = J.others
    for row in range(len(J.by_r)):
        by_r, by_p, terms = 0.0, 0.0, 0.0
        for entry in range(others.first[row], others.first[row + 1]):
            column, number = others.columns[entry], J.Phi_q[entry]
            terms += abs(number) * abs(q[column])
            if J.is_length[column]:
                by_r += number * number
            else:
                by_p += number * number
        J.by_r[row], J.by_p[row], J.terms[row] = by_r, by_p, terms


@compiled
def limit(J: Jacobian, q: Array, tolerance: float) -> None:
    """The largest |Φ| that is allowed, see `closure.allowed`."""
    measure(J, q)
    for row in range(len(J.limits)):
        size = J.length * math.sqrt(J.by_r[row]) if J.by_r[row] > 0.0 else math.sqrt(J.by_p[row])
        J.limits[row] = max(tolerance * (size if size > 0.0 else 1.0), ROUND_OFF * J.terms[row])


@compiled
def closed(Phi: Array, limits: Array) -> bool:
    """Whether every equation is satisfied."""
    satisfied = True
    for row in range(len(Phi)):
        satisfied = satisfied and abs(Phi[row]) <= limits[row]
    return satisfied


@compiled
def solve(J: Jacobian, g: Array, sign: float, x: Array) -> None:
    """x with Φ_q x = ± g, from the chosen equations."""
    for k in range(len(J.chosen)):
        J.force[k] = sign * g[J.chosen[k]]
    backsolve(J.placed, J.force, x)


@compiled
def position(solver: Solver, t: float, q: Array, control: Control) -> int:
    """Newton's method onto Φ(q, t) = 0. Φ_q at the position that is reached is left to what follows."""
    entries, b, J, work = solver.entries, solver.b, solver.jacobian, solver.work
    before, ended = INFINITE, False
    for iteration in range(ITERATIONS + 1):
        call_kernels(entries.jacobian, b, t, q, J.Phi_q)
        call_kernels(entries.residual, b, t, q, work.weak, work.Phi, work.Phi_qT_lam)
        if iteration == 0:
            limit(J, q, TOLERANCE)
        if ended or iteration == ITERATIONS or closed(work.Phi, J.limits):
            break
        if not refactor(J.values, J.placed) > control.least:
            return PIVOTS
        solve(J, work.Phi, -1.0, J.answer)
        control.iterations += 1
        for k in range(len(q)):
            q[k] += J.answer[k]
        size = size_of(J.answer, J.is_length, J.length)
        ended = size <= SETTLED or not size <= CONTRACTION * before
        before = size
    if closed(work.Phi, J.limits):
        return FOUND
    limit(J, q, ACCEPTED)
    return FOUND if closed(work.Phi, J.limits) else MISSED


@compiled(entry=True)
def sign_of(J: Jacobian, parity: float) -> float:
    """The sign of the determinant of the chosen equations."""
    sign, placed = parity, J.placed
    for k in range(len(placed.diagonal)):
        if placed.factors[placed.diagonal[k]] < 0.0:
            sign = -sign
    return sign


@compiled(entry=True)
def weakest(J: Jacobian, q: Array) -> float:
    """The smallest singular value of the chosen equations, scaled to unit length, displacements measured in `length`.

    Leaves multipliers of the chosen equations for which Φ_qᵀ lam nearly vanishes in `weak`, a direction in `direction`.
    """
    n, size, norm = len(q), 1.0, 0.0
    measure(J, q)
    x, y = J.direction, J.weak
    for k in range(n):
        x[k] = math.cos(k + 1.0)
        norm += x[k] * x[k]
    for k in range(n):
        x[k] /= math.sqrt(norm) * (J.length if J.is_length[k] else 1.0)
    for _ in range(ROUNDS):
        backsolve_transposed(J.placed, x, y)
        norm = 0.0
        for k in range(n):
            row = J.chosen[k]
            norm += y[k] * y[k] * (J.length * J.length * J.by_r[row] + J.by_p[row])
        for k in range(n):
            row = J.chosen[k]
            y[k] /= math.sqrt(norm)
            J.force[k] = y[k] * (J.length * J.length * J.by_r[row] + J.by_p[row])
        backsolve(J.placed, J.force, x)
        norm = 0.0
        for k in range(n):
            x[k] /= J.length if J.is_length[k] else 1.0
            norm += x[k] * x[k]
        size = 1.0 / math.sqrt(norm)
        for k in range(n):
            x[k] *= size / (J.length if J.is_length[k] else 1.0)
    return size


@compiled(entry=True)
def instant(solver: Solver, t: float, found: State, control: Control) -> int:
    """The state at a time, from coordinates nearby, in place."""
    entries, b, J, work, q = solver.entries, solver.b, solver.jacobian, solver.work, found.q
    outcome = position(solver, t, q, control)
    if outcome != FOUND:
        return outcome
    if not refactor(J.values, J.placed) > control.least:
        return PIVOTS
    call_kernels(entries.velocity, b, t, q, q, work.rate, work.Phi_t)
    solve(J, work.Phi_t, -1.0, found.v)
    call_kernels(entries.gamma, b, t, q, found.v, work.gamma)
    solve(J, work.gamma, 1.0, found.a)
    for k in range(len(q)):
        if not math.isfinite(found.v[k] + found.a[k]):
            return MISSED
    control.t_found, control.sign_found = t, 0.0
    if weakest(J, q) > SINGULAR:
        control.sign_found = sign_of(J, control.parity)
    return FOUND


@compiled(entry=True)
def step(solver: Solver, t: float, control: Control) -> int:
    """From the state reached to a later or earlier time."""
    now, found, h = solver.now, solver.found, t - control.t
    for k in range(len(now.q)):
        found.q[k] = now.q[k] + h * (now.v[k] + 0.5 * h * now.a[k])
    outcome = instant(solver, t, found, control)
    if outcome != FOUND:
        return outcome
    J, answer = solver.jacobian, solver.jacobian.answer
    for k in range(len(now.q)):
        answer[k] = found.q[k] - (now.q[k] + h * (now.v[k] + 0.5 * h * now.a[k]))
    far = size_of(answer, J.is_length, J.length) > JUMP
    return MISSED if far or control.sign_found == 0.0 else FOUND


@compiled
def accept(solver: Solver, control: Control) -> None:
    """Go on from the state that was found."""
    now, found, joints, work = solver.now, solver.found, solver.joints, solver.work
    joints.t[0], joints.t[1] = control.t, control.t_found
    for k in range(len(now.q)):
        joints.q[0, k], joints.v[0, k] = now.q[k], now.v[k]
        now.q[k], now.v[k], now.a[k] = found.q[k], found.v[k], found.a[k]
        joints.q[1, k], joints.v[1, k] = now.q[k], now.v[k]
    control.t, control.sign, control.least = control.t_found, control.sign_found, PRECISE
    count(joints.residual, joints.velocity, joints.b, joints.angles, joints.t, joints.q, joints.v, joints.last,
          joints.revolutions, joints.work)  # fmt: skip
    if len(solver.places):
        call_kernels(solver.entries.remember, solver.b, control.t, now.q, work.memory)
        for k in range(len(solver.places)):
            solver.b[solver.places[k]] = work.memory[k]
    control.steps += 1


@compiled
def multipliers(solver: Solver, t: float, lam: Array) -> None:
    """λ of M a + Φ_qᵀλ = Q + S, the shortest where equations are redundant, with the factors of the state reached."""
    entries, b, J, work, now = solver.entries, solver.b, solver.jacobian, solver.work, solver.now
    n, others = len(now.q), J.others
    call_kernels(entries.momentum, b, now.q, now.v, now.a, work.M_a, work.S)
    call_kernels(entries.force, b, t, now.q, now.v, work.Q)
    for k in range(n):
        J.force[k] = work.Q[k] + work.S[k] - work.M_a[k]
    backsolve_transposed(J.placed, J.force, J.answer)
    for row in range(len(lam)):
        lam[row] = 0.0
    for k in range(n):
        lam[J.chosen[k]] = J.answer[k]
    for other in range(len(others.rows)):
        for k in range(n):
            J.force[k] = 0.0
        gradient(others, others.rows[other], J.force)
        backsolve_transposed(J.placed, J.force, J.answer)
        for row in range(len(lam)):
            others.null[other, row] = 0.0
        others.null[other, others.rows[other]] = 1.0
        for k in range(n):
            others.null[other, J.chosen[k]] = -J.answer[k]
    shorten(others, b, now.q, lam)


@compiled
def record(solver: Solver, n: int, out: Samples, control: Control) -> None:
    """Store the state reached as the n-th; its multipliers are Python's on a singular configuration."""
    entries, b, work, now, t = solver.entries, solver.b, solver.work, solver.now, control.t
    for k in range(len(now.q)):
        out.q[n, k], out.v[n, k], out.a[n, k] = now.q[k], now.v[k], now.a[k]
    for k in range(len(solver.places)):
        out.memory[n, k] = b[solver.places[k]]
    for k in range(len(solver.joints.angles)):
        out.revolutions[n, k] = solver.joints.revolutions[1, k]
    if control.sign != 0.0:
        multipliers(solver, t, out.lam[n])
    call_kernels(entries.residual, b, t, now.q, out.lam[n], work.Phi, work.Phi_qT_lam)
    call_kernels(entries.velocity, b, t, now.q, now.v, work.rate, work.Phi_t)
    for row in range(len(work.Phi)):
        out.violation[n, 0] = max(out.violation[n, 0], abs(work.Phi[row]))
        out.violation[n, 1] = max(out.violation[n, 1], abs(work.rate[row] + work.Phi_t[row]))
    energies(entries, b, t, now.q, now.v, work, out.energy[n])


@compiled(entry=True)
def advance(solver: Solver, out: Samples, control: Control) -> int:
    """Go on to the next times of `out`, at most `CHUNK`, and record them; returns why it stops.

    After CROSSED, where the determinant changed its sign, PIVOTS and STUCK, Python gives a verdict on the step.
    """
    last = min(control.next + CHUNK, len(out.t))
    while control.next < last:
        target = out.t[control.next]
        while control.t < target:
            outcome, control.verdict = control.verdict, OPEN
            if outcome == OPEN:
                t = target if control.h >= 0.999 * (target - control.t) else control.t + control.h
                outcome = step(solver, t, control)
                if outcome == PIVOTS:
                    return PIVOTS
                if outcome == FOUND and control.sign_found * control.sign < 0.0:
                    return CROSSED
            if outcome == FOUND:
                accept(solver, control)
                control.h *= 2.0
            elif control.h > SHORTEST * control.interval:
                control.h *= 0.5
            else:
                return STUCK
        record(solver, control.next, out, control)
        control.next += 1
        if control.next < len(out.t):
            control.interval = control.h = out.t[control.next] - target
    return PAUSED
