"""Derivatives of the matrices of a linearization, ẋ = A x + B u, y = C x + D u, and of its frequency responses.

A column j of the matrices is the change of h = (c̈, ẋ_s, y) along the change (q', v', a', λ', b') of the state with one
entry of x or u, which satisfies the changes of

    Φ = 0,  c = x_c,    Φ_q v + Φ_t = 0,  ċ = x_ċ,    M a + Φ_qᵀλ = Q + S,  Φ_q a = γ.

With the adjoint variables of these equations for the weights of the column, the derivatives of all weighted entries are
the gradient of the change of one Lagrangian along the column's direction: contracted second derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....algebra import Array
from ....outputs.recording import Key
from ....results import StateSpace
from ....system.curves.curve_derivatives import CurveDerivatives
from ...equations.states_at_rest import places
from ...position.assembly_derivatives import NoDerivative
from ..chain.start import Start
from ..lagrangians.changes import change_at
from ..lagrangians.curves import CurveLagrangian
from .modal import REPEATED
from .recorded_outputs import RecordedCoordinates, weighted
from .rest import Conditions
from .solved_states import Slopes, SolvedStates, StateAnalysis


class MatricesAbout(StateAnalysis):
    """The matrices of a linearization about a state.

    Parameters
    ----------
    state : the state
    plant : the linearization
    coordinates : its independent coordinates and outputs, recorded
    """

    result: StateSpace

    def __init__(self, state: SolvedStates, plant: StateSpace, coordinates: RecordedCoordinates) -> None:
        system = state.system
        self.result, self._state, self._of = plant, state, coordinates
        self._own = places(system)
        self._motion = Start(system, state.steps, CurveDerivatives(system))
        self._conditions = Conditions(system, state, coordinates)
        self._curves = CurveLagrangian(system, True, False)
        self._columns = self._directions()

    def _directions(self) -> list[Slopes]:
        """The changes of the state with each entry of x and u."""
        plant, system = self.result, self._state.system
        nx, count = len(plant.states), len(plant.states) + len(plant.inputs)
        q, v = np.zeros((system.nq, count)), np.zeros((system.nq, count))
        b = np.zeros((len(system.b), count))
        q[:, :nx], v[:, :nx] = plant.q_x, plant.v_x
        for j, name in enumerate(plant.inputs):
            b[system.inputs[name].places, nx + j] = 1.0
        a, lam = self._motion.along(q, v, b)
        c = np.zeros((len(system.joint_coordinates.b), count))
        return [Slopes(*(x[:, j].copy() for x in (q, v, a, lam, b, c))) for j in range(count)]

    def gradient(self, key: Key, bar: float) -> Slopes:
        weights = bar * (self._pole_weights if key[0] == "pole" else self._weights)(*key[1])
        total = [np.zeros_like(x) for x in self._columns[0]]
        for j in np.flatnonzero(weights.any(axis=0)).tolist():
            for whole, part in zip(total, self._of_column(weights[:, j], self._columns[j]), strict=True):
                whole += part
        return Slopes(*total)

    def _no_weights(self) -> Array:
        """Zeros for derivatives by all of [A B; C D]."""
        return np.zeros((len(self.result.states) + len(self.result.outputs), len(self._columns)))

    def _pole_weights(self, at: int, part: str) -> Array:
        """The derivatives of the real or imaginary part of a pole by all of [A B; C D]."""
        nx, found, by_A = len(self.result.states), self._no_weights(), _pole_slopes(self.result, at + 1)
        found[:nx, :nx] = by_A.real if part == "re" else by_A.imag
        return found

    def _weights(self, word: str, row: str, column: str, frequency: float | None = None) -> Array:
        """The derivatives of an entry, or a part of a frequency response, by all of [A B; C D]."""
        plant, found = self.result, self._no_weights()
        nx = len(plant.states)
        if frequency is None:
            i, j = plant.place(word, row, column)
            found[i + nx * (word in "CD"), j + nx * (word in "BD")] = 1.0
            return found
        i, j = plant.place("D", row, column)
        shift = 2j * np.pi * frequency * np.eye(nx) - plant.A
        left = np.append(np.linalg.solve(shift.T, plant.C[i]), np.eye(len(plant.outputs))[i])
        right = np.append(np.linalg.solve(shift, plant.B[:, j]), np.eye(len(plant.inputs))[j])
        whole = np.outer(left, right)
        return np.asarray(whole.real if word == "real" else whole.imag)

    def _of_column(self, weights: Array, along: Slopes) -> Sequence[Array]:
        """The gradient of one column with weights."""
        of, state, system = self._of, self._state, self._state.system
        n = len(of.c)
        bars = weighted(
            (of.acceleration, weights[n : 2 * n]), (of.outputs, weights[len(self.result.states) :])
        )
        by = of.gradient(bars)
        by.a[self._own] += weights[2 * n : len(self.result.states)]
        xi, nu = self._motion.adjoint(by.a[:, None], by.lam[:, None])
        q_bar, v_bar, _ = self._motion.transposed(xi, nu)
        rows, rates = self._conditions.transposed(by.v + v_bar[:, 0])
        through_v = self._rate_q.T @ rows + of.rate_q.T @ rates
        first_rows, first = self._conditions.transposed(by.q + q_bar[:, 0] - through_v)
        tape = of.change(_sum(bars, weighted((of.c, -first), (of.rate, -rates))), along)
        t, q, v, a, lam = (x[0] for x in (*state.states[:4], state.steps.lam))
        none = np.zeros(system.m)

        def change(kind: str, lam: Array, nu: Array, lam_dot: Array, **x: Array) -> Any:
            return change_at(system, kind, float(t), system.b, along.b, lam, nu, lam_dot, self._curves, **x)

        moved = {"q": q, "v": v, "q_dot": along.q, "v_dot": along.v}
        accelerated = {"a": a, "xi": -xi[:, 0], "a_dot": along.a}
        parts = [
            change("motion", lam, -nu[:, 0], along.lam, **moved, **accelerated),
            change("rate", none, rows, none, **moved),
            change("place", none, -first_rows, none, q=q, q_dot=along.q),
        ]
        sums = (sum(getattr(part, name) for part in parts) for name in ("q", "v", "a", "lam", "b"))
        return [*(own + more for own, more in zip(tape[:5], sums, strict=True)), tape.c]

    @property
    def _rate_q(self) -> Any:
        """(Φ_q v + Φ_t)_q of holonomic constraints."""
        t, q, v = (x[0] for x in self._state.states[:3])
        return -0.5 * self._state.system.gamma_v(q, v, float(t))


def _pole_slopes(plant: StateSpace, number: int) -> Array:
    """The derivatives l rᵀ / (lᵀ r) (nx, nx) of a pole by the entries of A.

    Raises
    ------
    NoDerivative
        If another pole is the same.
    """
    value, left, right, gap, round_off = plant.pole(number)
    if gap <= REPEATED * abs(value) + 10 * round_off:
        message = f"{plant.name}: pole{number} is the same as another pole, {value:.6g} 1/s: alone it has no derivative"
        change = "Change a parameter so that they differ, such as a stiffness by 0.1 %"
        raise NoDerivative(f"{message}. {change if value else 'Take another pole'}.")
    return np.asarray(np.outer(left, right) / (left @ right))


def _sum(some: dict[int, float], others: dict[int, float]) -> dict[int, float]:
    return {at: some.get(at, 0.0) + others.get(at, 0.0) for at in some.keys() | others.keys()}
