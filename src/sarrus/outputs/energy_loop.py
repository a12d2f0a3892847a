"""Energies of all elements along a motion, several states at once, as functions that are compiled."""

from __future__ import annotations

from typing import Any

from .._jit.link import compiled
from .._jit.pointer import call_kernels


@compiled(entry=True)
def slopes(entry: Any, b: Any, t: Any, q: Any, v: Any, value: Any, by_q: Any, by_v: Any, by_b: Any) -> None:
    """Values and gradients of all blocks; what is given stands in lanes, a block in every row."""
    for n in range(len(t)):
        call_kernels(entry, b, t[n], q[n], v[n], value[n], by_q[n], by_v[n], by_b[n])


@compiled(entry=True)
def turns(
    entry: Any, b: Any, t: Any, q: Any, v: Any, q_dot: Any, v_dot: Any, b_dot: Any, by_q: Any, by_v: Any, by_b: Any
) -> None:  # fmt: skip
    """The changes of the gradients."""
    for n in range(len(t)):
        call_kernels(entry, b, t[n], q[n], v[n], q_dot[n], v_dot[n], b_dot, by_q[n], by_v[n], by_b[n])
