"""Steps along the motion of a fully driven system: position, velocity, acceleration, each with the exact Jacobian."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..._jit.linking.link import link
from ...algebra import Array
from ...linalg.factors import SingularSystem
from ...linalg.rank import unit_rows
from ...linalg.sparse_solver import SingularMatrix
from ...system import System
from ..dynamics.dense_output.sample_loop import Samples
from ..dynamics.dense_output.sampler import motion_entries, motion_work
from ..dynamics.dense_output.winding import Winding
from ..equations.block_matrix import LEFT_OUT, LESS, PRECISE, Numbers, Part, PlacedMatrix, refactor
from ..equations.length import extent, scaled
from ..equations.minimum_norm import left_out
from ..equations.nullspace import NullSpace, pivoted_rows
from ..equations.projection import ACCEPTED, allowed, largest
from . import motion_loop as loop

BRIDGED = 1e-4  # singular values up to this are left to the predictor, on a singular configuration


class Instant(NamedTuple):
    """The state at one time.

    Attributes
    ----------
    sign : of the Jacobian's determinant, 0 on a singular configuration
    """

    t: float
    q: Array
    v: Array
    a: Array
    sign: float

    def predicted(self, t: float) -> Array:
        """q + h v + ½ h² a."""
        h = t - self.t
        return self.q + h * (self.v + 0.5 * h * self.a)


class Path:
    """Finds the next state of one system from the last.

    Attributes
    ----------
    rows : the equations that are solved, as many as coordinates; the others are redundant and only looked at
    b : the numbers of the elements, with what they remember
    winding : coordinates of the joints, with their revolutions
    control : scalars of the compiled loop, with the Newton steps taken so far
    """

    def __init__(self, system: System, q: Array) -> None:
        self.system, self.b = system, system.b.copy()
        self.control = loop.Control.zeros()
        self._length = extent(system, q)
        self.rows, self.winding = np.arange(0), Winding(system)
        self._revolutions = np.zeros((2, system.counted_coordinates.m))

    def choose_rows(self, t: float, q: Array) -> bool:
        """Take the equations that are independent at a place; whether they are others, as many as coordinates."""
        rows = pivoted_rows(unit_rows(scaled(self.system.Phi_q(q, t, b=self.b), self.unit)).toarray())
        if len(rows) < self.system.nq or np.array_equal(rows, self.rows):
            return False
        self.rows, self._matrix = rows, square_matrix(self.system, rows)
        self._solver = self._arrays()
        self._factor(t, q)
        return True

    def renew_rows(self) -> bool:
        """Choose the equations anew at the state reached; whether they are others, which became dependent later."""
        now = self.now
        if not self.choose_rows(now.t, now.q):
            return False
        self.begin(self.instant(now.t, now.q) or now, self._revolutions[1])
        self.control.h = self.control.interval
        return True

    def _arrays(self) -> loop.Solver:
        """The arrays of the compiled loop, without pivots."""
        system, numbers, winding, nq = self.system, self._matrix.numbers, self.winding, self.system.nq
        rows, columns, pair = np.zeros((4, system.m)), np.zeros((4, nq)), np.zeros((2, 2, nq))
        matrix = (numbers.values, numbers.views["Phi_q"], self._matrix.placed, self.rows)
        others = left_out(system, self.rows)._replace(Phi_q=numbers.views["Phi_q"])  # at the same state
        jacobian: Any = (*matrix, others, *rows, *columns, system.layout.is_length, self._length)
        of = system.counted_coordinates
        coordinates = winding.residual, winding.velocity, of.b, of.angles, winding.values, winding.work
        joints: Any = (*coordinates, np.zeros(2), *pair, self._revolutions)
        states = (loop.State(*np.zeros((3, nq))) for _ in range(2))
        return loop.Solver(
            motion_entries(system), self.b, system.memory_places, loop.Jacobian(*jacobian), loop.Joints(*joints),
            motion_work(system), *states,
        )  # fmt: skip

    @property
    def unit(self) -> Array:
        """Return the size of a unit change of each coordinate, see `sarrus.analyses.equations.length` (nq,)."""
        return self.system.layout.scales(self._length)

    def sign(self, t: float, q: Array) -> float:
        """Return the sign of the determinant of the chosen equations.

        Raises
        ------
        SingularSystem
            If it is zero.
        """
        self._factor(t, q)
        return float(link(loop.sign_of)(self._solver.jacobian, self.control.parity))

    def weakest(self, t: float, q: Array) -> tuple[float, Array, Array]:
        """The smallest singular value, multipliers (m,) for which Φ_qᵀ lam nearly vanishes, a direction (nq,).

        Raises
        ------
        SingularSystem
            If the determinant is zero.
        """
        self._factor(t, q)
        J, left = self._solver.jacobian, np.zeros(self.system.m)
        size = link(loop.weakest)(J, q)
        left[self.rows] = J.weak
        return size, left, self.unit**2 * J.direction

    def _factor(self, t: float, q: Array) -> None:
        numbers, self.control.least = self._matrix.numbers, PRECISE
        numbers.evaluate(("Phi_q",), self.b, {"t": t, "q": q})
        placed = self._matrix.placed
        if (placed and link(refactor)(numbers.values, placed) > PRECISE) or self._choose_pivots():
            return
        raise SingularSystem("the equations are dependent there")

    def _choose_pivots(self) -> bool:
        """Choose pivots for the numbers of the Jacobian that are there; false if they are those of a singular one."""
        try:
            placed = self._matrix.choose_pivots()
        except (SingularMatrix, ValueError):
            return False
        jacobian, control = self._solver.jacobian._replace(placed=placed), self.control
        control.parity = parity(placed.row_place) * parity(placed.column_order)
        control.least = LESS * min(control.least, link(refactor)(jacobian.values, placed))
        self._solver = self._solver._replace(jacobian=jacobian)
        return True

    def begin(self, first: Instant, revolutions: Array) -> None:
        """Go on from a state, with the joints' coordinates that `winding` has, and their revolutions."""
        self._put(first, self._solver.now)
        self.control.t, self.control.sign, self._revolutions[1] = first.t, first.sign, revolutions

    def advance(self, out: Samples) -> int:
        """Go on to the next times of `out`; returns why the compiled loop stops: PAUSED, CROSSED or STUCK."""
        outcome = loop.PIVOTS
        while outcome == loop.PIVOTS:
            outcome = link(loop.advance)(self._solver, out, self.control)
            if outcome == loop.PIVOTS and not self._choose_pivots():
                self.control.verdict = loop.MISSED
        return outcome

    @property
    def now(self) -> Instant:
        return self._instant(self.control.t, self._solver.now, self.control.sign)

    @property
    def found(self) -> Instant:
        """The state that the last step found."""
        return self._instant(self.control.t_found, self._solver.found, self.control.sign_found)

    def _instant(self, t: float, state: loop.State, sign: float) -> Instant:
        return Instant(float(t), state.q.copy(), state.v.copy(), state.a.copy(), float(sign))

    def _put(self, instant: Instant, state: loop.State) -> None:
        for array, values in zip(state, instant[1:4], strict=True):
            array[:] = values

    def decide(self, instant: Instant | None) -> None:
        """Let the loop go on from a state, or with a shorter step."""
        self.control.verdict = loop.MISSED if instant is None else loop.FOUND
        if instant is not None:
            self._put(instant, self._solver.found)
            self.control.t_found, self.control.sign_found = instant.t, instant.sign

    def instant(self, t: float, q: Array) -> Instant | None:
        """The state at a time, from coordinates nearby, or nothing if Newton's method does not get there."""
        self._solver.found.q[:] = q
        return self._reached(loop.instant, t, self._solver.found)

    def step(self, before: Instant, t: float) -> Instant | None:
        """The state at a later (or earlier) time, or nothing if the step is too long."""
        self._put(before, self._solver.now)
        self.control.t = before.t
        return self._reached(loop.step, t)

    def _reached(self, method: Any, *arguments: Any) -> Instant | None:
        self.control.least = PRECISE
        outcome = link(method)(self._solver, *arguments, self.control)
        while outcome == loop.PIVOTS and self._choose_pivots():
            outcome = link(method)(self._solver, *arguments, self.control)
        return self.found if outcome == loop.FOUND else None

    def bridge(self, before: Instant, t: float) -> Instant | None:
        """The state on a singular configuration that the motion passes: what is undetermined follows the predictor."""
        system, q, h = self.system, before.predicted(t), t - before.t
        for _ in range(loop.ITERATIONS):
            solver = NullSpace(system.Phi_q(q, t, b=self.b), self.unit, BRIDGED)
            q = q + solver.change(-system.Phi(q, t, b=self.b))
        missed = not self._accepted(t, q)
        if missed or solver.rank == system.nq or largest((q - before.q) / self.unit) > loop.JUMP:
            return None
        v = before.v + h * before.a
        v = v - solver.change(system.Phi_q_xi(q, v, t, b=self.b) + system.Phi_t(q, t, b=self.b))
        a = before.a
        a = a + solver.change(system.gamma(q, v, t, b=self.b) - system.Phi_q_xi(q, a, t, b=self.b))
        return Instant(t, q, v, a, 0.0)

    def _accepted(self, t: float, q: Array) -> bool:
        limits = allowed(self.system.layout, self.system.Phi_q(q, t, b=self.b), q, self._length, ACCEPTED)
        return bool(np.all(abs(self.system.Phi(q, t, b=self.b)) <= limits))


def coordinate_scale(system: System, q: Array) -> Array:
    """Return the scale of each coordinate: the model's size for r, 1 for p (nq,)."""
    return system.layout.scales(extent(system, q))


def square_matrix(system: System, rows: Array) -> PlacedMatrix:
    """The matrix (nq, nq) of the gradients of as many equations, in places of Φ that rise."""
    places = np.arange(len(rows))
    runs = np.split(places, np.flatnonzero(np.diff(rows) != 1) + 1)
    parts = [
        Part("Phi_q", int(run[0] - rows[run[0]]), 0, rows=(int(rows[run[0]]), int(rows[run[-1]]) + 1))
        for run in runs
        if len(run)
    ]
    return PlacedMatrix(Numbers(system, (LEFT_OUT, "Phi_q")), len(rows), parts)


def parity(order: Array) -> int:
    """+1 for an even permutation, -1 for an odd one."""
    seen, swaps = np.zeros(len(order), dtype=bool), 0
    for first in range(len(order)):
        at = first
        while not seen[at]:
            seen[at], at = True, int(order[at])
            swaps += at != first
    return -1 if swaps % 2 else 1
