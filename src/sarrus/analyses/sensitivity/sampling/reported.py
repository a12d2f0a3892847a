"""Multipliers as runs report them, with their derivatives: of minimum norm where constraints are redundant.

Steps solve a choice of independent equations and leave the multipliers of the others zero. Reported is λ̂ = P λ with
P = 1 - N NᵀG, the norm λᵀG λ, see `joint_wrenches`, and a basis N of the left null space of J = Φ_q with NᵀGN = 1.
With μ = λ - λ̂, for which Jᵀμ = 0, and a ξ with J ξ = G λ̂,

    λ̂' = P (λ' + J⁺ᵀ (J')ᵀμ) - N Nᵀ (G' λ̂ - J' ξ)

for changes of the state on the constraints and of the parameters that keep the equations redundant. With coordinates of
its own for each joint G = Ĵ K Ĵᵀ, J ξ = Ĵ ξ̂, and the last term follows from ζ = K Ĵᵀλ̂ - ξ̂.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ....elements.operators import OPERATORS
from ....linalg.factors import SingularSystem
from ....results import Segments, StepsTaken
from ....results.motion.steps import segments_of
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ...equations.joint_wrenches import Wrenches, separated, supports
from ...equations.minimum_norm import MinimumNorm, MinimumNormChoice
from ..chain.chain import Nodes
from ..steps.sweep_loop import NodeArrays

# Changes of the times of all nodes (n, k), or gradients by them
Times: TypeAlias = "Array | Sequence[Array]"


class ReportedStates(NamedTuple):
    """Times, coordinates and multipliers of all nodes, which equations are left out there, and what elements store."""

    t: Array
    q: Array
    lam: Array
    left_out: Array
    memory: Array


class Changes(NamedTuple):
    """Changes of the coordinates (nq, k), the parameters (len(b), k) and the time (k,), or gradients by them."""

    q: Array
    b: Array
    t: Array


class Partials(NamedTuple):
    """The derivatives of an operator by the coordinates, by the parameters, also those of curves, and by the time."""

    q: csr_array
    b: csr_array
    curves: csr_array | None
    t: Array

    def along(self, change: Changes) -> Array:
        """The operator's change."""
        found = self.q @ change.q + self.b @ change.b[: self.b.shape[1]] + np.outer(self.t, change.t)
        return np.asarray(found if self.curves is None else found + self.curves @ change.b)

    def add_gradients(self, bar: Array, to: Changes) -> None:
        """Add the gradients of what has the gradient `bar` by the operator."""
        to.q[:] += self.q.T @ bar
        to.b[: self.b.shape[1]] += self.b.T @ bar
        to.t[:] += self.t @ bar
        if self.curves is not None:
            to.b[:] += self.curves.T @ bar


class Slopes(NamedTuple):
    """The derivatives of λ̂ at a node.

    Attributes
    ----------
    minimum : solves at this node
    least : N and GN
    wrenches : K and Ĵ
    mu, lam, xi : λ - λ̂ (m,), λ̂ (m,) and ξ (nq,)
    pull : those of Jᵀμ
    balance : those of Nᵀ (G λ̂ - J ξ) by what G and J depend on, one column each
    """

    minimum: MinimumNorm
    least: MinimumNormChoice
    wrenches: Wrenches
    mu: Array
    lam: Array
    xi: Array
    pull: Partials
    balance: Changes

    def along(self, change: Changes, lam: Array) -> Array:
        """λ̂' (m, k) for changes of the state and of λ."""
        moved = self.least.choose(lam + self.minimum.forces(self.pull.along(change)))
        return np.asarray(moved - self.least.null @ _contracted(self.balance, change))

    def transposed(self, bar: Array, to: Changes) -> Array:
        """Gradients by λ of those by λ̂ (m, k); those by the state are added."""
        across = self.least.transposed(bar)
        self.pull.add_gradients(self.minimum.motions(across), to)
        _add(to, self.balance, -(self.least.null.T @ bar))
        return across


def _contracted(of: Changes, change: Changes) -> Array:
    """The changes of functions with these gradients."""
    return np.asarray(of.q.T @ change.q + of.b.T @ change.b + np.outer(of.t, change.t))


def _add(to: Changes, gradients: Changes, by: Array) -> None:
    """Add combinations of gradients."""
    for one, gradient in zip(to, gradients, strict=True):
        one += gradient @ by


class Reporter:
    """The reported multipliers at the nodes of a run.

    Parameters
    ----------
    system, steps : the run
    moving : whether events move its nodes in time; by default, whether it has any
    """

    def __init__(self, system: System, steps: StepsTaken | Segments, moving: bool | None = None) -> None:
        self._system, self._b, self._steps = system, steps.b.copy(), segments_of(steps)
        timed = any(p.kind.rows and p.kind.timed for p in system.populations)
        self._moving = timed and (isinstance(steps, Segments) if moving is None else moving)
        self._known: dict[int, Array] = {}
        self._choices: dict[bytes, MinimumNorm] = {}

    @cached_property
    def redundant(self) -> bool:
        """Whether any equations are left out at any time."""
        return any(bool(segment.left_out.any()) for segment in self._steps)

    @cached_property
    def _at(self) -> ReportedStates:
        """The states at all nodes."""
        segments, m = self._steps, self._system.m
        known = ([getattr(own, name) for own in segments] for name in ("t", "q", "lam"))
        left_out = [
            own.left_out if len(own.left_out) else np.zeros((len(own.t), m), bool) for own in segments
        ]
        memory = [x for own in segments for x in (own.memory, own.memory[-1:])]
        return ReportedStates._make(map(np.concatenate, (*known, left_out, memory)))

    @cached_property
    def _dependent(self) -> Array:
        """The nodes at which equations are left out."""
        return np.flatnonzero(self._at.left_out.any(axis=1)) if self.redundant else np.zeros(0, np.int64)

    def times(self, shift: Array) -> list[Array]:
        """Changes of the times of all nodes, or gradients by them, as views of those of the segments."""
        counts = [len(own.t) for own in self._steps] if self.redundant else []
        return [own for own, count in zip(shift, counts, strict=False) for _ in range(count)]

    def lam(self, rows: Array) -> Array:
        """All multipliers (nodes, m), those at some nodes as they are reported."""
        found = self._at.lam.copy()
        for row in np.intersect1d(rows, self._dependent).tolist():
            if row not in self._known:
                self._known[row] = self._reported(row)
            found[row] = self._known[row]
        return found

    def along(self, change: Nodes | NodeArrays, b: Array, t: Times, rows: Array | None = None) -> Array:
        """The changes of multipliers as they are reported (n, m, k), at some nodes or all.

        With those of the states, of the parameters (len(b), k) and of the times (n, k).
        """
        chosen = self._dependent if rows is None else np.intersect1d(rows, self._dependent)
        lam = change.lam.copy() if len(chosen) else change.lam
        for row in chosen.tolist():
            if slopes := self.slopes(row):
                lam[row] = slopes.along(Changes(change.q[row], b, t[row]), lam[row])
        return lam

    def transposed(self, by: Nodes | NodeArrays, t: Times) -> Array:
        """Turn gradients by reported multipliers into those by the states and times; those by the parameters."""
        by_b = np.zeros((len(self._b), by.lam.shape[2]))
        for row in self._dependent[by.lam[self._dependent].any(axis=(1, 2))].tolist():
            if slopes := self.slopes(row):
                by.lam[row] = slopes.transposed(by.lam[row], Changes(by.q[row], by_b, t[row]))
        return by_b

    def _minimum(self, row: int) -> MinimumNorm | None:
        """Return the solver of minimum norm; None if all equations are independent."""
        choice = self._at.left_out[row]
        if not choice.any():
            return None
        key = choice.tobytes()
        if key not in self._choices:
            self._choices[key] = MinimumNorm(self._system, np.flatnonzero(~choice))
        return self._choices[key]

    def _jacobian(self, row: int) -> csr_array:
        self._b[self._steps[0].places] = self._at.memory[row]
        return self._system.Phi_q(self._at.q[row], float(self._at.t[row]), b=self._b)

    def _reported(self, row: int) -> Array:
        lam: Array = self._at.lam[row]
        minimum = self._minimum(row)
        if minimum is None:
            return lam
        try:
            J = self._jacobian(row)
            return minimum.least(self._system, J, self._at.q[row], self._b).choose(lam)
        except SingularSystem:  # where all choices are dependent runs leave them as they are, too
            return lam

    def slopes(self, row: int) -> Slopes | None:
        """The derivatives at a node; none where all equations are independent, or all choices of them dependent."""
        minimum = self._minimum(row)
        if minimum is None:
            return None
        J = self._jacobian(row)
        wrenches = Wrenches(self._system, J, self._at.q[row], self._b)
        try:
            least = MinimumNormChoice.of(wrenches, minimum.null(J))
        except SingularSystem:
            return None
        lam = least.choose(self._at.lam[row])
        eta, mu = wrenches.deflections(lam), self._at.lam[row] - lam
        xi = minimum.motions((wrenches.J @ eta)[:, None])[:, 0]
        balance = self._balance(row, lam, eta - wrenches.of.copies(xi), least, wrenches)
        return Slopes(minimum, least, wrenches, mu, lam, xi, self._by("Phi_qT_lam", row, mu), balance)

    def _balance(
        self, row: int, lam: Array, zeta: Array, least: MinimumNormChoice, wrenches: Wrenches
    ) -> Changes:
        """The gradients of Nᵀ (Ĵ K Ĵᵀλ + Ĵ (ζ - K Ĵᵀλ)) by what Ĵ and K depend on, with N, λ and ζ - K Ĵᵀλ constant."""
        null, count = least.null, least.null.shape[1]
        sizes = wrenches.J.shape[1], len(self._b)
        found = Changes(np.zeros((sizes[0], count)), np.zeros((sizes[1], count)), np.zeros(count))
        bent = np.array([wrenches.deflections(n) for n in null.T]).reshape(count, -1).T
        self._by("Phi_q_xi", row, zeta, apart=True).add_gradients(null, found)
        self._by("Phi_qT_lam", row, lam, apart=True).add_gradients(bent, found)
        for k in range(count):
            by_q, by_b = wrenches.gradients(wrenches.forces(null[:, k]), wrenches.forces(lam))
            found.q[:, k] += by_q
            found.b[:, k] += by_b
        return found._replace(q=wrenches.of.collected(found.q, self._system.nq))

    def _by(self, name: str, row: int, operand: Array, apart: bool = False) -> Partials:
        """The derivatives of an operator; by the coordinates of the bodies, or by those that each joint has alone."""
        system = separated(self._system) if apart else self._system
        q, t, b = self._at.q[row], float(self._at.t[row]), self._b
        q = supports(self._system).copies(q) if apart else q
        by_q = getattr(system, f"{name}_q")(q, operand, t, b=b)
        by_b = getattr(system, f"{name}_b")(q, operand, t, b=b)
        operands, curves = {OPERATORS[name].operands[0]: operand}, CurveDerivatives(system)
        by_curves = curves.matrix(name, b, t, q=q, **operands) if curves else None
        return Partials(by_q, by_b, by_curves, self._by_time(system, name, q, t, operand))

    def _by_time(self, system: System, name: str, q: Array, t: float, operand: Array) -> Array:
        """The same by the time alone (height,), which matters where events move the nodes."""
        if not self._moving:
            return np.zeros(system.m if name == "Phi_q_xi" else system.nq)
        if name == "Phi_q_xi":
            return np.asarray(system.Phi_q_xi_t(q, operand, t, b=self._b))
        return np.array([operand @ system.Phi_q_xi_t(q, xi, t, b=self._b) for xi in np.eye(system.nq)])
