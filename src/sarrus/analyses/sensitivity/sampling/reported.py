"""Multipliers as runs report them, with their derivatives: of minimum norm where constraints are redundant.

Steps solve a choice of independent equations and leave the multipliers of the others zero. Reported is λ̂ = P λ with
the projector P along the left null space of J = Φ_q. With μ = λ - λ̂, for which Jᵀμ = 0, and the least ξ with J ξ = λ̂,

    λ̂' = P (λ' + J⁺ᵀ (J')ᵀμ) + (1 - P) J' ξ

for changes of the state on the constraints and of the parameters that keep the equations redundant.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ....elements.operators import OPERATORS
from ....linalg.factors import SingularSystem
from ....results import Pieces, StepsTaken
from ....results.motion.steps import stretches
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ...equations.minimum_norm import MinimumNorm, shortest
from ..chain.chain import Nodes
from ..lagrangians.changes import change_at
from ..lagrangians.curves import CurveLagrangian


class Place(NamedTuple):
    """A node among the steps: the stretch between events in which it is, and its place there."""

    piece: int
    node: int


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
    null : (m, k) orthonormal basis of the left null space
    mu, xi : λ - λ̂ (m,) and ξ (nq,)
    pull : those of Jᵀμ
    push : those of J ξ
    """

    minimum: MinimumNorm
    null: Array
    mu: Array
    xi: Array
    pull: Partials
    push: Partials

    def along(self, change: Changes, lam: Array) -> Array:
        """λ̂' (m, k) for changes of the state and of λ."""
        moved = shortest(lam + self.minimum.forces(self.pull.along(change)), self.null)
        return np.asarray(moved + self.null @ (self.null.T @ self.push.along(change)))

    def transposed(self, bar: Array, to: Changes) -> Array:
        """Gradients by λ of those by λ̂ (m, k); those by the state are added."""
        across = shortest(bar, self.null)
        self.pull.add_gradients(self.minimum.motions(across), to)
        self.push.add_gradients(bar - across, to)
        return across


class Reported:
    """The reported multipliers at the nodes of a run.

    Parameters
    ----------
    system, steps : the run
    moving : whether events move its nodes in time; by default, whether it has any
    """

    def __init__(self, system: System, steps: StepsTaken | Pieces, moving: bool | None = None) -> None:
        self._system, self._b = system, steps.b.copy()
        self._pieces = stretches(steps)
        timed = any(p.kind.rows and p.kind.timed for p in system.populations)
        self._moving = timed and (isinstance(steps, Pieces) if moving is None else moving)
        self._known: dict[int, Array] = {}
        self._choices: dict[bytes, MinimumNorm] = {}

    @cached_property
    def _curves(self) -> CurveDerivatives:
        return CurveDerivatives(self._system)

    @cached_property
    def redundant(self) -> bool:
        """Whether any equations are left out at any time."""
        return any(bool(piece.left_out.any()) for piece in self._pieces)

    def lam(self, rows: Array) -> Array:
        """All multipliers (nodes, m), those at some nodes as they are reported."""
        found = np.concatenate([piece.lam for piece in self._pieces])
        for row in rows.tolist():
            if row not in self._known:
                self._known[row] = self._reported(self._place(row))
            found[row] = self._known[row]
        return found

    def pulled_back(self, nodes: Nodes) -> Array:
        """Turn gradients by reported multipliers into those by the states; those by the parameters (len(b), k)."""
        by_b = np.zeros((len(self._b), nodes.lam.shape[2]))
        if not self.redundant:
            return by_b
        for row in np.flatnonzero(nodes.lam.any(axis=(1, 2))).tolist():
            place = self._place(row)
            slopes = self.slopes(place)
            if slopes is not None:
                to = Changes(nodes.q[row], by_b, nodes.shift[place.piece])
                nodes.lam[row] = slopes.transposed(nodes.lam[row], to)
        return by_b

    def pulled_back_along(self, bars: Nodes, change: Nodes, dots: Nodes, b: Array) -> Array:
        """Turn changes of gradients, see `pulled_back`, with those of the states and parameters.

        Parameters
        ----------
        bars : gradients by reported multipliers
        change : their change, which is replaced
        dots, b : changes of the states, with the multipliers of the steps, and of the parameters (len(b), 1)
        """
        by_b = np.zeros((len(self._b), 1))
        for row in np.flatnonzero(
            (bars.lam != 0).any(axis=(1, 2)) | (change.lam != 0).any(axis=(1, 2))
        ).tolist():
            place = self._place(row)
            moved = Changes(dots.q[row], b, dots.shift[place.piece])
            to = Changes(change.q[row], by_b, change.shift[place.piece])
            change.lam[row] = self.turned(place, (bars.lam[row], change.lam[row]), moved, dots.lam[row], to)
        return by_b

    def turned(
        self, place: Place, bars: tuple[Array, Array], moved: Changes, lam_dot: Array, to: Changes
    ) -> Array:
        """The change of the gradient by λ (m, 1), of that by λ̂ and its change; those by the state are added.

        With λ̄ = P λ̂̄, ν = λ̂̄ - λ̄ and the least β with J β = λ̄ the gradient by the state is that of μᵀJ β + νᵀJ ξ;
        λ̄ changes as λ̂ does, and β and ξ with the right sides of their equations.
        """
        slopes, (bar, bar_dot) = self.slopes(place), bars
        if slopes is None:
            return bar_dot
        minimum, null = slopes.minimum, slopes.null
        hat_dot = slopes.along(moved, lam_dot)
        xi_dot = minimum.motions(hat_dot - slopes.push.along(moved))
        across = shortest(bar, null)
        beta, nu = minimum.motions(across), bar - across
        pull, push = self._by("Phi_qT_lam", place, nu[:, 0]), self._by("Phi_q_xi", place, beta[:, 0])
        across_dot = Slopes(minimum, null, nu[:, 0], beta[:, 0], pull, push).along(moved, bar_dot)
        slopes.pull.add_gradients(minimum.motions(across_dot - push.along(moved)), to)
        pull.add_gradients(xi_dot, to)
        terms = (
            (slopes.mu, (lam_dot - hat_dot)[:, 0], beta[:, 0]),
            (nu[:, 0], (bar_dot - across_dot)[:, 0], slopes.xi),
        )
        for lam, lam_change, xi in terms:
            self._add_bends(place, lam, lam_change, xi, moved, to)
        return across_dot

    def _add_bends(
        self, place: Place, lam: Array, lam_dot: Array, xi: Array, moved: Changes, to: Changes
    ) -> None:
        """Add the change of the gradient of λᵀJ ξ with all but ξ."""
        steps, curves = self._pieces[place.piece], CurveLagrangian(self._system, True, self._moving)
        found = change_at(
            self._system, "place", float(steps.t[place.node]), self._b, moved.b[:, 0], lam, np.zeros(len(lam)), lam_dot,
            curves, float(moved.t[0]) if self._moving else 0.0, q=steps.q[place.node], q_dot=moved.q[:, 0], xi=xi,
        )  # fmt: skip
        to.q[:, 0] += found.q
        to.b[:, 0] += found.b
        to.t[:] += found.t

    def along(self, nodes: Nodes, b: Array, rows: Array | None = None) -> Nodes:
        """The changes of the states and parameters, those of multipliers at some or all nodes as they are reported."""
        lam = nodes.lam.copy()
        for row in (np.arange(len(lam)) if rows is None else rows).tolist():
            place = self._place(row)
            slopes = self.slopes(place)
            if slopes is not None:
                change = Changes(nodes.q[row], b, nodes.shift[place.piece])
                lam[row] = slopes.along(change, lam[row])
        return Nodes(nodes.q, nodes.v, nodes.a, lam, nodes.shift)

    def _place(self, row: int) -> Place:
        piece = 0
        while row >= len(self._pieces[piece].t):
            row, piece = row - len(self._pieces[piece].t), piece + 1
        return Place(piece, row)

    def _minimum(self, place: Place) -> MinimumNorm | None:
        """Return the solver of minimum norm; None if all equations are independent."""
        steps = self._pieces[place.piece]
        if not len(steps.left_out) or not steps.left_out[place.node].any():
            return None
        choice = steps.left_out[place.node]
        key = choice.tobytes()
        if key not in self._choices:
            self._choices[key] = MinimumNorm(self._system, np.flatnonzero(~choice))
        return self._choices[key]

    def _jacobian(self, place: Place) -> csr_array:
        steps = self._pieces[place.piece]
        self._b[steps.places] = steps.memory[min(place.node, len(steps) - 1)]
        return self._system.Phi_q(steps.q[place.node], float(steps.t[place.node]), b=self._b)

    def _reported(self, place: Place) -> Array:
        lam: Array = self._pieces[place.piece].lam[place.node]
        minimum = self._minimum(place)
        if minimum is None:
            return lam
        try:
            return shortest(lam, minimum.null(self._jacobian(place)))
        except SingularSystem:  # where all choices are dependent runs leave them as they are, too
            return lam

    def slopes(self, place: Place) -> Slopes | None:
        """The derivatives at a node; none where all equations are independent, or all choices of them dependent."""
        minimum = self._minimum(place)
        if minimum is None:
            return None
        try:
            null = minimum.null(self._jacobian(place))
        except SingularSystem:
            return None
        steps = self._pieces[place.piece]
        lam = shortest(steps.lam[place.node], null)
        xi = minimum.motions(lam[:, None])[:, 0]
        mu = steps.lam[place.node] - lam
        pull, push = self._by("Phi_qT_lam", place, mu), self._by("Phi_q_xi", place, xi)
        return Slopes(minimum, null, mu, xi, pull, push)

    def _by(self, name: str, place: Place, operand: Array) -> Partials:
        """The derivatives of an operator."""
        system, steps = self._system, self._pieces[place.piece]
        q, t, b = steps.q[place.node], float(steps.t[place.node]), self._b
        by_q = getattr(system, f"{name}_q")(q, operand, t, b=b)
        by_b = getattr(system, f"{name}_b")(q, operand, t, b=b)
        operands = {OPERATORS[name].operands[0]: operand}
        curves = self._curves.matrix(name, b, t, q=q, **operands) if self._curves else None
        return Partials(by_q, by_b, curves, self._by_time(name, q, t, operand))

    def _by_time(self, name: str, q: Array, t: float, operand: Array) -> Array:
        """The same by the time alone (height,), which matters where events move the nodes."""
        system, b = self._system, self._b
        if not self._moving:
            return np.zeros(system.m if name == "Phi_q_xi" else system.nq)
        if name == "Phi_q_xi":
            return np.asarray(system.Phi_q_xi_t(q, operand, t, b=b))
        return np.array([operand @ system.Phi_q_xi_t(q, xi, t, b=b) for xi in np.eye(system.nq)])
