"""Derivatives of the metric "unit" by the model's dimensions s, in conditions of least change W (q - q₀) + Φ_qᵀλ = 0.

W = diag(1/l², 1) with l² four times the mean of sᵀs, so that W' = W D σ with D = diag(-2, 0) and
σ = (ln l)' = Σ sᵀs' / Σ sᵀs. Dimensions are linear functions of the parameters and of the estimate q₀.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...results import Assembly, AssemblyRequest
from ...system import System
from ..equations.length import dimensions, dimensions_at


class MetricChange(NamedTuple):
    """Second derivatives along a direction: changes of the conditions on q and v, and of gradients by b and q₀.

    The gradient by v₀ changes as the condition on v.
    """

    q: Array
    v: Array
    b: Array
    guess: Array


class MetricDerivatives:
    """A change of the metric acts as a change of the guess, W (q' - q₀') = - W D σ (q - q₀).

    In an equilibrium, q does not depend on q₀, but is itself the q₀ of the metric of velocities.

    Parameters
    ----------
    system : System
    found : the assembled state
    asked : its estimate and options; other metrics are constant
    """

    def __init__(self, system: System, assembly: Assembly, request: AssemblyRequest) -> None:
        self._dimensions, self._count, self._settled = dimensions(system), len(system.b), assembly.settled
        s = request.unit_metric * dimensions_at(system, request.q)
        self._squares = float(s @ s) or np.inf
        self._growth = s / self._squares
        D = np.where(system.layout.is_length, -2.0, 0.0)
        self._D = tuple(np.where(held, 0.0, D) for held in (request.held_positions, request.held_velocities))
        self._moved = -self._D[0] * (assembly.q - request.q), -self._D[1] * (assembly.v - request.v)

    def along(self, db: Array, dq: Array) -> tuple[Array, Array]:
        """Changes of q₀ and v₀ that act as the metric's change along a direction of b and q₀."""
        growth = self._growth @ np.concatenate([db, dq])
        of_q, of_v = (np.multiply.outer(moved, growth) for moved in self._moved)
        return of_q, of_v

    def gradient(self, by_q: Array, by_v: Array) -> tuple[Array, Array]:
        """The transpose: gradients by b and q₀ (len(b),), (nq,) from those by the guess in a constant metric."""
        return self._parts(self._growth * float(self._moved[0] @ by_q + self._moved[1] @ by_v))

    def change_along(
        self, by_q: Array, by_v: Array, db: Array, state: Sequence[Array], guess: Sequence[Array]
    ) -> MetricChange:
        """The changes along a direction with constant adjoint variables.

        Parameters
        ----------
        by_q, by_v : (nq,) gradients by the guess in a constant metric
        db : (len(b),) change of the parameters
        state, guess : changes of q and v, and of q₀ and v₀ (nq,)
        """
        along = db, state[0] if self._settled else guess[0]
        growth = float(self._growth @ np.concatenate(along))
        of_q, of_v = self._D[0] * by_q, self._D[1] * by_v
        change = growth * float(self._moved[0] @ of_q + self._moved[1] @ of_v)
        change -= float((state[0] - guess[0]) @ of_q + (state[1] - guess[1]) @ of_v)
        bent = self._dimensions.of(*along) / self._squares - 2 * growth * self._growth
        straight = float(self._moved[0] @ by_q + self._moved[1] @ by_v)
        b, of_guess = self._parts(change * self._growth + straight * bent)
        if self._settled:
            return MetricChange(-of_guess, growth * of_v, b, 0 * of_guess)
        return MetricChange(growth * of_q, growth * of_v, b, growth * of_q + of_guess)

    def _parts(self, both: Array) -> tuple[Array, Array]:
        return both[: self._count], both[self._count :]
