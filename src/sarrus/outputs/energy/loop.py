"""Energies of all elements along a motion, several states at once, as functions that are compiled."""

from __future__ import annotations

from ..._jit.kernels.pointer import KernelTable, call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array


@compiled(entry=True)
def slopes(
    entry: KernelTable,
    b: Array,
    t: Array,
    q: Array,
    v: Array,
    value: Array,
    by_q: Array,
    by_v: Array,
    by_b: Array,
) -> None:
    """Values and gradients of all blocks; the operands are in lanes, a block in every row."""
    for n in range(len(t)):
        call_kernels(entry, b, t[n], q[n], v[n], value[n], by_q[n], by_v[n], by_b[n])


@compiled(entry=True)
def gradients_along(
    entry: KernelTable, b: Array, t: Array, q: Array, v: Array, q_dot: Array, v_dot: Array, b_dot: Array, by_q: Array,
    by_v: Array, by_b: Array,
) -> None:  # fmt: skip
    """The changes of the gradients."""
    for n in range(len(t)):
        call_kernels(entry, b, t[n], q[n], v[n], q_dot[n], v_dot[n], b_dot, by_q[n], by_v[n], by_b[n])
