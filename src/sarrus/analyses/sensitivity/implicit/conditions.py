"""The conditions on a state by its independent coordinates: their matrix, and solutions with its transpose."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from ....algebra import Array
from ....system import System
from ...equations.states_at_rest import places
from .recorded_coordinates import RecordedCoordinates
from .solved_states import SolvedStates


class Conditions:
    """The matrix of independent rows of Φ_q, of the gradients of the coordinates, and of first-order states."""

    def __init__(self, system: System, state: SolvedStates, coordinates: RecordedCoordinates) -> None:
        J = system.Phi_q(state.states.q[0], float(state.states.t[0])).toarray()
        self._m, self._rows, own = len(J), np.flatnonzero(~state.steps.left_out[0]), places(system)
        self._n = len(coordinates.c_q)
        self._factors = lu_factor(np.vstack([J[self._rows], coordinates.c_q, np.eye(len(J[0]))[own]]))
        self._states = len(own)

    def solve(self, constraints: Array, coordinates: Array) -> Array:
        """Changes (nq, k) for changes of the constraints (m, k) and of the coordinates (n, k)."""
        none = np.zeros((self._states, coordinates.shape[1]))
        return np.asarray(lu_solve(self._factors, np.vstack([constraints[self._rows], coordinates, none])))

    def transposed(self, bar: Array) -> tuple[Array, Array]:
        """The adjoint variables of the constraints (m,) and of the coordinates (n,)."""
        found, rows = lu_solve(self._factors, bar, trans=1), np.zeros(self._m)
        count = len(self._rows)
        rows[self._rows] = found[:count]
        return rows, found[count : count + self._n]
