"""The changes of the equations of all steps along a direction, one after another, as functions that are compiled."""

from __future__ import annotations

from typing import Any, NamedTuple

RUN: Any = None  # calls the drivers of `Lagrangian`, put in place when this is compiled


class Room(NamedTuple):
    """Operands and results of one call: see `Lagrangian`. `none` stays zero, `lam` holds λ, ν and the change of λ."""

    none: Any
    lam: Any
    s: Any
    s_dot: Any
    eta: Any
    eta_dot: Any
    by_q: Any
    by_v: Any
    by_a: Any
    by_eta: Any
    by_lam: Any


class Places(NamedTuple):
    """Where what elements remember stands among the numbers, and where λ, ν and the change of λ stand (3, m)."""

    memory: Any
    rows: Any


def begin(n: Any, numbers: Any, places: Any, record: Any, room: Any) -> None:
    """What elements remembered during step n; results begin with zero."""
    for k in range(len(places.memory)):
        numbers[places.memory[k]] = record.memory[n, k]
    for k in range(len(room.by_q)):
        room.by_q[k] = room.by_v[k] = room.by_a[k] = room.by_eta[k] = 0.0
    for k in range(len(room.by_lam)):
        room.by_lam[k] = 0.0


def solved_rows(n: Any, record: Any, rows: Any, out: Any) -> None:
    """The rows of the equations that are solved; the others have none."""
    for k in range(len(rows)):
        out[k] = rows[k] if len(record.left_out) == 0 or record.left_out[n + 1, k] == 0.0 else 0.0


def of_steps(
    scheme: Any, entry: Any, numbers: Any, places: Any, record: Any, dots: Any, adjoint: Any, room: Any, sources: Any,
    by_b: Any,
) -> None:  # fmt: skip
    """Sources of the changes of the adjoint, of every step; what they add to the gradient by the numbers."""
    nq, m = len(room.by_q), len(room.by_lam)
    kappa = (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
    for n in range(len(record.h)):
        h = record.h[n]
        beta, gamma = scheme.beta * h * h * kappa, scheme.gamma * h * kappa
        begin(n, numbers, places, record, room)
        for k in range(m):
            room.lam[places.rows[0, k]] = record.lam[n + 1, k]
            room.lam[places.rows[1, k]] = adjoint.step[n, nq + k] / beta
            room.lam[places.rows[2, k]] = dots.lam[n + 1, k]
        RUN(
            entry, numbers, record.t[n + 1], record.q[n + 1], record.v[n + 1], record.a[n + 1], room.none,
            dots.q[n + 1], dots.v[n + 1], dots.a[n + 1], room.none, adjoint.step[n, :nq], room.lam,
            room.by_q, room.by_v, room.by_a, room.by_eta, room.by_lam, by_b,
        )  # fmt: skip
        for k in range(nq):
            sources.step[n, k] = room.by_a[k] + gamma * room.by_v[k] + beta * room.by_q[k]
            sources.step_q[n, k], sources.step_v[n, k] = room.by_q[k], room.by_v[k]
        solved_rows(n, record, room.by_lam, sources.step[n, nq:])


def of_rescales(
    entry: Any, numbers: Any, places: Any, record: Any, dots: Any, adjoint: Any, changed: Any, room: Any, sources: Any,
    by_b: Any,
) -> None:  # fmt: skip
    """The same of every new size of the steps."""
    nq, m = len(room.by_q), len(room.by_lam)
    for n in range(len(record.h)):
        if record.removed[n] == 0.0:
            continue
        begin(n, numbers, places, record, room)
        for k in range(m):
            room.lam[places.rows[0, k]] = adjoint.s[n, nq + k]
            room.lam[places.rows[1, k]] = adjoint.rescale[n, nq + k]
            room.lam[places.rows[2, k]] = changed[n, nq + k]
        for k in range(nq):
            room.s[k], room.s_dot[k] = adjoint.s[n, k], changed[n, k]
            room.eta[k] = record.v[n, k] - room.s[k]
            room.eta_dot[k] = dots.v[n, k] - room.s_dot[k]
        RUN(
            entry, numbers, record.t[n], record.q[n], room.none, room.s, room.eta, dots.q[n], room.none, room.s_dot,
            room.eta_dot, adjoint.rescale[n, :nq], room.lam,
            room.by_q, room.by_v, room.by_a, room.by_eta, room.by_lam, by_b,
        )  # fmt: skip
        for k in range(nq):
            sources.rescale[n, k] = room.by_a[k] - room.by_eta[k]
            sources.rescale_q[n, k], sources.rescale_v[n, k] = room.by_q[k], room.by_eta[k]
        solved_rows(n, record, room.by_lam, sources.rescale[n, nq:])
