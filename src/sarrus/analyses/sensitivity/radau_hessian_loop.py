"""The changes of the equations of all steps of Radau IIA along a direction, as functions that are compiled.

With the adjoint variables w of the equations F of a stage (`radau_sweep_loop`), its share of wᵀF that is not linear is

    ℓ = [w₂ᵀ(M a + Φ_qᵀλ - Q - S) + w₃ᵀΦ] + [μᵀΦ_q w₁ + w₄ᵀ(Φ_q v + Φ_t)],

in both brackets one of those that `lagrangian` knows, "step" and "rate"; at a node it is "motion". The changes of its
gradient by a are one by the velocities: aᵢ = (Σⱼ (A⁻¹)ᵢⱼ vⱼ - σᵢ v₀) / h.
"""

from __future__ import annotations

from ..._jit.link import compiled
from ..._jit.pointer import Entry, call_kernels
from ..._jit.vector import LANES
from ...algebra import Array
from ..dynamics.radau_loop import Scheme
from .block_loop import put, remember
from .hessian_loop import Room, clear, take, take_rows
from .radau_sweep_loop import Given, Record, Turned


@compiled
def run(
    entry: Entry, b: Array, b_dot: Array, room: Room, v: Array, a: Array, eta: Array, v_dot: Array,
    a_dot: Array, eta_dot: Array,
) -> None:  # fmt: skip
    """The change of the gradient of ℓ, with these rates and accelerations."""
    call_kernels(
        entry, b, room.t, room.q, v, a, eta, room.q_dot, v_dot, a_dot, eta_dot, room.xi, room.lam, room.nu,
        room.lam_dot, b_dot, room.by_q, room.by_v, room.by_a, room.by_eta, room.by_lam, room.by_b,
    )  # fmt: skip


@compiled(entry=True)
def of_stages(
    scheme: Scheme, step: Entry, rate: Entry, b: Array, b_dot: Array, record: Record, v_dot: Array,
    moved: Array, adjoint: Array, room: Room, turned: Array, turned_v: Array,
) -> None:  # fmt: skip
    """What the change of the adjoint takes at every step, the stages in lanes.

    v_dot (n + 1, nq) and moved (n, 6 (nq + m)) are the changes of velocities at nodes and of unknowns, adjoint (n, 6
    (nq + m)) the adjoint variables; turned (n, 6 (nq + m)) and turned_v (n, nq) take the result, room.by_b that by the
    numbers.
    """
    nq, m = record.q.shape[1], record.lam.shape[1]
    size = 2 * (nq + m)
    for n in range(len(record.h)):
        room.steps[:], h = n, record.h[n]
        remember(b, record, room)
        clear(room)
        for lane in range(LANES):
            i, used = (lane, 1.0) if lane < 3 else (0, 0.0)
            own, w = moved[n, i * size : (i + 1) * size], adjoint[n, i * size : (i + 1) * size]
            room.t[lane] = record.t[n] + scheme.c[i] * h
            put(record.stage_q[n, i], lane, 1.0, room.q)
            put(record.stage_v[n, i], lane, 1.0, room.v)
            put(record.stage_a[n, i], lane, 1.0, room.a)
            put(record.stage_lam[n, i], lane, 1.0, room.lam)
            put(own[:nq], lane, 1.0, room.q_dot)
            put(own[nq : 2 * nq], lane, 1.0, room.v_dot)
            put(own[2 * nq : 2 * nq + m], lane, 1.0, room.lam_dot)
            put(w[nq : 2 * nq], lane, used, room.xi)
            put(w[2 * nq : 2 * nq + m], lane, used, room.nu)
            for k in range(nq):
                total = 0.0
                for j in range(3):
                    total += scheme.inverse[i, j] * (moved[n, j * size + nq + k] - v_dot[n, k])
                room.a_dot[k * LANES + lane] = total / h
        run(step, b, b_dot, room, room.v, room.a, room.none, room.v_dot, room.a_dot, room.none)
        for i in range(3):
            at = i * size
            take(room.by_q, i, 1.0, turned[n, at:])
            take(room.by_v, i, 1.0, turned[n, at + nq :])
            take_rows(record, n, room.by_lam, i, turned[n, at + 2 * nq :])
            for j in range(3):
                take(room.by_a, i, scheme.inverse[i, j] / h, turned[n, j * size + nq :])
                take(room.by_a, i, -scheme.inverse[i, j] / h, turned_v[n])
        clear(room)
        for lane in range(3):
            own, w = moved[n, lane * size : (lane + 1) * size], adjoint[n, lane * size : (lane + 1) * size]
            put(record.stage_mu[n, lane], lane, 1.0, room.lam)
            put(own[2 * nq + m :], lane, 1.0, room.lam_dot)
            put(w[:nq], lane, 1.0, room.xi)
            put(w[2 * nq + m :], lane, -1.0, room.nu)
        run(rate, b, b_dot, room, room.none, room.none, room.v, room.none, room.none, room.v_dot)
        for i in range(3):
            at = i * size
            take(room.by_q, i, 1.0, turned[n, at:])
            take(room.by_eta, i, 1.0, turned[n, at + nq :])
            take_rows(record, n, room.by_lam, i, turned[n, at + 2 * nq + m :])


@compiled(entry=True)
def of_nodes(
    motion: Entry, b: Array, b_dot: Array, record: Record, dots: Given, adjoint: Array, room: Room,
    turned: Turned,
) -> None:  # fmt: skip
    """The same of the equations of motion at every node."""
    nq = record.q.shape[1]
    for n in range(len(record.t)):
        needed = False
        for k in range(adjoint.shape[1]):
            needed = needed or adjoint[n, k] != 0.0
        if not needed:
            continue
        before = max(n - 1, 0)
        room.steps[:] = before
        remember(b, record, room)
        clear(room)
        for lane in range(LANES):
            used = 1.0 if lane == 0 else 0.0
            room.t[lane] = record.t[n]
            put(record.q[n], lane, 1.0, room.q)
            put(record.v[n], lane, 1.0, room.v)
            put(record.a[n], lane, 1.0, room.a)
            put(record.lam[n], lane, 1.0, room.lam)
            put(dots.q[n], lane, 1.0, room.q_dot)
            put(dots.v[n], lane, 1.0, room.v_dot)
            put(dots.a[n], lane, 1.0, room.a_dot)
            put(dots.lam[n], lane, 1.0, room.lam_dot)
            put(adjoint[n, :nq], lane, used, room.xi)
            put(adjoint[n, nq:], lane, used, room.nu)
        run(motion, b, b_dot, room, room.v, room.a, room.none, room.v_dot, room.a_dot, room.none)
        take(room.by_a, 0, 1.0, turned.node[n])
        take_rows(record, before, room.by_lam, 0, turned.node[n, nq:])
        take(room.by_q, 0, 1.0, turned.node_q[n])
        take(room.by_v, 0, 1.0, turned.node_v[n])
