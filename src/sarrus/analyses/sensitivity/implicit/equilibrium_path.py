"""Equilibria of a system that drivers move, as a path over the displacement t of the drivers.

With x = (q, λ) and F = (Φ_qᵀλ - Q, Φ) = 0, of which the drivers make F_t constant,

    F_x x' = -F_t,    F_x x'' = -(F_x x')_x x'.

With F_xᵀ μ = (w, 0) and ℓ = μᵀF, a component wᵀq' changes with the parameters and with x as -ℓ', where ' is along x'.
The change of the gradient of ℓ along x' is a contracted second derivative; it contains wᵀq'' = -ℓ'_x x', too.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from ....algebra import Array
from ....model.announcement import collecting
from ....results import Trajectory
from ....system import System
from ...equilibria.settled_derivatives import SettledDerivatives
from ...position.assembly import assemble
from ...position.assembly_derivatives import NoDerivative
from ..lagrangians.changes import Change, change_at
from ..lagrangians.curves import CurveLagrangian
from ..steps.sweep_loop import NodeArrays
from .solved_states import Moves, SolvedStates, states_at

ACCELERATIONS = (
    "{}: with bushings, slopes of quantities that depend on velocities have no derivatives by parameters. Take the "
    "derivatives of their values."
)


class PathPoint:
    """An equilibrium of a path, and the derivatives along it.

    Parameters
    ----------
    system : System
    q, lam, t, memory : of the equilibrium

    Attributes
    ----------
    velocity, by_lam : q' (nq,) and λ' (m,)
    """

    def __init__(self, system: System, q: Array, lam: Array, t: float, memory: Array) -> None:
        with collecting():  # warnings of the equilibrium itself have been issued
            start = assemble(system, q, np.zeros(system.nq), t=t)
        start = replace(start, memory=memory, settled=True, lam=lam)
        self.derivatives = SettledDerivatives(system, start)
        self.system, self._q, self._lam, self._t = self.derivatives.system, start.q, lam, t
        self._curves = CurveLagrangian(self.system, True, False)
        self.velocity, self.by_lam = self.derivatives.with_constraints(-system.Phi_t(q, t))

    def change(self, weights: Array, curves: CurveLagrangian | None = None) -> Change:
        """The gradient of ℓ' for weights (nq,) of q'; that by parameters of curves needs `curves`."""
        x1, y1 = self.derivatives.adjoint_variables(weights)
        return change_at(
            self.system, self.derivatives.lagrangian, self._t, self.system.b, np.zeros(len(self.system.b)), self._lam,
            y1, self.by_lam, curves, q=self._q, q_dot=self.velocity, xi=x1,
        )  # fmt: skip

    def acceleration(self) -> Array:
        """q'' (nq,)."""
        changes = [self.change(weights) for weights in np.eye(self.system.nq)]
        return -np.array([one.q @ self.velocity + one.lam @ self.by_lam for one in changes])

    def gradient(self, q_bar: Array, v_bar: Array, lam_bar: Array) -> Array:
        """The gradient by the parameters (len(b),) of what has these gradients by q, q' and λ."""
        change, none = self.change(v_bar, self._curves), np.zeros(self.system.nq)
        bars = none, change.lam - lam_bar, none, np.zeros(self.system.m)
        return np.asarray(self.derivatives.adjoint(q_bar - change.q, none, bars).b - change.b)


class EquilibriumPath(SolvedStates):
    """The states of a path of equilibria at some of its displacements: velocities and accelerations are q' and q''."""

    def __init__(self, system: System, run: Trajectory, rows: Array) -> None:
        super().__init__(system, *states_at(system, run, rows))
        self._point, self._by_parameters = cache(self._of_row), cache(self._velocities)

    def _of_row(self, n: int) -> PathPoint:
        steps = self.steps
        return PathPoint(self.system, steps.q[n], steps.lam[n], float(steps.t[n]), self.memory[n])

    def _velocities(self, n: int) -> Array:
        """The derivatives of q' by the parameters (nq, len(b))."""
        none, lam = np.zeros(self.system.nq), np.zeros(self.system.m)
        return np.array([self._point(n).gradient(none, one, lam) for one in np.eye(self.system.nq)])

    def along(self, moves: Moves) -> NodeArrays:
        found = self.zeros()
        for n in range(len(found.q)):
            point = self._point(n)
            q, lam, _, _ = point.derivatives.whole_along(moves.b)
            found.q[n], found.lam[n] = q, lam
            found.v[n] = self._by_parameters(n) @ moves.b
            found.a[n] = np.nan  # third derivatives of F
        return found

    def gradient(self, by: NodeArrays) -> Moves:
        if by.a.any():
            raise NoDerivative(ACCELERATIONS.format(self.system.name))
        moves = self.no_moves()
        for n in np.flatnonzero(np.any([x.any(axis=(1, 2)) for x in by], axis=0)).tolist():
            moves.b[:, 0] += self._point(n).gradient(by.q[n, :, 0], by.v[n, :, 0], by.lam[n, :, 0])
        return moves
