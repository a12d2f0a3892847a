"""The conditions on a state by its independent coordinates: their matrix, and solutions with its transpose."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....linalg.factors import Factored, SingularSystem
from ....system import System
from ...equations.states_at_rest import places
from ...position.assembly_derivatives import NoDerivative
from .recorded_coordinates import RecordedCoordinates
from .solved_states import SolvedStates


class Conditions:
    """The matrix of independent rows of Φ_q, of the gradients of the coordinates, and of first-order states."""

    def __init__(self, system: System, state: SolvedStates, coordinates: RecordedCoordinates) -> None:
        J = system.Phi_q(state.states.q[0], float(state.states.t[0])).toarray()
        self._m, self._rows, own = len(J), np.flatnonzero(~state.steps.left_out[0]), places(system)
        self._n = len(coordinates.c_q)
        try:
            self._factors = Factored(np.vstack([J[self._rows], coordinates.c_q, np.eye(len(J[0]))[own]]))
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
