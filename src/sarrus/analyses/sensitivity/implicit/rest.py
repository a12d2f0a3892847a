"""Derivatives of an equilibrium with its multipliers: Φ_qᵀλ - Q(q, x, t, b) = 0, Φ(q, b) = 0."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ....linalg.factors import LUFactors, SingularSystem
from ....model.announcement import collecting
from ....outputs.motion import states_of
from ....results import Equilibrium
from ....system import System
from ...equations.states_at_rest import places
from ...equilibria.balance import Balance
from ...equilibria.settled_derivatives import SettledDerivatives
from ...position.assembly_derivatives import NoDerivative
from ...position.initial_state import start_of
from ..parameters.parameters import Parameters
from ..steps.sweep_loop import NodeArrays
from .recorded_outputs import RecordedCoordinates
from .solved_states import Moves, SolvedStates


class Conditions:
    """The matrix of independent rows of Φ_q, of the gradients of the coordinates, and of first-order states."""

    def __init__(self, system: System, state: SolvedStates, coordinates: RecordedCoordinates) -> None:
        J = system.Phi_q(state.states.q[0], float(state.states.t[0])).toarray()
        self._m, self._rows, own = len(J), np.flatnonzero(~state.steps.left_out[0]), places(system)
        self._n = len(coordinates.c_q)
        try:
            self._factors = LUFactors(np.vstack([J[self._rows], coordinates.c_q, np.eye(len(J[0]))[own]]))
        except SingularSystem:
            raise NoDerivative(
                f"{system.name}: the coordinates of the linearization are dependent on its state. Choose others."
            ) from None
        self._states = len(own)

    def solve(self, constraints: Array, coordinates: Array) -> Array:
        """Changes (nq, k) for changes of the constraints (m, k) and of the coordinates (n, k)."""
        none = np.zeros((self._states, coordinates.shape[1]))
        return np.asarray(self._factors.solve(np.vstack([constraints[self._rows], coordinates, none])))

    def transposed(self, bar: Array) -> tuple[Array, Array]:
        """The adjoint variables of the constraints (m,) and of the coordinates (n,)."""
        found, rows = self._factors.transposed(bar), np.zeros(self._m)
        count = len(self._rows)
        rows[self._rows] = found[:count]
        return rows, found[count : count + self._n]


HELD = 1e-6  # part along motions without stiffness, relative to the whole, that counts as round-off
SYMMETRIC = 1e-8  # stiffness of a motion that has none, relative to the largest


class RestingState(SolvedStates):
    """The state of an equilibrium.

    Motions without stiffness are allowed: parameters that would start one have no derivatives, and responses that
    depend on it are refused.

    Raises
    ------
    NoDerivative
        If a first-order state is not determined.
    """

    def __init__(self, system: System, rest: Equilibrium) -> None:
        with collecting():  # warnings of the equilibrium itself have been issued
            start = start_of(system, rest)
        super().__init__(system, states_of(rest), system.b[system.memory_places][None])
        self._derivatives = LooseDerivatives(system, start)
        self._states = np.isin(np.arange(system.nq), places(system))

    @property
    def derivatives(self) -> LooseDerivatives:
        return self._derivatives

    def undefined(self, parameters: Parameters) -> Array:
        b = parameters.along(np.eye(len(parameters.names)))[0]
        return super().undefined(parameters) | self._derivatives.starts_motion(b)

    def along(self, moves: Moves) -> NodeArrays:
        q, lam, v, _ = self._derivatives.whole_along(moves.b)
        found = self.zeros()
        found.q[0], found.lam[0], found.v[0] = q, lam, self._states[:, None] * v
        return found

    def gradient(self, by: NodeArrays) -> Moves:
        system = self.system
        q, v, lam = by.q[0, :, 0], np.where(self._states, by.v[0, :, 0], 0.0), by.lam[0, :, 0]
        self._derivatives.refuse_moving(q)
        change = np.zeros(system.nq), -lam, np.zeros(system.nq), np.zeros(system.m)
        return self.no_moves()._replace(b=self._derivatives.adjoint(q, v, change).b[:, None])


class LooseDerivatives(SettledDerivatives):
    """The derivatives of an equilibrium in which motions may have no stiffness: along these the state stays."""

    def _determined(self, A: csr_array, J: csr_array) -> csr_array:
        if self._system.states:
            self._motions = np.zeros((self._system.nq, 0))
            return super()._determined(A, J)
        balance: Balance = self.balance
        spectrum = balance.spectrum
        self._motions = balance.Z @ spectrum.vectors[:, spectrum.neutral]
        top = float(abs(spectrum.squares).max(initial=0.0)) or 1.0
        self._momenta = self._system.M(self._assembly.q, b=self._system.b) @ self._motions
        if not self._motions.size:
            return A
        coupling = abs(spectrum.vectors.T @ (balance.H.T - balance.H) @ spectrum.vectors)[spectrum.neutral]
        if coupling.max(initial=0.0) > SYMMETRIC * top:  # forces that follow the motion
            return super()._determined(A, J)
        return csr_array(A + top * (self._momenta @ self._momenta.T))

    def starts_motion(self, db: Array) -> Array:
        """Whether changes of the parameters (len(b), k) set motions without stiffness going (k,)."""
        if not self._motions.size:
            return np.zeros(db.shape[1], dtype=bool)
        f, g = self._parts(self._first @ db)
        x, _ = self._position.solve(f, g, np.zeros(f.shape))
        size = np.sqrt(
            np.maximum((x * (self._system.M(self._assembly.q, b=self._system.b) @ x)).sum(axis=0), 0.0)
        )
        return np.asarray(abs(self._momenta.T @ x).max(axis=0) > HELD * size)

    def refuse_moving(self, q_bar: Array) -> None:
        """Refuse a response that changes along a motion without stiffness.

        Raises
        ------
        NoDerivative
        """
        found, size = abs(self._motions.T @ q_bar), abs(self._motions).max(axis=0) * abs(q_bar).sum()
        if np.any(found > HELD * size):
            what = "a motion has no stiffness in the equilibrium, and the response depends on it"
            raise NoDerivative(
                f"{self._system.name}: {what}. Add a spring, or take a response that it does not change."
            )
