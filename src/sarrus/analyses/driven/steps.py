"""Steps along the motion of a fully driven system: position, velocity, acceleration, each with the exact Jacobian."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...linalg.factors import SingularSystem
from ...system import System
from ..equations.closure import allowed
from ..equations.constraint_projection import ACCEPTED, TOLERANCE, largest
from ..equations.length import extent, scaled, thousands, units
from ..equations.nullspace import NullSpace
from .jacobian import Driven, independent_rows

ITERATIONS = 12
CONTRACTION = 0.5  # each Newton step must be so much shorter than the one before
SETTLED = 1e-11  # a last Newton step, relative to the size of q, whose square is below round-off
JUMP = 0.1  # farthest that Newton may go from the predicted place: Euler parameters, and parts of the model's size
SINGULAR = 1e-5  # smallest singular value, below which Newton's method finds only half of the digits
BRIDGED = 1e-4  # singular values up to this are left to the predictor, on a singular configuration


class Instant(NamedTuple):
    """The state at one time.

    Attributes
    ----------
    sign : of the Jacobian's determinant, 0 on a singular configuration
    factors : of the Jacobian, but for a state that was bridged
    """

    t: float
    q: Array
    v: Array
    a: Array
    sign: float
    factors: Driven | None = None

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
    iterations : Newton steps taken so far
    """

    def __init__(self, system: System, q: Array) -> None:
        self.system, self.b, self.iterations = system, system.b.copy(), 0
        self._scale = coordinate_scale(system, q)
        self._length = float(thousands(extent(system, q)))
        self.rows = np.arange(system.m)

    def choose_rows(self, t: float, q: Array) -> int:
        """Take the equations that are independent at a place; give their number."""
        self.rows = independent_rows(scaled(self.system.Phi_q(q, t, b=self.b), self._length))
        return len(self.rows)

    @property
    def unit(self) -> Array:
        """Return the size of a unit change of each coordinate, see `sarrus.analyses.equations.length` (nq,)."""
        return units(self.system.nq, self._length)

    def driven(self, t: float, q: Array) -> Driven:
        """The factors of the Jacobian."""
        return Driven(self.system.Phi_q(q, t, b=self.b), self.rows, self._length)

    def instant(self, t: float, q: Array) -> Instant | None:
        """The state at a time, from coordinates nearby, or nothing if Newton's method does not get there."""
        try:
            there = self._position(t, q)
            return None if there is None else self._rates(t, there)
        except SingularSystem:
            return None

    def step(self, before: Instant, t: float) -> Instant | None:
        """The state at a later (or earlier) time, or nothing if the step is too long."""
        predicted = before.predicted(t)
        found = self.instant(t, predicted)
        if found is None or found.sign == 0 or largest((found.q - predicted) / self._scale) > JUMP:
            return None
        return found

    def bridge(self, before: Instant, t: float) -> Instant | None:
        """The state on a singular configuration that the motion passes: what is undetermined follows the predictor."""
        system, q, h = self.system, before.predicted(t), t - before.t
        for _ in range(ITERATIONS):
            solver = NullSpace(system.Phi_q(q, t, b=self.b), self._length, BRIDGED)
            q = q + solver.change(-system.Phi(q, t, b=self.b))
        missed = not self._accepted(t, q)
        if missed or solver.rank == system.nq or largest((q - before.q) / self._scale) > JUMP:
            return None
        v = before.v + h * before.a
        v = v - solver.change(system.Phi_q_xi(q, v, t, b=self.b) + system.Phi_t(q, t, b=self.b))
        a = before.a
        a = a + solver.change(system.gamma(q, v, t, b=self.b) - system.Phi_q_xi(q, a, t, b=self.b))
        return Instant(t, q, v, a, 0.0)

    def _position(self, t: float, q: Array) -> Array | None:
        before, limits = np.inf, self._limits(t, q, TOLERANCE)
        for _ in range(ITERATIONS):
            residual = self.system.Phi(q, t, b=self.b)
            if np.all(abs(residual) <= limits):
                return q
            step = self.driven(t, q).solve(-residual)
            self.iterations += 1
            q, size = q + step, largest(step / self._scale)
            if size <= SETTLED or size > CONTRACTION * before:
                break
            before = size
        return q if self._accepted(t, q) else None

    def _limits(self, t: float, q: Array, tolerance: float) -> Array:
        """Return the tolerances of |Φ|."""
        return allowed(self.system.Phi_q(q, t, b=self.b), q, self._length, tolerance)

    def _accepted(self, t: float, q: Array) -> bool:
        return bool(np.all(abs(self.system.Phi(q, t, b=self.b)) <= self._limits(t, q, ACCEPTED)))

    def _rates(self, t: float, q: Array) -> Instant:
        """Φ_q v = -Φ_t and Φ_q a = γ. Eqs. (3), (4)."""
        factors = self.driven(t, q)
        v = factors.solve(-self.system.Phi_t(q, t, b=self.b))
        a = factors.solve(self.system.gamma(q, v, t, b=self.b))
        return Instant(t, q, v, a, factors.sign if factors.weakest()[0] > SINGULAR else 0.0, factors)


def coordinate_scale(system: System, q: Array) -> Array:
    """Return the scale of each coordinate: the model's size for r, 1 for p (nq,)."""
    return units(system.nq, extent(system, q))
