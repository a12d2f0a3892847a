"""Back onto the constraints after a step: the least change of q, then of v."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....system import System
from ..saddle_point import Saddle

TOLERANCE = 1e-13
STEPS = 5


class Projection:
    """Projects states of one system onto Φ = 0 and Φ_q v = -Φ_t; the Jacobian's factors serve both.

    `b` are the numbers of the elements, with what they remember; the caller keeps them up to date.
    """

    def __init__(self, system: System, b: Array | None = None, rows: Array | None = None) -> None:
        self._system = system
        self._b = system.b if b is None else b
        self.keep(rows)
        self._group = system.group("Phi_q")
        self._weight, self._nothing = np.ones(system.nq), np.zeros(system.nq)
        (self._Phi_q,) = self._group.allocate()

    def keep(self, rows: Array | None) -> None:
        """Go on with another choice of independent equations."""
        self._saddle = Saddle(self._system, "I", rows)

    def __call__(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """The projected q and v."""
        self._group.run(self._b, t, q, self._Phi_q)
        self._saddle.factor(self._weight, self._Phi_q)
        for _ in range(STEPS):
            residual = self._system.Phi(q, t, b=self._b)
            if abs(residual).max(initial=0.0) <= TOLERANCE:
                break
            q = q + self._saddle.solve(self._nothing, -residual)[0]
        residual = self._system.Phi_q_xi(q, v, t, b=self._b) + self._system.Phi_t(q, t, b=self._b)
        return q, v + self._saddle.solve(self._nothing, -residual)[0]
