"""An event differentiated twice: the contracted second derivatives of its equations, see `turn`.

With the adjoint variables μ of the equations R, the gradient of ℓ = μᵀR by all that it depends on changes along the
motion; parts of ℓ are those of steps (`shares`), others come from the functions of the event.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ..lagrangians.changes import Change, change_at
from ..lagrangians.curves import CurveLagrangian
from .first_order import TurnDerivatives
from .functions import Recorded, Slopes


class TurnMoved(NamedTuple):
    """How an event moves: the changes of q and v⁺, of its time since the stretch began, and of everything."""

    q: Array
    v: Array
    t: float
    given: Array
    unknowns: Array


class TurnBack(NamedTuple):
    """Gradients by q, v, a at both nodes (2, 3, nq), the numbers, c with the restitutions, and the beginning.

    solved : the adjoint variables
    """

    nodes: Array
    b: Array
    c: Array
    shift: float
    solved: Array


class TurnChange(NamedTuple):
    """The change of the gradient of ℓ by the unknowns, and by what is given."""

    unknowns: Array
    given: Array


class TurnCurvature:
    """The second derivatives of one event.

    Parameters
    ----------
    turn : its first derivatives
    curves : second derivatives by parameters of curves that change, and by the time
    """

    def __init__(self, turn: TurnDerivatives, curves: CurveLagrangian) -> None:
        self._turn, self._curves = turn, curves

    def along(self, nodes: Array, b: Array, c: Array, shift: float) -> TurnMoved:
        """The change of the event for changes of the nodes (2, 3, nq), the numbers and the beginning of the stretch."""
        given = np.concatenate([nodes.ravel(), b, c, [shift]])
        unknowns, nq = self._turn.derivatives @ given, self._turn.system.nq
        q, v, (t,) = np.split(unknowns[self._turn.result], [nq, 2 * nq])
        return TurnMoved(q, v, float(t), given, unknowns)

    def back(self, q: Array, v: Array, t: float, change: TurnChange | None) -> TurnBack:
        """Gradients of those by q, v⁺ and the time; with the change of ℓ where an adjoint changes."""
        turn = self._turn
        bars = np.zeros(len(turn.derivatives))
        np.add.at(bars, turn.result, np.concatenate([q, v, [t]]))
        if change:
            bars = bars - change.unknowns
        found = turn.derivatives.T @ bars - (change.given if change else 0.0)
        nodes, b, c, shift = np.split(
            found, np.cumsum([6 * len(q), len(turn.b), len(found) - 6 * len(q) - len(turn.b) - 1])
        )
        return TurnBack(nodes.reshape(2, 3, -1), b, c, float(shift[0]), turn.adjoint(bars))

    def change(self, moved: TurnMoved, mu: Array) -> TurnChange:
        """The change of the gradient of ℓ along a motion."""
        return _Contracted(self._turn, self._curves, moved, mu).found()


class _Contracted:
    """ℓ of one event along one motion: changes of its gradient, by everything in the equations."""

    def __init__(self, turn: TurnDerivatives, curves: CurveLagrangian, moved: TurnMoved, mu: Array) -> None:
        self._turn, self._curves, self._mu = turn, curves, mu
        rows, unknowns, given = turn.places
        self._by = {name: mu[own] for name, own in rows.items()}
        for name in ("place", "rate", "rate_after"):
            if name in rows:
                self._by[name] = turn.kept * self._by[name]
        self._dots = {name: moved.unknowns[own] for name, own in unknowns.items()}
        nodes, rest = np.split(moved.given, [6 * turn.system.nq])
        self._nodes_dot = nodes.reshape(2, 3, -1)
        first = given["b"].start
        self._dots |= {
            name: rest[given[name].start - first : given[name].stop - first] for name in ("b", "c", "e", "t")
        }
        tau = self._tau = float(self._dots["tau"][0])
        self._dots["t"] = self._dots["t"] + tau
        states = np.einsum("kel,eln->kn", turn.values, self._nodes_dot) + tau * turn.rates
        self._dots |= dict(zip(("q0", "v0"), states, strict=True))
        self._dots.setdefault("after", self._dots["v"])
        sizes = turn.sizes[1] | turn.sizes[2]
        self._found = {name: np.zeros(size) for name, size in sizes.items()}

    def found(self) -> TurnChange:
        """All parts."""
        turn, to, dots = self._turn, self._found, self._dots
        self._projected("position", "q", "q0", turn.turn.q - turn.q0, "sigma", turn.sigma)
        self._projected("velocity", "v", "v0", turn.turn.v - turn.v0, "rho", turn.rho)
        to["q"] += self._part("place", nu=self._by["place"], q=turn.turn.q, q_dot=dots["q"]).q
        rate = self._part(
            "rate", nu=-self._by["rate"], q=turn.turn.q, q_dot=dots["q"], v=turn.turn.v, v_dot=dots["v"]
        )
        to["q"] += rate.q
        to["v"] += rate.v
        self._add(turn.function.turned(self._by["event"], np.zeros(1), self._moved()))
        if turn.is_impact or turn.is_reset:
            self._pushed()
        return self._by_nodes()

    def _moved(self) -> Slopes:
        """The changes of what functions of the event depend on."""
        return Slopes._make(self._dots[name] for name in Slopes._fields)

    def _add(self, found: Slopes) -> None:
        for name, own in found._asdict().items():
            self._found[name] += own

    def _part(self, kind: str, **given: Array) -> Change:
        """A part that is recorded with the equations of steps; what belongs to the numbers and the time is added."""
        turn, none = self._turn, np.zeros(self._turn.system.m)
        lam, nu, lam_dot = (given.pop(name, none) for name in ("lam", "nu", "lam_dot"))
        change = change_at(
            turn.system, kind, turn.turn.t, turn.b, self._dots["b"], lam, nu, lam_dot, self._curves,
            float(self._dots["t"][0]), **given,
        )  # fmt: skip
        self._found["b"] += change.b
        self._found["t"] += change.t
        return change

    def _projected(self, row: str, x: str, x0: str, moved: Array, name: str, multipliers: Array) -> None:
        """M(q̃) (x - x̃) + Φ_q(q̃)ᵀλ."""
        dots, to = self._dots, self._found
        part = self._part(
            "impulse", lam=multipliers, lam_dot=dots[name], q=self._turn.q0, q_dot=dots["q0"], a=moved,
            a_dot=dots[x] - dots[x0], xi=self._by[row],
        )  # fmt: skip
        to["q0"] += part.q
        to[name] += part.lam
        to[x] += part.a
        to[x0] -= part.a

    def _pushed(self) -> None:
        """What an impulse or a function does to the velocities."""
        turn, dots, to, x = self._turn, self._dots, self._found, self._by["impact"]
        base_dot = dots["v"] if turn.is_impact else turn.reset.along(self._moved())
        part = self._part(
            "impulse", lam=turn.Lam, lam_dot=dots["Lam"], nu=-self._by["rate_after"], q=turn.turn.q, q_dot=dots["q"],
            v=turn.after, v_dot=dots["after"], a=turn.after - turn.base, a_dot=dots["after"] - base_dot, xi=x,
        )  # fmt: skip
        to["q"] += part.q
        to["after"] += part.v + part.a
        to["Lam"] += part.lam
        if turn.is_reset:
            weights = -(turn.system.M(turn.turn.q, b=turn.b) @ x)
            self._add(turn.reset.turned(weights, -part.a, self._moved()))
            return
        to["v"] -= part.a
        self._along_output(x, float(self._by["restitution"][0]))

    def _along_output(self, x: Array, kappa: float) -> None:
        """κ f_q (v⁺ + e v) - p f_q x = f_q u."""
        turn, dots, to = self._turn, self._dots, self._found
        v, e, e_dot = turn.turn.v, float(turn.turn.restitution or 0.0), float(turn.by_e @ dots["e"])
        u = kappa * (turn.after + e * v) - turn.p * x
        u_dot = kappa * (dots["after"] + e_dot * v + e * dots["v"]) - dots["p"] * x
        recorded = turn.recorded(turn.turn.along)
        f_q, moved = recorded.slopes.q[0], self._moved()
        found = self._rate_along(recorded, u).turned(np.ones(1), np.zeros(1), moved._replace(v=u_dot))
        self._add(found._replace(v=np.zeros_like(v)))
        f_q_dot = found.v
        to["after"] += kappa * f_q_dot
        to["v"] += kappa * (e * f_q_dot + e_dot * f_q)
        to["p"] -= f_q_dot @ x
        to["e"] += kappa * (f_q_dot @ v + f_q @ dots["v"]) * turn.by_e

    def _rate_along(self, output: Recorded, u: Array) -> Recorded:
        """f_q u as a function of the state, which takes the third derivatives of the output."""
        try:
            return output.rate_along(u)
        except TypeError as wrong:
            event = self._turn.turn
            raise ValueError(
                f"the event {event.name}: second derivatives need third ones of {event.along}, along which its impact "
                f"acts: {wrong}. Take an output of recorded functions."
            ) from wrong

    def _by_nodes(self) -> TurnChange:
        """Those by q̃ and ṽ as those by the nodes and by τ."""
        turn, to, (_, unknowns, given) = self._turn, self._found, self._turn.places
        first = turn.by_given[:, : given["v0"].stop].T @ self._mu  # the gradient itself
        first, change = first.reshape(2, -1), np.array([to["q0"], to["v0"]])
        by_nodes = np.einsum("kel,kn->eln", turn.values, change)
        by_nodes += self._tau * np.einsum("kel,kn->eln", turn.slopes, first)
        rates_dot = np.einsum("kel,eln->kn", turn.slopes, self._nodes_dot)
        rates_dot += self._tau * np.einsum("kel,eln->kn", turn.bends, turn.nodes)
        to["tau"] += np.sum(turn.rates * change) + np.sum(rates_dot * first) + to["t"]
        rest = [to[name] for name in given if name not in ("q0", "v0")]
        return TurnChange(
            np.concatenate([to[name] for name in unknowns]), np.concatenate([by_nodes.ravel(), *rest])
        )
