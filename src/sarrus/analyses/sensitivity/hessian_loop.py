"""The changes of the equations of all steps along a direction, several at once, as functions that are compiled."""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.link import compiled
from ..._jit.pointer import Entry, call_kernels
from ..._jit.vector import LANES
from ...algebra import Array
from ..dynamics.alpha_loop import Scheme
from .block_loop import Lanes, Record, Remembered, collect, put, remember
from .lanes_loop import clear_lanes
from .sweep_loop import Given, Kept, Sources


class Room(NamedTuple):
    """Operands and results of one call, in lanes: see `lagrangian`. `none` stays zero.

    steps, lanes : the steps of the lanes, see `block_loop.Block`
    """

    steps: Array
    lanes: Lanes
    t: Array
    q: Array
    v: Array
    a: Array
    eta: Array
    q_dot: Array
    v_dot: Array
    a_dot: Array
    eta_dot: Array
    none: Array
    xi: Array
    lam: Array
    nu: Array
    lam_dot: Array
    by_q: Array
    by_v: Array
    by_a: Array
    by_eta: Array
    by_lam: Array
    by_b: Array


@compiled
def clear(room: Room) -> None:
    """Adjoint variables and results begin with zero."""
    clear_lanes(room.xi)
    clear_lanes(room.nu)
    clear_lanes(room.by_q)
    clear_lanes(room.by_v)
    clear_lanes(room.by_a)
    clear_lanes(room.by_eta)
    clear_lanes(room.by_lam)


@compiled
def take(x: Array, lane: int, weight: float, out: Array) -> None:
    """Out += weight x of a lane."""
    for k in range(len(x) // LANES):
        out[k] += weight * x[k * LANES + lane]


@compiled
def take_rows(record: Remembered, n: int, x: Array, lane: int, out: Array) -> None:
    """Out = x of a lane in the rows of the equations that are solved; the others have none."""
    for k in range(len(x) // LANES):
        solved = len(record.left_out) == 0 or record.left_out[n + 1, k] == 0.0
        out[k] = x[k * LANES + lane] if solved else 0.0


@compiled(entry=True)
def of_steps(
    scheme: Scheme, entry: Entry, b: Array, b_dot: Array, record: Record, dots: Given, adjoint: Kept,
    room: Room, sources: Sources,
) -> None:  # fmt: skip
    """Sources of the changes of the adjoint, of every step; what they add to the gradient by the numbers."""
    nq, kappa, first = record.q.shape[1], (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m), 0
    while first < len(record.h):
        collect(record, first, len(record.h) - 1, 1, False, room)
        remember(b, record, room)
        clear(room)
        for lane in range(LANES):
            n, used = room.steps[lane], 1.0 if lane < room.lanes.used else 0.0
            room.t[lane] = record.t[n + 1]
            put(record.q[n + 1], lane, 1.0, room.q)
            put(record.v[n + 1], lane, 1.0, room.v)
            put(record.a[n + 1], lane, 1.0, room.a)
            put(record.lam[n + 1], lane, 1.0, room.lam)
            put(dots.q[n + 1], lane, 1.0, room.q_dot)
            put(dots.v[n + 1], lane, 1.0, room.v_dot)
            put(dots.a[n + 1], lane, 1.0, room.a_dot)
            put(dots.lam[n + 1], lane, 1.0, room.lam_dot)
            put(adjoint.step[n, :nq], lane, used, room.xi)
            put(adjoint.step[n, nq:], lane, used / (scheme.beta * record.h[n] ** 2 * kappa), room.nu)
        call_kernels(
            entry, b, room.t, room.q, room.v, room.a, room.none, room.q_dot, room.v_dot, room.a_dot, room.none,
            room.xi, room.lam, room.nu, room.lam_dot, b_dot,
            room.by_q, room.by_v, room.by_a, room.by_eta, room.by_lam, room.by_b,
        )  # fmt: skip
        for lane in range(room.lanes.used):
            n = room.steps[lane]
            h = record.h[n]
            take(room.by_a, lane, 1.0, sources.step[n])
            take(room.by_v, lane, scheme.gamma * h * kappa, sources.step[n])
            take(room.by_q, lane, scheme.beta * h * h * kappa, sources.step[n])
            take(room.by_q, lane, 1.0, sources.step_q[n])
            take(room.by_v, lane, 1.0, sources.step_v[n])
            take_rows(record, n, room.by_lam, lane, sources.step[n, nq:])
        first += room.lanes.used


@compiled(entry=True)
def of_rescales(
    entry: Entry, b: Array, b_dot: Array, record: Record, dots: Given, adjoint: Kept, changed: Array,
    room: Room, sources: Sources,
) -> None:  # fmt: skip
    """The same of every new size of the steps."""
    nq, first, last = record.q.shape[1], 0, len(record.h) - 1
    while first <= last:
        if record.removed[first] == 0.0:
            first += 1
            continue
        collect(record, first, last, 1, True, room)
        remember(b, record, room)
        clear(room)
        for lane in range(LANES):
            n, used = room.steps[lane], 1.0 if lane < room.lanes.used else 0.0
            s, s_dot = adjoint.s[n, :nq], changed[n, :nq]
            room.t[lane] = record.t[n]
            put(record.q[n], lane, 1.0, room.q)
            put(s, lane, 1.0, room.a)
            put(adjoint.s[n, nq:], lane, 1.0, room.lam)
            put(dots.q[n], lane, 1.0, room.q_dot)
            put(s_dot, lane, 1.0, room.a_dot)
            put(changed[n, nq:], lane, 1.0, room.lam_dot)
            put(adjoint.rescale[n, :nq], lane, used, room.xi)
            put(adjoint.rescale[n, nq:], lane, used, room.nu)
            for k in range(nq):
                room.eta[k * LANES + lane] = record.v[n, k] - s[k]
                room.eta_dot[k * LANES + lane] = dots.v[n, k] - s_dot[k]
        call_kernels(
            entry, b, room.t, room.q, room.none, room.a, room.eta, room.q_dot, room.none, room.a_dot, room.eta_dot,
            room.xi, room.lam, room.nu, room.lam_dot, b_dot,
            room.by_q, room.by_v, room.by_a, room.by_eta, room.by_lam, room.by_b,
        )  # fmt: skip
        for lane in range(room.lanes.used):
            n = room.steps[lane]
            take(room.by_a, lane, 1.0, sources.rescale[n])
            take(room.by_eta, lane, -1.0, sources.rescale[n])
            take(room.by_q, lane, 1.0, sources.rescale_q[n])
            take(room.by_eta, lane, 1.0, sources.rescale_v[n])
            take_rows(record, n, room.by_lam, lane, sources.rescale[n, nq:])
        first = room.steps[room.lanes.used - 1] + 1
