"""Derivatives of the metric "unit" by the lever arms s, in conditions of least change W (q - q₀) + Φ_qᵀλ = 0.

W = diag(1/l², 1) with l² four times the mean of sᵀs, so that W' = W D σ with D = diag(-2, 0) and
σ = (ln l)' = Σ sᵀs' / Σ sᵀs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...results import Asked, Assembly
from ...system import System
from ..equations.length import arm_places, units


class Curved(NamedTuple):
    """Second derivatives along a direction: changes of the conditions on q and v, and of the gradient by b."""

    q: Array
    v: Array
    b: Array


class MetricDerivatives:
    """A change of the metric acts as a change of the guess, W (q' - q₀') = - W D σ (q - q₀).

    Parameters
    ----------
    system : System
    found : the assembled state
    asked : its estimate and options; other metrics are constant
    """

    def __init__(self, system: System, found: Assembly, asked: Asked) -> None:
        self._places = arm_places(system) if asked.own_metric else np.zeros(0, dtype=int)
        s = system.b[self._places]
        self._squares, self._growth = float(s @ s) or 1.0, np.zeros(len(system.b))
        self._growth[self._places] = s / self._squares
        D = -2.0 * (units(system.nq, 2.0) > 1)
        self._D = tuple(np.where(held, 0.0, D) for held in (asked.held_positions, asked.held_velocities))
        self._moved = -self._D[0] * (found.q - asked.q), -self._D[1] * (found.v - asked.v)

    def guess_along(self, db: Array, dq: Array, dv: Array) -> tuple[Array, Array]:
        """Changes of the guess, with those that act as the metric's change along db."""
        growth = self._growth @ db
        of_q, of_v = (np.multiply.outer(moved, growth) for moved in self._moved)
        return dq + of_q, dv + of_v

    def gradient(self, by_q: Array, by_v: Array) -> Array:
        """The transpose: the gradient by the parameters from those by the guess (len(b),)."""
        return self._growth * float(self._moved[0] @ by_q + self._moved[1] @ by_v)

    def curved(self, by_q: Array, by_v: Array, db: Array, dq: Array, dv: Array) -> Curved:
        """The changes along a direction with constant adjoint variables.

        Parameters
        ----------
        by_q, by_v : (nq,) gradients by the guess
        db : (len(b),) change of the parameters
        dq, dv : (nq,) changes of q - q₀ and of v - v₀
        """
        growth = float(self._growth @ db)
        of_q, of_v = self._D[0] * by_q, self._D[1] * by_v
        change = growth * float(self._moved[0] @ of_q + self._moved[1] @ of_v) - float(dq @ of_q + dv @ of_v)
        bent = -2 * growth * self._growth
        bent[self._places] += db[self._places] / self._squares
        straight = float(self._moved[0] @ by_q + self._moved[1] @ by_v)
        return Curved(growth * of_q, growth * of_v, change * self._growth + straight * bent)
