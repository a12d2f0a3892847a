"""The matrix [W Φ_qᵀ; Φ_q 0] of a system, and the equations of motion M a + Φ_qᵀ lam = Q + S, Φ_q a = γ."""

from __future__ import annotations

import numpy as np

from ..._jit.linking.link import link
from ...algebra import Array
from ...linalg.factors import SingularSystem
from ...system import System
from .block_matrix import (
    LEFT_OUT,
    PRECISE,
    UNIT,
    Numbers,
    Part,
    PlacedMatrix,
    backsolve_columns,
    leave_out,
)


class KKTMatrix(PlacedMatrix):
    """[W, Φ_qᵀ; Φ_q, 0] of one system, W = M or the metric `UNIT`, with a 1 for every equation left out.

    It maps x and y to W x + Φ_qᵀy = f and Φ_q x = g. Where constraints are redundant, `rows` are the places in Φ of
    independent ones; the multipliers of the others are 0. A matrix whose pattern contains it may be its `host`.
    """

    def __init__(
        self, system: System, weight: str = "M", rows: Array | None = None, host: PlacedMatrix | None = None
    ) -> None:
        self.nq = system.nq
        parts = motion_parts(system.nq, weight)
        numbers = Numbers(system, (weight, LEFT_OUT, "Phi_q"))
        super().__init__(numbers, system.nq + system.m, parts, host=host)
        numbers.keep(rows)

    def factor_at(self, b: Array, t: float, q: Array) -> None:
        """Evaluate and factor it at a position.

        Raises
        ------
        SingularSystem
            If it cannot be factored.
        """
        for name in self.numbers.names:
            if name not in (UNIT, LEFT_OUT):
                self.numbers.evaluate((name,), b, {"t": t, "q": q})
        self.factor(PRECISE)

    def factor_with(self, Phi_q: Array) -> None:
        """Factor it for other numbers of Φ_q, and those of W that are there.

        Raises
        ------
        SingularSystem
            If it cannot be factored.
        """
        self.numbers.views["Phi_q"][:] = Phi_q
        link(leave_out)(self.numbers.views["Phi_q"], self.numbers.row_of, self.numbers.left_out)
        self.factor(PRECISE)

    def solve_pair(self, f: Array, g: Array) -> tuple[Array, Array]:
        """x (nq,) and y (m,) for the right sides f and g, or a column of both for each of theirs.

        Raises
        ------
        SingularSystem
            If they are not finite.
        """
        assert self.placed is not None
        right = np.concatenate([f, ((1.0 - self.numbers.left_out) * g.T).T])
        columns = right.reshape(self.n, -1)
        found, work = np.zeros(columns.shape), np.zeros(columns.shape)
        link(backsolve_columns)(self.placed, columns, work, found)
        if not np.all(np.isfinite(found)):
            raise SingularSystem("the matrix is singular to working precision")
        x, y = np.split(found.reshape(right.shape), [self.nq])
        return x, y


def motion_parts(nq: int, weight: str = "M") -> list[Part]:
    """Where operators stand in it."""
    return [
        Part(weight, 0, 0),
        Part(LEFT_OUT, nq, nq),
        Part("Phi_q", nq, 0),
        Part("Phi_q", 0, nq, transposed=True),
    ]


class EquationsOfMotion:
    """Accelerations of one system; all memory is reused between calls.

    Where constraints are redundant, `rows` are the places in Φ of independent ones (see `Independence`): the
    accelerations are the same for any such choice, the multipliers of the other equations are 0.
    """

    def __init__(self, system: System, rows: Array | None = None) -> None:
        self.system = system
        self.b = system.b.copy()
        self.evaluations = 0
        self._constraints = system.group("Phi_q", "gamma")
        self._inertia = system.group("M", "S")
        self._forces = system.group("Q")
        self._gamma, self._S, self._Q = np.zeros(system.m), np.zeros(system.nq), np.zeros(system.nq)
        self.keep(rows)

    def keep(self, rows: Array | None) -> None:
        """Go on with another choice of independent equations."""
        self._kkt = KKTMatrix(self.system, rows=rows)
        self._M, self._Phi_q = self._kkt.numbers.of(("M", "Phi_q"))

    def acceleration(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """a (nq,) and lam (m,) at a state.

        Raises
        ------
        SingularSystem
            If the constraints are dependent there.
        """
        self.evaluations += 1
        self._constraints.run(self.b, t, q, v, self._Phi_q, self._gamma)
        self._inertia.run(self.b, q, v, self._M, self._S)
        self._forces.run(self.b, t, q, v, self._Q)
        self._kkt.factor_with(self._Phi_q)
        return self._kkt.solve_pair(self._Q + self._S, self._gamma)

    def rate(self, t: float, y: Array) -> Array:
        """The first-order form: y = [q; v], its rate [v; a]."""
        q, v = np.split(y, 2)
        return np.concatenate([v, self.acceleration(t, q, v)[0]])
