"""Rates of the states in independent coordinates: a function that is compiled."""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.kernels.pointer import KernelTable, call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work
from ..equations.minimum_norm_loop import LeftOut
from ..equilibria.linear_loop import Coordinates
from .forward_loop import forward


class Measured(NamedTuple):
    """Kernels of c_q ξ and γ = c_q a - c̈ of coordinates that elements measure, their parameters, and work arrays."""

    along: KernelTable
    gamma: KernelTable
    b: Array
    rate: Array
    acceleration: Array
    bend: Array


@compiled
def state_rates(
    entries: Entries, work: Work, matrix: Matrix, others: LeftOut, measured: Measured, of: Coordinates, a: Array,
    lam: Array, least: float, b: Array, t: float, q: Array, v: Array, rates: Array,
) -> float:  # fmt: skip
    """Fill a, λ, and the rates of the states (nx,): ċ, c̈ = c_q a - γ, ṡ; if the pivots are trusted more than `least`.

    Returns
    -------
    how far the pivots can be trusted, -1 if vectors have other sizes
    """
    if len(rates) != 2 * len(of.row) + len(of.states):
        return -1.0
    trust = forward(entries, work, matrix, others, least, b, t, q, v, a, lam)
    if trust > least:
        n = len(of.row)
        call_kernels(measured.along, measured.b, t, q, v, measured.rate)
        call_kernels(measured.along, measured.b, t, q, a, measured.acceleration)
        call_kernels(measured.gamma, measured.b, t, q, v, measured.bend)
        for k in range(n):
            row, place = of.row[k], of.place[k]
            if row >= 0:
                rates[k], rates[n + k] = measured.rate[row], measured.acceleration[row] - measured.bend[row]
            else:
                rates[k], rates[n + k] = v[place], a[place]
        for k in range(len(of.states)):
            rates[2 * n + k] = a[of.states[k]]
    return trust
