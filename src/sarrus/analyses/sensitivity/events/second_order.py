"""An event differentiated twice: the contracted second derivatives of its equations, see `first_order`.

With the adjoint variables μ of the equations R, the gradient of ℓ = μᵀR by all that it depends on changes along the
motion; parts of ℓ are those of steps (`shares`), others come from the functions of the event.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ..lagrangians.changes import Change, change_at
from ..lagrangians.curves import CurveLagrangian
from .first_order import EventDerivatives
from .functions import Slopes, TapeValues


class EventAdjointChange(NamedTuple):
    """The change of the gradient of ℓ by the unknowns, and by what is given."""

    unknowns: Array
    given: Array


class EventCurvature:
    """The second derivatives of one event.

    Parameters
    ----------
    derived : its first derivatives
    curves : second derivatives by parameters of curves that change, and by the time
    """

    def __init__(self, derived: EventDerivatives, curves: CurveLagrangian) -> None:
        self._derived, self._curves = derived, curves

    def back(self, result: Array, change: EventAdjointChange | None) -> tuple[Array, Array]:
        """Gradients by all that is given, of those by q, v⁺ and the time (2 nq + 1,), and the adjoint variables.

        With the change of ℓ where an adjoint changes.
        """
        derived = self._derived
        bars = np.zeros(len(derived.derivatives))
        np.add.at(bars, derived.result, result)
        if change:
            bars = bars - change.unknowns
        found = derived.derivatives.T @ bars - (change.given if change else 0.0)
        return np.asarray(found), derived.adjoint(bars)

    def change(self, given: Array, mu: Array) -> EventAdjointChange:
        """The change of the gradient of ℓ with that of all that is given."""
        return _Contracted(self._derived, self._curves, given, mu).found()


class _Contracted:
    """ℓ of one event along one motion: changes of its gradient, by everything in the equations."""

    def __init__(
        self, derived: EventDerivatives, curves: CurveLagrangian, given_dot: Array, mu: Array
    ) -> None:
        self._derived, self._curves, self._mu = derived, curves, mu
        rows, unknowns, given = derived.places
        self._by = {name: mu[own] for name, own in rows.items()}
        for name in ("place", "rate", "rate_after"):
            if name in rows:
                self._by[name] = derived.stored * self._by[name]
        unknowns_dot = derived.derivatives @ given_dot
        self._dots = {name: unknowns_dot[own] for name, own in unknowns.items()}
        nodes, rest = np.split(given_dot, [6 * derived.system.nq])
        self._nodes_dot = nodes.reshape(2, 3, -1)
        first = given["b"].start
        self._dots |= {
            name: rest[given[name].start - first : given[name].stop - first] for name in ("b", "c", "e", "t")
        }
        tau = self._tau = float(self._dots["tau"][0])
        self._dots["t"] = self._dots["t"] + tau
        states = np.einsum("kel,eln->kn", derived.values, self._nodes_dot) + tau * derived.rates
        self._dots |= dict(zip(("q0", "v0"), states, strict=True))
        self._dots.setdefault("after", self._dots["v"])
        sizes = derived.sizes[1] | derived.sizes[2]
        self._found = {name: np.zeros(size) for name, size in sizes.items()}

    def found(self) -> EventAdjointChange:
        derived, to, dots = self._derived, self._found, self._dots
        self._projected("position", "q", "q0", derived.event.q - derived.q0, "sigma", derived.sigma)
        self._projected("velocity", "v", "v0", derived.event.v - derived.v0, "rho", derived.rho)
        to["q"] += self._part("place", nu=self._by["place"], q=derived.event.q, q_dot=dots["q"]).q
        if derived.rolling.any():
            self._rolled(derived.event.q - derived.q0)
        of_event = {"q": derived.event.q, "q_dot": dots["q"], "v": derived.event.v, "v_dot": dots["v"]}
        rate = self._part("rate", nu=-self._by["rate"], **of_event)
        to["q"] += rate.q
        to["v"] += rate.v
        self._add(derived.function.turned(self._by["event"], np.zeros(1), self._moved()))
        if derived.is_impact or derived.is_reset:
            self._pushed()
        return self._by_nodes()

    def _rolled(self, moved: Array) -> None:
        """Φ_q(q̃) (q - q̃) of nonholonomic constraints."""
        derived, dots, to = self._derived, self._dots, self._found
        part = self._part(
            "rate", nu=-derived.rolling * self._by["place"], q=derived.q0, q_dot=dots["q0"], v=moved,
            v_dot=dots["q"] - dots["q0"],
        )  # fmt: skip
        to["q0"] += part.q - part.v
        to["q"] += part.v

    def _moved(self) -> Slopes:
        """The changes of what functions of the event depend on."""
        return Slopes._make(self._dots[name] for name in Slopes._fields)

    def _add(self, found: Slopes) -> None:
        for name, own in found._asdict().items():
            self._found[name] += own

    def _part(self, kind: str, **given: Array) -> Change:
        """A part that is recorded with the equations of steps; what belongs to the numbers and the time is added."""
        derived, none = self._derived, np.zeros(self._derived.system.m)
        lam, nu, lam_dot = (given.pop(name, none) for name in ("lam", "nu", "lam_dot"))
        change = change_at(
            derived.system, kind, derived.event.t, derived.b, self._dots["b"], lam, nu, lam_dot, self._curves,
            float(self._dots["t"][0]), **given,
        )  # fmt: skip
        self._found["b"] += change.b
        self._found["t"] += change.t
        return change

    def _projected(self, row: str, x: str, x0: str, moved: Array, name: str, multipliers: Array) -> None:
        """M(q̃) (x - x̃) + Φ_q(q̃)ᵀλ."""
        dots, to = self._dots, self._found
        part = self._part(
            "impulse", lam=multipliers, lam_dot=dots[name], q=self._derived.q0, q_dot=dots["q0"], a=moved,
            a_dot=dots[x] - dots[x0], xi=self._by[row],
        )  # fmt: skip
        to["q0"] += part.q
        to[name] += part.lam
        to[x] += part.a
        to[x0] -= part.a

    def _pushed(self) -> None:
        """What an impulse or a function does to the velocities."""
        derived, dots, to, x = self._derived, self._dots, self._found, self._by["impact"]
        base_dot = dots["v"] if derived.is_impact else derived.reset.along(self._moved())
        part = self._part(
            "impulse", lam=derived.Lam, lam_dot=dots["Lam"], nu=-self._by["rate_after"], q=derived.event.q,
            q_dot=dots["q"],
            v=derived.after, v_dot=dots["after"], a=derived.after - derived.base, a_dot=dots["after"] - base_dot, xi=x,
        )  # fmt: skip
        to["q"] += part.q
        to["after"] += part.v + part.a
        to["Lam"] += part.lam
        if derived.is_reset:
            weights = -(derived.system.M(derived.event.q, b=derived.b) @ x)
            self._add(derived.reset.turned(weights, -part.a, self._moved()))
            return
        to["v"] -= part.a
        self._along_output(x, float(self._by["restitution"][0]))

    def _along_output(self, x: Array, kappa: float) -> None:
        """κ (f_q v⁺ + f_t + e (f_q v + f_t)) - p f_q x = f_q u + f_t s."""
        derived, dots, to = self._derived, self._dots, self._found
        v, e, e_dot = (
            derived.event.v,
            float(derived.event.restitution or 0.0),
            float(derived.by_e @ dots["e"]),
        )
        u = kappa * (derived.after + e * v) - derived.p * x
        u_dot = kappa * (dots["after"] + e_dot * v + e * dots["v"]) - dots["p"] * x
        along, along_dot = np.append(u, kappa * (1 + e)), np.append(u_dot, kappa * e_dot)
        recorded = derived.recorded(derived.event.along)
        f_q, moved = recorded.slopes.q[0], self._moved()
        found = self._rate_along(recorded, along).turned(np.ones(1), np.zeros(1), moved._replace(v=along_dot))
        self._add(found._replace(v=np.zeros_like(v)))
        f_q_dot, f_t_dot = found.v[:-1], float(found.v[-1])
        to["after"] += kappa * f_q_dot
        to["v"] += kappa * (e * f_q_dot + e_dot * f_q)
        to["p"] -= f_q_dot @ x
        to["e"] += kappa * (f_q_dot @ v + f_q @ dots["v"] + f_t_dot) * derived.by_e

    def _rate_along(self, output: TapeValues, along: Array) -> TapeValues:
        """f_q u + f_t s as a function of the state, which takes the third derivatives of the output."""
        try:
            return output.rate_along(along)
        except TypeError as wrong:
            event = self._derived.event
            raise ValueError(
                f"the event {event.name}: second derivatives need third ones of {event.along}, along which its impact "
                f"acts: {wrong}. Take an output of recorded functions."
            ) from wrong

    def _by_nodes(self) -> EventAdjointChange:
        """Those by q̃ and ṽ as those by the nodes and by τ."""
        derived, to, (_, unknowns, given) = self._derived, self._found, self._derived.places
        first = derived.by_given[:, : given["v0"].stop].T @ self._mu  # the gradient itself
        first, change = first.reshape(2, -1), np.array([to["q0"], to["v0"]])
        by_nodes = np.einsum("kel,kn->eln", derived.values, change)
        by_nodes += self._tau * np.einsum("kel,kn->eln", derived.slopes, first)
        rates_dot = np.einsum("kel,eln->kn", derived.slopes, self._nodes_dot)
        rates_dot += self._tau * np.einsum("kel,eln->kn", derived.bends, derived.nodes)
        to["tau"] += np.sum(derived.rates * change) + np.sum(rates_dot * first) + to["t"]
        rest = [to[name] for name in given if name not in ("q0", "v0")]
        return EventAdjointChange(
            np.concatenate([to[name] for name in unknowns]), np.concatenate([by_nodes.ravel(), *rest])
        )
