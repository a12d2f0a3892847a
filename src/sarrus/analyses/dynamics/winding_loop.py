"""Angles of joints with their revolutions from state to state: one function that is compiled."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..._jit.link import compiled
from ..._jit.pointer import call_kernels

REVOLUTION = 6.283185307179586


class Work(NamedTuple):
    """Operators' operands and outputs; `lam` and `force` are those of a kernel that gives Φ beside others."""

    lam: Any
    Phi: Any
    force: Any
    rate: Any
    Phi_t: Any
    before: Any


@compiled(entry=True)
def count(
    residual: Any,
    velocity: Any,
    b: Any,
    angles: Any,
    t: Any,
    q: Any,
    v: Any,
    last: Any,
    turns: Any,
    work: Any,
) -> None:
    """Fill `turns` (nt, nc), the revolutions beyond Φ; `last` (nc,) holds the coordinates before and is replaced.

    An angle is taken nearest to the one before and the mean of both rates times the time between.
    """
    for n in range(len(t)):
        k = max(n - 1, 0)
        call_kernels(velocity, b, t[n], q[n], v[n], work.rate, work.Phi_t)
        call_kernels(residual, b, t[n], q[n], work.lam, work.Phi, work.force)
        for c in range(len(work.rate)):
            near = last[c]
            if n > 0:
                near += 0.5 * (t[n] - t[k]) * (work.rate[c] + work.before[c])
            if angles[c]:
                turns[n, c] = round((near - work.Phi[c]) / REVOLUTION)
            last[c] = work.Phi[c] + REVOLUTION * turns[n, c]
            work.before[c] = work.rate[c]
