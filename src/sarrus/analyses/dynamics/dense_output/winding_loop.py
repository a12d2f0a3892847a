"""Angles of joints and rotations of bodies with their revolutions from state to state: one compiled function."""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled
from ....algebra import Array

REVOLUTION = 6.283185307179586


class Work(NamedTuple):
    """Operators' operands and outputs; `lam` and `force` are those of a kernel that gives Φ beside others.

    `before` are the rates of joints at the state before.
    """

    lam: Array
    Phi: Array
    force: Array
    rate: Array
    Phi_t: Array
    before: Array


@compiled
def count(
    residual: KernelTable, velocity: KernelTable, b: Array, angles: Array, t: Array, q: Array, v: Array, last: Array,
    full_revolutions: Array, work: Work,
) -> None:  # fmt: skip
    """Fill `full_revolutions` (nt, nc), those beyond Φ; `last` (nc,), the coordinates before, is replaced.

    An angle is taken nearest to the one before and the mean of both rates times the time between; a rotation of a body
    is taken nearest to the one before, since its rate is infinite where its axis is one of the body's.
    """
    for n in range(len(t)):
        k = max(n - 1, 0)
        call_kernels(velocity, b, t[n], q[n], v[n], work.rate, work.Phi_t)
        call_kernels(residual, b, t[n], q[n], work.lam, work.Phi, work.force)
        for c in range(len(work.Phi)):
            near, of_joint = last[c], c < len(work.before)
            if n > 0 and of_joint:
                near += 0.5 * (t[n] - t[k]) * (work.rate[c] + work.before[c])
            if angles[c]:
                full_revolutions[n, c] = round((near - work.Phi[c]) / REVOLUTION)
            last[c] = work.Phi[c] + REVOLUTION * full_revolutions[n, c]
            if of_joint:
                work.before[c] = work.rate[c]
