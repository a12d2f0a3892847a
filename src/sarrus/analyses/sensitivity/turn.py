"""An event differentiated: when a function crosses zero within a step, and what an impact then does to the velocities.

The state at an event is interpolated, q̃, ṽ, and made consistent: q by the least change (which is so small that its
derivative is that of a linear projection), v = ṽ - s with M s + Φ_qᵀσ_s = 0, Φ_q s = Φ_q ṽ. Then

    ψ(q) = 0,    M (v⁺ - v) + Φ_qᵀΛ = f_qᵀ p,    Φ_q v⁺ = 0,    f_q v⁺ = -e f_q v

for the function ψ, and the output f along which an impulse p acts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model.expression import parse
from ...results import RadauSteps, StepsTaken, Turn
from ...system import System
from ..saddle import Saddle
from .outputs import Outputs, States
from .sampling import interpolation


class Measure(NamedTuple):
    """Of a formula of outputs: gradients by q (nq,) and the joints' numbers c, second ones by q, and by q and c."""

    q: Array
    c: Array
    qq: Array
    qc: Array


class TurnDerivatives:
    """The derivatives of the state after an event, and of its time within the step.

    Parameters
    ----------
    system : System
    steps : those before it; it lies in the last one
    turn : the event
    restitutions : names of those of all events, which are the last numbers

    Attributes
    ----------
    matrix : (2 nq + 1, 6 nq + len(b) + len(c) + restitutions) those of q, of v⁺ (v, where the run ended), of the time
        since the stretch began: by q, v, a at both ends of the last step, by the numbers, by those of joints'
        coordinates, and by the restitutions
    """

    def __init__(self, system: System, steps: StepsTaken, turn: Turn, restitutions: Sequence[str]) -> None:
        self.system, self._turn, n, nq = system, turn, len(steps) - 1, system.nq
        self._b = steps.b.copy()
        self._b[steps.places] = steps.memory[n]
        kept = np.flatnonzero(~steps.left_out[n]) if len(steps.left_out) else None
        self._saddle = Saddle(system, "M", kept)
        self._saddle.factor(system.M(turn.q, b=self._b).data, system.Phi_q(turn.q, turn.t, b=self._b).data)
        self._widths = np.cumsum([6 * nq, len(system.b)])
        self._size = int(self._widths[-1]) + len(system.joint_coordinates.b) + len(restitutions)
        name = f"{turn.name}.restitution"
        self._by_e = np.zeros(self._size)
        if name in restitutions:
            self._by_e[self._size - len(restitutions) + restitutions.index(name)] = 1.0
        h = float(steps.h[n])
        s = (turn.t - float(steps.t[n])) / h
        weights = interpolation(np.array([s]), np.array([h]))[0]
        ends = np.array([[getattr(steps, kind)[n + e] for kind in ("q", "v", "a")] for e in (0, 1)])
        q_z, v_z = (self._by_nodes(weights[order]) for order in (0, 1))
        v, a = (np.einsum("el,eln->n", weights[order], ends) for order in (1, 2))
        if not isinstance(steps, RadauSteps):  # second derivatives of quintics are of the first order only
            a = (1 - s) * ends[0, 2] + s * ends[1, 2]
        before = self._consistent(q_z, v_z, v)
        along = self._consistent(v[:, None], a[:, None], v, moving=True)
        self.matrix = self._turned(before, along)

    def _by_nodes(self, weights: Array) -> Array:
        """The derivatives of what is interpolated with these weights (nq, size)."""
        found = np.zeros((self.system.nq, self._size))
        found[:, : self._widths[0]] = np.kron(weights.ravel(), np.eye(self.system.nq))
        return found

    def _consistent(self, q_z: Array, v_z: Array, given: Array, moving: bool = False) -> tuple[Array, Array]:
        """The derivatives of the consistent state with those of the interpolated one; `moving`: with b held."""
        system, t, q, v, b = self.system, self._turn.t, self._turn.q, self._turn.v, self._b
        none = np.zeros((system.nq, q_z.shape[1]))
        J = system.Phi_q(q, t, b=b)
        by_b = (lambda matrix: 0.0) if moving else self._by_b
        s = given - v
        _, sigma = self._saddle.solve(np.zeros(system.nq), J @ s)
        q_dot = q_z - self._solved(none, J @ q_z + by_b(system.Phi_b(q, t, b=b)))[0]
        pulled = system.M_a_q(q, s, b=b) + system.Phi_qT_lam_q(q, sigma, t, b=b)
        pulled_b = by_b(system.M_a_b(q, s, b=b)) + by_b(system.Phi_qT_lam_b(q, sigma, t, b=b))
        turned = system.Phi_q_xi_q(q, v, t, b=b) @ q_dot + by_b(system.Phi_q_xi_b(q, v, t, b=b))
        return q_dot, v_z - self._solved(-(pulled @ q_dot + pulled_b), J @ v_z + turned)[0]

    def _by_b(self, matrix: Any) -> Array:
        found = np.zeros((matrix.shape[0], self._size))
        found[:, self._widths[0] : self._widths[0] + matrix.shape[1]] = matrix.toarray()
        return found

    def _by_c(self, matrix: Array) -> Array:
        found = np.zeros((len(matrix), self._size))
        found[:, self._widths[1] : self._widths[1] + matrix.shape[1]] = matrix
        return found

    def _solved(self, f: Array, g: Array) -> tuple[Array, Array]:
        found = [self._saddle.solve(*pair) for pair in zip(f.T, g.T, strict=True)]
        x, y = (np.array([pair[n] for pair in found]).T for n in (0, 1))
        return x, y

    def _turned(self, before: tuple[Array, Array], along: tuple[Array, Array]) -> Array:
        """The whole matrix: the time moves so that ψ stays zero; the state moves with it; the impact."""
        psi = self._measure(self._turn.function)
        change = psi.q @ before[0] + self._by_c(psi.c[None])[0]
        when = -change / (psi.q @ along[0][:, 0])
        q, v = (x + rate * when for x, rate in zip(before, along, strict=True))
        if self._turn.along is not None:
            v = self._struck(q, v, self._measure(self._turn.along))
        return np.vstack([q, v, when])

    def _struck(self, q_z: Array, v_z: Array, f: Measure) -> Array:
        """The derivatives of the velocities after an impact."""
        system, turn, b, e = self.system, self._turn, self._b, self._turn.restitution
        assert e is not None
        q, v, after = turn.q, turn.v, turn.after
        w, sigma = self._saddle.solve(f.q, np.zeros(system.m))
        p = -(1 + e) * (f.q @ v) / (f.q @ w)
        curved = f.qq @ q_z + self._by_c(f.qc)
        pulled = system.M_a_q(q, after - v, b=b) + system.Phi_qT_lam_q(q, p * sigma, turn.t, b=b)
        pulled_b = self._by_b(system.M_a_b(q, after - v, b=b)) + self._by_b(
            system.Phi_qT_lam_b(q, p * sigma, turn.t, b=b)
        )
        force = system.M(q, b=b) @ v_z - pulled @ q_z - pulled_b + p * curved
        turned = system.Phi_q_xi_q(q, after, turn.t, b=b) @ q_z + self._by_b(
            system.Phi_q_xi_b(q, after, turn.t, b=b)
        )
        free = self._solved(force, -turned)[0]
        wanted = -((after + e * v) @ curved + e * f.q @ v_z + (f.q @ v) * self._by_e)
        return np.asarray(free + np.outer(w, (wanted - f.q @ free) / (f.q @ w)))

    def _measure(self, text: str) -> Measure:
        system, turn = self.system, self._turn
        none = np.zeros((1, system.m))
        state = States(np.array([turn.t]), turn.q[None], turn.v[None], 0 * turn.q[None], none)
        outputs, tree = Outputs(system, state, self._b, _unknown), parse(text)
        found = tree.value({name: outputs(name) for name in tree.names()})
        places = {key: variable.at for key, variable in outputs.inputs.items()}
        sizes = {"q": system.nq, "c": len(system.joint_coordinates.b)}
        first = outputs.tape.gradient({found.at: 1.0})
        by = {kind: _gathered(places, first, kind, size) for kind, size in sizes.items()}
        second = {kind: np.zeros((system.nq, size)) for kind, size in sizes.items()}
        for (kind, n), place in places.items():
            if kind == "q":
                change = outputs.tape.gradient_along({found.at: 1.0}, {}, outputs.tape.along({place: 1.0}))[1]
                for other, size in sizes.items():
                    second[other][n] = _gathered(places, change, other, size)
        return Measure(by["q"], by["c"], second["q"], second["c"])


def _gathered(places: dict[tuple[str, int], int], bars: list[Any], kind: str, size: int) -> Array:
    """The gradient by the inputs of one kind."""
    found = np.zeros(size)
    for (own, n), place in places.items():
        if own == kind:
            found[n] = float(np.sum(bars[place]))
    return found


def _unknown(name: str) -> float:
    raise ValueError(f"an event cannot depend on the number {name!r}")
