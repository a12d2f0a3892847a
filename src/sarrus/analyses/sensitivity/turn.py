"""An event differentiated: when a function crosses zero within a step, and what then happens to the velocities.

The state at an event is interpolated, q̃, ṽ, and made consistent by the least changes: q = q̃ - s with M s + Φ_qᵀσ = 0,
Φ(q) = 0 (which is so small that it does not matter at which of both M and Φ_q are), and v = ṽ - s with

    M s + Φ_qᵀσ = 0,    Φ_q s = Φ_q ṽ + Φ_t.                                                             (a)

The event is where ψ(t, q, v) = 0. After an impact along the output f by an impulse p

    M (v⁺ - v) + Φ_qᵀΛ = f_qᵀ p,    Φ_q v⁺ = -Φ_t,    f_q v⁺ = -e f_q v;

velocities that a function gives are made consistent by (a).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...elements.operators import OPERATORS
from ...outputs.recording import Angles
from ...results import StepsTaken, Turn
from ...system import System
from ...system.curve_derivatives import CurveDerivatives
from ..equations.saddle_point import Saddle
from .event_functions import Recorded, Slopes, recorded
from .event_reactions import SolvedRecorded, recorded_solved, solves
from .sampling import apart, interpolation

# of the tolerance of the steps: an event whose function goes no farther below zero only grazes
SHALLOW = 1e-3


class State(NamedTuple):
    """Derivatives of a state by all that it depends on: q, v (nq, size) and the time t (size,)."""

    q: Array
    v: Array
    t: Array


class TurnDerivatives:
    """The derivatives of the state after an event, and of its time within the step.

    Parameters
    ----------
    system : System
    steps : those before it; it lies in the last one
    turn : the event
    restitutions : names of those of all events
    angles : the joints' coordinates along the run, with all their turns

    Attributes
    ----------
    matrix : (2 nq + 1, 6 nq + len(b) + len(c) + restitutions + 1) those of q, of v⁺ (v, where the run ended), of the
        time since the stretch began: by q, v, a at both ends of the last step, by the numbers, by those of joints'
        coordinates, by the restitutions, and by the time at which the stretch began

    Raises
    ------
    ValueError
        For an event that only grazes, and for Python functions that cannot be recorded.
    """

    def __init__(
        self, system: System, steps: StepsTaken, turn: Turn, restitutions: Sequence[str], angles: Angles
    ) -> None:
        self.system, self._turn, self._steps, self._angles = system, turn, steps, angles
        self._b = steps.b.copy()
        self._b[steps.places] = steps.memory[-1]
        kept = np.flatnonzero(~steps.left_out[len(steps) - 1]) if len(steps.left_out) else None
        self._curves = CurveDerivatives(system)
        self._saddle = Saddle(system, "M", kept)
        self._saddle.factor(system.M(turn.q, b=self._b).data, system.Phi_q(turn.q, turn.t, b=self._b).data)
        widths = (6 * system.nq, len(system.b), len(system.joint_coordinates.b), len(restitutions), 1)
        self._ends = np.cumsum([0, *widths])
        self._by_e = np.zeros(self._ends[-1])
        name = f"{turn.name}.restitution"
        if name in restitutions:
            self._by_e[self._ends[3] + list(restitutions).index(name)] = 1.0
        self.matrix = self._turned(*self._interpolated())

    def _interpolated(self) -> tuple[State, State]:
        """The derivatives of the consistent state within the step: at a fixed part of it, and along the motion."""
        steps, n, nq = self._steps, len(self._steps) - 1, self.system.nq
        h = float(steps.h[n])
        s = (self._turn.t - float(steps.t[n])) / h
        values, slopes = (x[0] for x in interpolation(np.array([s]), np.array([h]), apart(steps)))
        ends = np.array([[getattr(steps, kind)[n + e] for kind in ("q", "v", "a")] for e in (0, 1)])
        q, v = (np.einsum("el,eln->n", values[k], ends) for k in (0, 1))
        q_s, v_s = (np.einsum("el,eln->n", slopes[k], ends)[:, None] for k in (0, 1))
        q_z, v_z = (self._placed(np.kron(values[k].ravel(), np.eye(nq)), 0) for k in (0, 1))
        began = np.zeros(self._ends[-1])
        began[-1] = 1.0
        before = self._consistent(State(q_z, v_z, began), q, v)
        return before, self._consistent(State(q_s, v_s, np.ones(1)), q, v)

    def _placed(self, matrix: Array, part: int) -> Array:
        """Derivatives by one part of all that there is."""
        found = np.zeros((len(matrix), self._ends[-1]))
        found[:, self._ends[part] : self._ends[part] + matrix.shape[1]] = matrix
        return found

    def _by_b(self, name: str, moved: State, *operands: Array) -> Array | float:
        """An operator by the numbers, also those of curves; nothing along the motion, which holds them."""
        if moved.q.shape[1] == 1:
            return 0.0
        q, t, b = self._turn.q, self._turn.t, self._b
        found = self._placed(getattr(self.system, f"{name}_b")(q, *operands, t, b=b).toarray(), 1)
        if self._curves:
            kinds = dict(zip(OPERATORS[name].operands, operands, strict=False))
            found += self._placed(self._curves.matrix(name, b=b, t=t, q=q, **kinds).toarray(), 1)
        return found

    def _consistent(self, found: State, q: Array, v: Array) -> State:
        """The derivatives of the consistent state with those of the interpolated one, q̃, ṽ."""
        system, turn, b = self.system, self._turn, self._b
        J = system.Phi_q(turn.q, turn.t, b=b)
        s, sigma = self._saddle.solve(np.zeros(system.nq), J @ (q - turn.q))
        moved = J @ found.q + self._by_b("Phi", found)
        moved = moved + np.outer(system.Phi_t(turn.q, turn.t, b=b), found.t)
        q_z = found.q - self._saddle.solve(-self._pulled(found, s, sigma), moved)[0]
        return self._settled(found._replace(q=q_z), v)

    def _settled(self, found: State, given: Array) -> State:
        """The derivatives of velocities that are made consistent from given ones, with those of q and of these."""
        system, t, q, b = self.system, self._turn.t, self._turn.q, self._b
        J = system.Phi_q(q, t, b=b)
        s, sigma = self._saddle.solve(np.zeros(system.nq), J @ given + system.Phi_t(q, t, b=b))
        drift = J @ found.v + self._drifted(found, given - s)
        return found._replace(v=found.v - self._saddle.solve(-self._pulled(found, s, sigma), drift)[0])

    def _pulled(self, found: State, s: Array, sigma: Array) -> Array:
        """The derivatives of M s + Φ_qᵀσ with s and σ held."""
        system, t, q, b = self.system, self._turn.t, self._turn.q, self._b
        pulled = (system.M_a_q(q, s, b=b) + system.Phi_qT_lam_q(q, sigma, t, b=b)) @ found.q
        if found.q.shape[1] > 1:
            pulled = pulled + self._placed(system.M_a_b(q, s, b=b).toarray(), 1)
        pulled = pulled + self._by_b("Phi_qT_lam", found, sigma)
        return np.asarray(pulled + np.outer(self._turning.T @ sigma, found.t))

    def _drifted(self, found: State, v: Array) -> Array:
        """The derivatives of Φ_q v + Φ_t with v held."""
        system, t, q, b = self.system, self._turn.t, self._turn.q, self._b
        moved = (system.Phi_q_xi_q(q, v, t, b=b).toarray() + self._turning) @ found.q
        moved = moved + self._by_b("Phi_q_xi", found, v) + self._by_b("Phi_t", found)
        return np.asarray(moved + np.outer(self._turning @ v + system.Phi_tt(q, t, b=b), found.t))

    @cached_property
    def _turning(self) -> Array:
        """Φ_qt (m, nq)."""
        system, turn = self.system, self._turn
        columns = [system.Phi_q_xi_t(turn.q, xi, turn.t, b=self._b) for xi in np.eye(system.nq)]
        return np.array(columns).reshape(system.nq, system.m).T

    def _turned(self, before: State, along: State) -> Array:
        """The whole matrix: the time moves so that ψ stays zero; the state moves with it; the velocities turn."""
        turn, function = self._turn, self._recorded(self._turn.function)
        psi = function.slopes
        rate = float(self._change(psi, along)[0, 0])
        self._refuse_grazing(psi, self._bend(function, along), rate)
        when = -self._change(psi, before)[0] / rate
        now = State._make(
            x + np.multiply.outer(dx[..., 0], when) for x, dx in zip(before, along, strict=True)
        )
        if turn.along is not None:
            now = now._replace(v=self._struck(now, self._recorded(turn.along, self.system.nq)))
        elif turn.reset is not None:
            given = now._replace(v=self._change(self._recorded(turn.reset).slopes, now))
            now = self._settled(given, turn.after)
        return np.vstack([now.q, now.v, when])

    def _recorded(self, function: Any, copies: int = 1) -> Recorded:
        if isinstance(function, str) and solves(self.system, function):
            return recorded_solved(self.system, self._steps, self._turn, function, self._b, self._angles)
        return recorded(self.system, self._turn, function, self._b, self._angles, copies)

    def _bend(self, function: Recorded, along: State) -> float:
        """The mean of |ψ̈| over the last step."""
        psi, steps = function.slopes, self._steps
        if isinstance(function, SolvedRecorded):
            ends, curved = [self._rate_at(k) for k in (-2, -1)], 0.0
        else:
            ends = [psi.q @ steps.v[k] + psi.v @ steps.a[k] for k in (-2, -1)]
            curved = function.bend(along.q[:, 0], along.v[:, 0])
        return abs(float((ends[1] - ends[0])[0]) / float(steps.h[-1]) + curved)

    def _rate_at(self, k: int) -> Array:
        """ψ̇ at a node (1,)."""
        steps, turn = self._steps, self._turn
        t, q, v, a = (getattr(steps, name)[k] for name in ("t", "q", "v", "a"))
        there = replace(turn, t=float(t), q=q, v=v)
        psi = recorded_solved(self.system, steps, there, str(turn.function), self._b, self._angles).slopes
        return np.asarray(psi.q @ v + psi.v @ a + psi.t[0])

    def _change(self, slopes: Slopes, found: State) -> Array:
        """The derivatives of what has these slopes."""
        moved = slopes.q @ found.q + slopes.v @ found.v + slopes.t * found.t
        if found.q.shape[1] == 1:
            return np.asarray(moved)
        return np.asarray(moved + self._placed(slopes.b, 1) + self._placed(slopes.c, 2))

    def _refuse_grazing(self, psi: Slopes, bend: float, rate: float) -> None:
        """An event whose function hardly crosses zero may come or not: its time has no derivative."""
        steps, turn = self._steps, self._turn
        known = sum(
            abs(w[0]) @ (steps.rtol * abs(x) + steps.atol) for w, x in ((psi.q, turn.q), (psi.v, turn.v))
        )
        if not rate * rate > 2 * bend * SHALLOW * known:
            raise ValueError(
                f"the event {turn.name} at t = {turn.t:.6g} s only grazes: its function changes by {rate:.2g} in a "
                "second there, so that a slightly other motion would not meet it, and its time has no derivative; "
                "move what it looks for away from where the function turns, or leave the event out"
            )

    def _struck(self, found: State, output: Recorded) -> Array:
        """The derivatives of the velocities after an impact."""
        system, turn, e = self.system, self._turn, self._turn.restitution
        assert e is not None
        f_q, bends = output.slopes.q[0], output.bends
        w, sigma = self._saddle.solve(f_q, np.zeros(system.m))
        p = -(1 + e) * (f_q @ turn.v) / (f_q @ w)
        curved = bends.q @ found.q + self._placed(bends.b, 1) + self._placed(bends.c, 2) + bends.t * found.t
        force = system.M(turn.q, b=self._b) @ found.v + p * curved
        force = force - self._pulled(found, turn.after - turn.v, p * sigma)
        free = self._saddle.solve(force, -self._drifted(found, turn.after))[0]
        wanted = -((turn.after + e * turn.v) @ curved + e * f_q @ found.v + (f_q @ turn.v) * self._by_e)
        return np.asarray(free + np.outer(w, (wanted - f_q @ free) / (f_q @ w)))
