"""Coordinates of joints and their rates along a motion: one function that is compiled."""

from __future__ import annotations

from ..._jit.kernels.pointer import KernelTable, call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array


@compiled(entry=True)
def evaluate(
    residual: KernelTable, velocity: KernelTable, b: Array, t: Array, q: Array, v: Array, values: Array,
    rates: Array, lam: Array, force: Array, Phi_t: Array,
) -> None:  # fmt: skip
    """Fill `values` and `rates` (nt, nc); the kernels give Φ beside Φ_qᵀλ, and Φ_q v beside Φ_t."""
    for n in range(len(t)):
        call_kernels(residual, b, t[n], q[n], lam, values[n], force)
        call_kernels(velocity, b, t[n], q[n], v[n], rates[n], Phi_t)
