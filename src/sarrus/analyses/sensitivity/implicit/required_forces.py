"""Derivatives of the multipliers that a given motion requires, M a + Φ_qᵀλ = Q + S at constant q, v and a."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ....results import Trajectory
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ...equations.length import lever
from ...equations.nullspace import NullSpace
from ...position.assembly_derivatives import NoDerivative
from ..steps.sweep_loop import NodeArrays
from .driven_motion import states_at
from .solved_states import Moves, SolvedStates


class At(NamedTuple):
    """Φ_q at one time, and the derivatives of Q + S - M a - Φ_qᵀλ by the parameters (nq, len(b))."""

    space: NullSpace
    by_b: csr_array


class RequiredForces(SolvedStates):
    """The states of `inverse_dynamics` at some of its times: the motion is data, the multipliers follow.

    Raises
    ------
    NoDerivative
        If drivers and joints leave a motion free: other forces would change it.
    """

    def __init__(self, system: System, run: Trajectory, rows: Array) -> None:
        super().__init__(system, *states_at(system, run, rows))

    @cached_property
    def _times(self) -> list[At]:
        return [self._at(n) for n in range(len(self.states.t))]

    def _at(self, n: int) -> At:
        system, b, curves = self.system, self.system.b.copy(), CurveDerivatives(self.system)
        t, q, v, a, lam = float(self.steps.t[n]), *(getattr(self.steps, x)[n] for x in ("q", "v", "a", "lam"))
        b[system.memory_places] = self.memory[n]
        J = system.Phi_q(q, t, b=b)
        space = NullSpace(J, lever(system, q, J))
        if space.Z.shape[1]:
            message = f"{system.name}: drivers and joints leave a motion free at t = {t:.6g} s"
            raise NoDerivative(f"{message}, which other forces would change. Add a driver.")
        own = system.Q_b(q, v, t, b=b) + system.S_b(q, v, b=b) - system.M_a_b(q, a, b=b)
        own = csr_array(own - system.Phi_qT_lam_b(q, lam, t, b=b))
        own.resize((system.nq, len(b)))
        if curves:
            own = own + curves.matrix("Q", b, t, q=q, v=v) - curves.matrix("Phi_qT_lam", b, t, q=q, lam=lam)
        return At(space, csr_array(own))

    def along(self, moves: Moves) -> NodeArrays:
        found = self.zeros()
        for n, at in enumerate(self._times):
            found.lam[n, :, 0] = at.space.multipliers((at.by_b @ moves.b)[:, 0])
        self.shorten(found, moves.b)
        return found

    def gradient(self, by: NodeArrays) -> Moves:
        by_b = self.unshorten(by)
        for n in np.flatnonzero(by.lam.any(axis=(1, 2))).tolist():
            at = self._times[n]
            by_b = by_b + at.by_b.T @ at.space.change(by.lam[n])
        return self.no_moves()._replace(b=by_b)
