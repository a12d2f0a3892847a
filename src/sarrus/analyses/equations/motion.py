"""The equations of motion solved for acceleration and multipliers: M a + Φ_qᵀ lam = Q + S, Φ_q a = γ."""

from __future__ import annotations

import numpy as np

from ...algebra import Array
from ...system import System
from .saddle_point import Saddle


class EquationsOfMotion:
    """Accelerations of one system; all memory is reused between calls.

    Where constraints are redundant, `rows` are the places in Φ of independent ones (see `Independence`): the
    accelerations are the same for any such choice, the multipliers of the other equations are 0.
    """

    def __init__(self, system: System, rows: Array | None = None) -> None:
        self.system = system
        self.b = system.b.copy()
        self.evaluations = 0
        self._constraints = system.group("Phi_q", "gamma")
        self._inertia = system.group("M", "S")
        self._forces = system.group("Q")
        self._Phi_q, self._gamma = self._constraints.allocate()
        self._M, self._S = self._inertia.allocate()
        (self._Q,) = self._forces.allocate()
        self.keep(rows)

    def keep(self, rows: Array | None) -> None:
        """Go on with another choice of independent equations."""
        self._saddle = Saddle(self.system, "M", rows)

    def acceleration(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """a (nq,) and lam (m,) at a state.

        Raises
        ------
        SingularSystem
            If the constraints are dependent there.
        """
        self.evaluations += 1
        self._constraints.run(self.b, t, q, v, self._Phi_q, self._gamma)
        self._inertia.run(self.b, q, v, self._M, self._S)
        self._forces.run(self.b, t, q, v, self._Q)
        self._saddle.factor(self._M, self._Phi_q)
        return self._saddle.solve(self._Q + self._S, self._gamma)

    def rate(self, t: float, y: Array) -> Array:
        """The first-order form: y = [q; v], its rate [v; a]."""
        q, v = np.split(y, 2)
        return np.concatenate([v, self.acceleration(t, q, v)[0]])
