"""Multipliers of minimum norm in compiled code, see `minimum_norm`."""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.linking.link import compiled
from ...algebra import Array


class LeftOut(NamedTuple):
    """Equations that are left out because others imply them.

    Attributes
    ----------
    rows : (k,) their places in Φ
    first : (m + 1,) where the numbers of each equation begin in Φ_q, and their end
    columns : the coordinate that each number of Φ_q belongs to
    Phi_q : numbers of all equations at a state
    null : (k, m) combinations of equations that vanish there
    """

    rows: Array
    first: Array
    columns: Array
    Phi_q: Array
    null: Array


@compiled
def gradient(others: LeftOut, row: int, force: Array) -> None:
    """Add the gradient of one equation to a force."""
    for entry in range(others.first[row], others.first[row + 1]):
        force[others.columns[entry]] += others.Phi_q[entry]


@compiled
def shorten(others: LeftOut, lam: Array) -> None:
    """Subtract the part of the multipliers along the combinations, which are made orthonormal (Gram and Schmidt)."""
    null = others.null
    for k in range(len(null)):
        for before in range(2 * k):  # twice, for all digits
            subtract(null[before % k], null[k])
        size = 0.0
        for row in range(len(lam)):
            size += null[k, row] ** 2
        for row in range(len(lam)):
            null[k, row] /= size**0.5
    for k in range(len(null)):
        subtract(null[k], lam)


@compiled
def subtract(unit: Array, lam: Array) -> None:
    """Subtract from `lam` its part along a vector of unit length."""
    along = 0.0
    for row in range(len(lam)):
        along += unit[row] * lam[row]
    for row in range(len(lam)):
        lam[row] -= along * unit[row]
