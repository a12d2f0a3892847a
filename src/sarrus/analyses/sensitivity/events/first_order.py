"""First derivatives of an event: of its time within a step, and of the velocities after it.

The state at an event is interpolated, q̃(τ), ṽ(τ), at the time τ since the last step began, and made consistent by the
least changes; the event is where ψ(t, q, v) = 0:

    M(q̃) (q - q̃) + Φ_q(q̃)ᵀσ = 0,    Φ(q) = 0,
    M(q̃) (v - ṽ) + Φ_q(q̃)ᵀρ = 0,    Φ_q v + Φ_t = 0,    ψ = 0.

After an impact along the output f by an impulse p, or where a function g gives other velocities,

    M (v⁺ - v) + Φ_qᵀΛ = f_qᵀ p,    Φ_q v⁺ + Φ_t = 0,    f_q v⁺ + f_t = -e (f_q v + f_t),
    M (v⁺ - g) + Φ_qᵀΛ = 0,         Φ_q v⁺ + Φ_t = 0.

All of these equations are differentiated together. The multipliers of equations that others imply are zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from ....algebra import Array
from ....elements.operators import OPERATORS
from ....linalg.factors import LUFactors, SingularSystem
from ....outputs.recording import Angles
from ....results import EventStep, StepsTaken
from ....results.motion.steps import last_of
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ....system.curves.time_derivatives import timed
from ...dynamics.events.switching_functions import Corner
from ...equations.motion import KKTMatrix
from ..chain.chain import SegmentChain
from ..sampling.sampling import apart, interpolation
from .functions import TapeValues, recorded
from .infinite_slopes import EndOfLaw
from .reactions import recorded_solved, solves

STEPS = 16  # before a corner at which slopes become infinite, whose state at their end follows the corner
# of the tolerance of the steps: an event whose function goes no farther below zero only grazes
SHALLOW = 1e-3
ROUND_OFF = 1000 * np.finfo(float).eps  # of q [m] in a third derivative over a step of 1 s
CONSTRAINTS = {"place": "sigma", "rate": "rho", "rate_after": "Lam"}  # and their multipliers
FORCES = ("position", "velocity", "impact")  # equations with masses
Grid = Mapping[tuple[str, str], Any]


class EventDerivatives:
    """The derivatives of the state after an event, and of its time within the step.

    Parameters
    ----------
    system : System
    steps : those before it; it lies in the last one
    event : the event
    restitutions : names of those of all events
    angles : the joints' coordinates along the run, with all their revolutions
    by_numbers : whether derivatives by the numbers of the elements are complete; errors of states need none

    Attributes
    ----------
    values, slopes, bends : shares of q, v, a at both nodes in q̃ and ṽ, and their derivatives by the time (2, 2, 3)
    rates : (2, nq) derivatives of q̃ and ṽ by the time
    nodes : (2, 3, nq) q, v, a at both nodes
    q0, v0, sigma, rho, after, base, Lam, p : q̃, ṽ, σ, ρ, v⁺, the velocities v or g that an impulse changes, Λ, p
    by_e : (restitutions,) the derivatives of the restitution
    matrix : (2 nq + 1, 6 nq + len(b) + len(c) + restitutions + 1) the derivatives of q, of v⁺ (v, where the run ended),
        of the time since the segment began: by q, v, a at both ends of the last step, by the numbers, by those of
        joints' coordinates, by the restitutions, and by the time at which the segment began

    Raises
    ------
    ValueError
        For an event that only grazes, and for Python functions that cannot be recorded.
    """

    def __init__(
        self,
        system: System,
        steps: StepsTaken,
        event: EventStep,
        restitutions: Sequence[str],
        angles: Angles,
        by_numbers: bool = True,
    ) -> None:
        self.system, self.event, self._steps, self._angles = system, event, steps, angles
        self._by_numbers = by_numbers
        self.b = steps.b.copy()
        self.b[steps.places] = steps.memory[-1]
        left_out = steps.left_out[len(steps) - 1] if len(steps.left_out) else np.zeros(system.m, dtype=bool)
        self.stored = 1.0 - left_out
        self._curves = CurveDerivatives(system)
        name = f"{event.name}.restitution"
        self.by_e = np.array([float(own == name) for own in restitutions])
        self._interpolate()
        self._refuse_grazing()
        self._solve_multipliers(np.flatnonzero(self.stored) if left_out.any() else None)

    @property
    def is_impact(self) -> bool:
        """Whether velocities change by an impulse along an output."""
        return self.event.along is not None

    @property
    def is_reset(self) -> bool:
        """Whether a function gives other velocities."""
        return not self.is_impact and self.event.reset is not None

    @cached_property
    def function(self) -> TapeValues:
        """ψ."""
        return self.recorded(self.event.function)

    @cached_property
    def output(self) -> TapeValues:
        """The output along which an impulse acts, a copy for each coordinate."""
        return self.recorded(self.event.along, self.system.nq)

    @property
    def _approach(self) -> float:
        """ḟ before the impact, f_q v + f_t."""
        slopes = self.output.slopes
        return float(slopes.q[0] @ self.event.v + slopes.t[0, 0])

    @cached_property
    def reset(self) -> TapeValues:
        """The function that gives velocities."""
        return self.recorded(self.event.reset)

    def recorded(self, function: Any, copies: int = 1, at: EventStep | None = None) -> TapeValues:
        """A function of the event, recorded at its state, or at another one."""
        event = at or self.event
        if isinstance(function, str) and solves(self.system, function):
            return recorded_solved(self.system, self._steps, event, function, self.b, self._angles)
        return recorded(self.system, event, function, self.b, self._angles, copies)

    def _interpolate(self) -> None:
        steps, n = self._steps, len(self._steps) - 1
        h = np.array([float(steps.h[n])])
        s = (self.event.t - steps.t[n : n + 1]) / h
        found = interpolation(s, h, apart(steps))
        self.values, self.slopes, self.bends = (x[0, :2] for x in found)
        self.nodes = np.array([[getattr(steps, kind)[n + e] for kind in ("q", "v", "a")] for e in (0, 1)])
        self.q0, self.v0 = np.einsum("kel,eln->kn", self.values, self.nodes)
        self.rates = np.einsum("kel,eln->kn", self.slopes, self.nodes)
        self._choose_bend_of_v(s, h)
        if self._end_of_law and self._end_of_law.first:
            self.rates = self._rates_of_steps()

    @property
    def infinite_curvature(self) -> str:
        """The part of the model whose corner this is, if second slopes of a force become infinite there; else empty."""
        corner, law = self.event.function, self._end_of_law
        return corner.owner if isinstance(corner, Corner) and law and law.second else ""

    @cached_property
    def _end_of_law(self) -> EndOfLaw | None:
        """Whether slopes of forces become infinite at a corner; None for other events."""
        event = self.event
        if not isinstance(event.function, Corner):
            return None
        return EndOfLaw(self.system, self._steps, self.b, event.q, event.v)

    def _rates_of_steps(self) -> Array:
        """The derivatives of q̃ and ṽ by the time of the last steps as a whole.

        Slopes of forces at their end, which are too large, change them as much as derivatives by parameters. The change
        of the state at the corner contains both, and is free of such slopes.
        """
        last = last_of(self._steps, STEPS)
        chain = SegmentChain(self.system, last, timed(self.system))
        later = np.zeros((chain.by_curves.width, 1))
        later[len(self.b) :] = 1.0
        found = chain.along(last.v[0][:, None], last.a[0][:, None], later)
        nodes = np.array([[getattr(found, kind)[e, :, 0] for kind in ("q", "v", "a")] for e in (-2, -1)])
        return np.asarray(np.einsum("kel,eln->kn", self.values, nodes))

    def _choose_bend_of_v(self, s: Array, h: Array) -> None:
        """Take v̈ from v and a alone where that from q, v and a may be round-off, which is up to 1000 ε |q|/h³.

        A step that ends at a corner or before an event can be that short.
        """
        apart_from_q = interpolation(s, h, True).bends[0, 1]
        differs = abs(np.einsum("el,eln->n", self.bends[1] - apart_from_q, self.nodes)).max(initial=0.0)
        if differs <= ROUND_OFF * abs(self.nodes[:, 0]).max(initial=0.0) / float(h[0]) ** 3:
            self.bends[1] = apart_from_q

    def _refuse_grazing(self) -> None:
        """An event whose function hardly crosses zero may come or not: its time has no derivative."""
        steps, event = self._steps, self.event
        if isinstance(event.function, Corner):
            return  # a step ends there only where its time is certain
        psi, bend = self.function.slopes, abs(self._rate_at(-1) - self._rate_at(-2)) / float(steps.h[-1])
        known = sum(
            abs(w[0]) @ (steps.rtol * abs(x) + steps.atol) for w, x in ((psi.q, event.q), (psi.v, event.v))
        )
        rate = float((psi.q @ self.rates[0] + psi.v @ self.rates[1] + psi.t[:, 0])[0])
        if not rate * rate > 2 * bend * SHALLOW * known:
            raise ValueError(
                f"the event {event.name} at t = {event.t:.6g} s only grazes: its function changes by {rate:.2g} in a "
                "second there, so that a slightly other motion would not meet it, and its time has no derivative. "
                "Move what it looks for away from where the function has an extreme, or leave the event out."
            )

    def _rate_at(self, k: int) -> float:
        """ψ̇ at a node."""
        t, q, v, a = (getattr(self._steps, name)[k] for name in ("t", "q", "v", "a"))
        psi = self.recorded(self.event.function, at=replace(self.event, t=float(t), q=q, v=v)).slopes
        return float((psi.q @ v + psi.v @ a + psi.t[:, 0])[0])

    def _solve_multipliers(self, stored: Array | None) -> None:
        system, event, b = self.system, self.event, self.b
        kkt, none = KKTMatrix(system, rows=stored), np.zeros(system.m)
        M0 = system.M(self.q0, b=b)
        self._unit = float(abs(M0.data).max(initial=0.0)) or 1.0
        kkt.factor_at(b, event.t, self.q0)
        self.sigma, self.rho = (
            kkt.solve_pair(-(M0 @ moved), none)[1] for moved in (event.q - self.q0, event.v - self.v0)
        )
        self.base, self.after, self.Lam, self.p = event.v, event.v, none, 0.0
        if self.is_impact or self.is_reset:
            kkt.factor_at(b, event.t, event.q)
        if self.is_impact:
            f_q, e = self.output.slopes.q[0], float(event.restitution or 0.0)
            w, sigma = kkt.solve_pair(f_q, none)
            self.p = -(1 + e) * self._approach / float(f_q @ w)
            self.after, self.Lam = event.v + self.p * w, self.p * sigma
        elif self.is_reset:
            gap = system.Phi_q_xi(event.q, event.after, event.t, b=b) + system.Phi_t(event.q, event.t, b=b)
            s, sigma = kkt.solve_pair(np.zeros(system.nq), gap)
            self.base, self.after, self.Lam = event.after, event.after - s, -sigma

    @cached_property
    def sizes(self) -> list[dict[str, int]]:
        """Sizes of the equations, the unknowns and the given quantities."""
        nq, m, c = self.system.nq, self.system.m, len(self.system.joint_coordinates.b)
        rows = {"position": nq, "place": m, "velocity": nq, "rate": m, "event": 1}
        unknowns = {"q": nq, "sigma": m, "v": nq, "rho": m, "tau": 1}
        if self.is_impact or self.is_reset:
            rows, unknowns = rows | {"impact": nq, "rate_after": m}, unknowns | {"after": nq, "Lam": m}
        if self.is_impact:
            rows, unknowns = rows | {"restitution": 1}, unknowns | {"p": 1}
        return [rows, unknowns, {"q0": nq, "v0": nq, "b": len(self.b), "c": c, "e": len(self.by_e), "t": 1}]

    @cached_property
    def places(self) -> list[dict[str, slice]]:
        """First indices of each of them."""
        ends = [np.cumsum([0, *own.values()]).tolist() for own in self.sizes]
        pairs = zip(self.sizes, ends, strict=True)
        return [dict(zip(own, map(slice, at[:-1], at[1:]), strict=True)) for own, at in pairs]

    @cached_property
    def by_given(self) -> csr_array:
        """The derivatives of the equations by q̃, ṽ, the numbers, the restitutions and the time."""
        return self._joined(self._grid, 2)

    @cached_property
    def _factors(self) -> tuple[LUFactors, Array, Array]:
        """Those of the derivatives by the unknowns, with factors of rows and columns that make masses about 1."""
        rows, unknowns, given = self.places
        by_rates = self.by_given[:, : given["v0"].stop] @ self.rates.ravel()
        by_time = by_rates + self.by_given[:, [given["t"].start]].toarray()[:, 0]
        matrix = self._joined(self._grid | {("", "tau"): csr_array(by_time[:, None])}, 1)
        down, across = np.ones(matrix.shape[0]), np.ones(matrix.shape[1])
        for name in FORCES:
            down[rows.get(name, slice(0))] = 1 / self._unit
        for name in (*CONSTRAINTS.values(), "p"):
            across[unknowns.get(name, slice(0))] = self._unit
        scaled = matrix.tocoo()
        scaled.data *= down[scaled.row] * across[scaled.col]
        try:
            return LUFactors(scaled.tocsr()), down, across
        except SingularSystem:
            raise SingularSystem(
                f"{self.system.name}: the state at {self.event.name} at t = {self.event.t:.6g} s has no derivatives "
                "with a digit: a force there is too steep, or constraints are dependent. Make the force less steep, "
                "or end the run before."
            ) from None

    def _joined(self, grid: Grid, kind: int) -> csr_array:
        """Blocks as one matrix; those of constraints that others imply make their multipliers zero."""
        rows, columns = self.places[0], self.places[kind]
        parts = []
        for (row, column), block in grid.items():
            if column in columns and (row in rows or not row):
                own = coo_array(block)
                at = own.row + (rows[row].start if row else 0)
                parts.append((own.data, at, own.col + columns[column].start))
        data, at, to = (np.concatenate(x) for x in zip(*parts, strict=True))
        shape = [sum(self.sizes[n].values()) for n in (0, kind)]
        return csr_array(coo_array((data, (at, to)), shape=shape))

    @cached_property
    def derivatives(self) -> Array:
        """Return the derivatives of all unknowns by q, v, a at both nodes, parameters, restitutions and start."""
        given = self.places[2]
        factors, down, across = self._factors
        found = -across[:, None] * factors.solve(down[:, None] * self.by_given.toarray())
        if not np.all(np.isfinite(found)):
            raise SingularSystem(f"the equations of the event {self.event.name} are singular")
        parts = zip(self.values, (found[:, given["q0"]], found[:, given["v0"]]), strict=True)
        by_nodes = sum(np.einsum("el,xn->xeln", shares, by) for shares, by in parts)
        return np.concatenate([np.reshape(by_nodes, (len(found), -1)), found[:, given["b"].start :]], axis=1)

    def adjoint(self, bars: Array) -> Array:
        """The adjoint variables of all equations, of what has the gradients given by the unknowns."""
        factors, down, across = self._factors
        return np.asarray(down * factors.transposed(across * bars))

    @cached_property
    def result(self) -> Array:
        """The places of q, v⁺ and τ among the unknowns."""
        own = self.places[1]
        return np.concatenate(
            [np.arange(x.start, x.stop) for x in (own["q"], own.get("after", own["v"]), own["tau"])]
        )

    @property
    def matrix(self) -> Array:
        return np.asarray(self.derivatives[self.result])

    @cached_property
    def _turning(self) -> Array:
        """Φ_qt (m, nq)."""
        system, event = self.system, self.event
        if not any(p.kind.rows and p.kind.timed for p in system.populations):
            return np.zeros((system.m, system.nq))
        columns = [system.Phi_q_xi_t(event.q, xi, event.t, b=self.b) for xi in np.eye(system.nq)]
        return np.array(columns).reshape(system.nq, system.m).T

    def _by_b(self, name: str, q: Array, *operands: Array) -> csr_array:
        """The derivatives of an operator by the numbers, also those of curves."""
        t, b = self.event.t, self.b
        if not self._by_numbers:
            return csr_array((self.system.pattern(name).size, len(b)))
        found = getattr(self.system, f"{name}_b")(q, *operands, *([] if name == "M_a" else [t]), b=b)
        found = csr_array((found.data, found.indices, found.indptr), shape=(found.shape[0], len(b)))
        if not self._curves or name == "M_a":
            return found
        kinds = dict(zip(OPERATORS[name].operands, operands, strict=False))
        return csr_array(found + self._curves.matrix(name, b=b, t=t, q=q, **kinds))

    @cached_property
    def _grid(self) -> dict[tuple[str, str], Any]:
        """The derivatives of all equations by everything in them."""
        system, event, b, q0, q = self.system, self.event, self.b, self.q0, self.event.q
        M0, J0, J = system.M(q0, b=b), system.Phi_q(q0, event.t, b=b), system.Phi_q(q, event.t, b=b)
        psi, stored = self.function.slopes, diags_array(self.stored)
        grid = {
            **self._place(J0, J),
            **{("event", name): getattr(psi, name) for name in ("q", "v", "b", "c", "t")},
            **self._force("position", q0, event.q - q0, self.sigma, "q0"),
            **self._force("velocity", q0, event.v - self.v0, self.rho, "q0"),
            **self._rate("rate", event.v, "v"),
        }  # fmt: skip
        for row, x, x0, multiplier in (("position", "q", "q0", "sigma"), ("velocity", "v", "v0", "rho")):
            grid |= {(row, x): M0, (row, x0): grid.get((row, x0), 0 * M0) - M0, (row, multiplier): J0.T}
        if self.is_impact or self.is_reset:
            force = self._force("impact", q, self.after - self.base, self.Lam, "q")
            grid |= force | self._rate("rate_after", self.after, "after")
            grid |= self._struck(system.M(q, b=b), force)
            grid |= {("impact", "Lam"): J.T}
        for row, multiplier in {} if self.stored.all() else CONSTRAINTS.items():
            grid |= {at: stored @ csr_array(block) for at, block in grid.items() if at[0] == row}
            grid[row, multiplier] = diags_array(1 - self.stored)
        return grid

    @cached_property
    def rolling(self) -> Array:
        """1 for nonholonomic constraints, which q̃ follows by Φ_q(q̃) (q - q̃) = 0, else 0 (m,)."""
        return np.asarray(np.arange(self.system.m) >= self.system.m_holonomic, dtype=float)

    def _place(self, J0: csr_array, J: csr_array) -> dict[tuple[str, str], Any]:
        """The derivatives of Φ = 0, or of the condition on q that replaces it."""
        system, q0, q, t, b = self.system, self.q0, self.event.q, self.event.t, self.b
        found = {("place", "b"): self._by_b("Phi", q), ("place", "t"): system.Phi_t(q, t, b=b)[:, None]}
        if not self.rolling.any():
            return found | {("place", "q"): J}
        rolls, others = diags_array(self.rolling), diags_array(1 - self.rolling)
        turned = system.Phi_q_xi_q(q0, q - q0, t, b=b)
        found["place", "b"] = found["place", "b"] + rolls @ self._by_b("Phi_q_xi", q0, q - q0)
        return found | {("place", "q"): others @ J + rolls @ J0, ("place", "q0"): rolls @ (turned - J0)}

    def _force(
        self, row: str, q: Array, moved: Array, multipliers: Array, by: str
    ) -> dict[tuple[str, str], Any]:
        """The derivatives of M x + Φ_qᵀλ with x and λ held."""
        system, t, b = self.system, self.event.t, self.b
        by_q = system.M_a_q(q, moved, b=b) + system.Phi_qT_lam_q(q, multipliers, t, b=b)
        by_b = self._by_b("M_a", q, moved) + self._by_b("Phi_qT_lam", q, multipliers)
        return {(row, by): by_q, (row, "b"): by_b, (row, "t"): (self._turning.T @ multipliers)[:, None]}

    def _rate(self, row: str, v: Array, by: str) -> dict[tuple[str, str], Any]:
        """Add the derivatives of Φ_q v + Φ_t."""
        system, q, t, b = self.system, self.event.q, self.event.t, self.b
        by_q = system.Phi_q_xi_q(q, v, t, b=b) + csr_array(self._turning)
        by_t = self._turning @ v + system.Phi_tt(q, t, b=b)
        by_b = self._by_b("Phi_q_xi", q, v) + self._by_b("Phi_t", q)
        J = system.Phi_q(q, t, b=b)
        return {(row, "q"): by_q, (row, by): J, (row, "t"): by_t[:, None], (row, "b"): by_b}

    def _struck(self, M: csr_array, force: Grid) -> dict[tuple[str, str], Any]:
        """Those of what an impulse or a function does to the velocities, beyond `_force`."""
        event = self.event
        found: dict[tuple[str, str], Any] = {("impact", "after"): M}
        if self.is_reset:
            slopes = self.reset.slopes
            for name in ("q", "v", "b", "c", "t"):
                found["impact", name] = force.get(("impact", name), 0) - M @ getattr(slopes, name)
            return found
        f_q, bends, e = self.output.slopes.q[0], self.output.bends, float(event.restitution or 0.0)
        sides, by_time = self.after + e * event.v, self.output.bends_by_time
        for name in ("q", "b", "c", "t"):
            bend = getattr(bends, name)
            found["impact", name] = force.get(("impact", name), 0) - self.p * bend
            found["restitution", name] = (sides @ bend)[None] + (1 + e) * getattr(by_time, name)
        found |= {("impact", "v"): -M, ("impact", "p"): -f_q[:, None]}
        found |= {("restitution", "after"): f_q[None], ("restitution", "v"): e * f_q[None]}
        return found | {("restitution", "e"): self._approach * self.by_e[None]}
