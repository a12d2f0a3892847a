"""Accelerations and multipliers at a state, and their derivatives: functions that are compiled."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Any

import numpy as np

from ..._jit.kernels.pointer import call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ...model import SarrusError
from ...system import System
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work, shortest
from ..dynamics.dense_output.sampler import motion_arrays, motion_entries, motion_work
from ..equations.block_matrix import LESS, PRECISE, PlacedMatrix
from ..equations.minimum_norm import Omissions, left_out
from ..equilibria.balance import TRUSTED, independent_at, matrix_at, refuse_not_finite, unsolved
from ..equilibria.linear_loop import (
    CSR,
    Constraints,
    Forces,
    clear,
    evaluate,
    factor_regular,
    solve,
    solve_regular,
)
from ..equilibria.parameter_loop import ByParameters, add_motion_by_parameters
from ..equilibria.settled_derivatives import LastingFunction

ROUNDS = 2  # of the equations of motion: the first, and a refinement


@compiled
def forward(
    entries: Entries, work: Work, matrix: Matrix, others: Omissions, least: float, b: Array, t: float, q: Array,
    v: Array, a: Array, lam: Array,
) -> float:  # fmt: skip
    """Fill a and λ, the shortest where constraints are redundant.

    Returns
    -------
    how far the pivots can be trusted; at most `least`, nothing else is done; -1 if a or λ are not finite, or
    vectors have other sizes
    """
    nq = len(work.Q)
    if not (len(q) == len(v) == len(a) == nq and len(lam) == len(matrix.left_out)):
        return -1.0
    trust = factor_regular(entries, b, t, q, matrix)
    if trust > least:
        if not solve_regular(entries, b, t, q, v, a, lam, work, matrix, ROUNDS):
            return -1.0
        shortest(entries, b, t, q, lam, work, matrix, others)
    return trust


@compiled
def scatter(A: CSR, by: float, to: Array, row: int, column: int) -> None:
    """Add a multiple of a sparse matrix to a block of a dense one."""
    for k in range(len(A.first) - 1):
        for entry in range(A.first[k], A.first[k + 1]):
            to[row + k, column + A.columns[entry]] += by * A.numbers[entry]


@compiled
def derivatives(
    entries: Entries, work: Work, matrix: Matrix, others: Omissions, phi: Constraints, forces: Forces,
    combinations: ByParameters, a: Array, lam: Array, right: Array, columns: Array, least: float, b: Array, t: float,
    q: Array, v: Array, found: Array,
) -> float:  # fmt: skip
    """Fill `found` (nq + m, 1 + 2 nq + k): a and λ as `forward`, their derivatives by q, v, and k combinations of b.

    M δa + Φ_qᵀ δλ = (Q_q + S_q - (M a)_q - (Φ_qᵀλ)_q) δq + (Q_v + S_v) δv + (Q + S - M a - Φ_qᵀλ)_b δb,
    Φ_q δa = (γ_q - (Φ_q a)_q) δq + γ_v δv + (γ - Φ_q a)_b δb
    """
    if found.shape != right.shape:
        return -1.0
    trust = forward(entries, work, matrix, others, least, b, t, q, v, a, lam)
    if trust > least:
        nq, by_q, by_v = len(q), 1, 1 + len(q)
        for k in range(len(lam)):
            phi.lam[k] = lam[k]
        evaluate(phi, b, t, q, v, a)
        call_kernels(forces.force, b, t, q, v, forces.Q_q.numbers, forces.Q_v.numbers)
        call_kernels(forces.inertia, b, q, a, forces.M_a_q.numbers)
        call_kernels(forces.by_q, b, q, v, forces.S_q.numbers)
        call_kernels(forces.by_v, b, q, v, forces.S_v.numbers)
        clear(right)
        scatter(forces.Q_q, 1.0, right, 0, by_q)
        scatter(forces.S_q, 1.0, right, 0, by_q)
        scatter(forces.M_a_q, -1.0, right, 0, by_q)
        scatter(phi.Phi_qT_lam_q, -1.0, right, 0, by_q)
        scatter(phi.gamma_q, 1.0, right, nq, by_q)
        scatter(phi.along_a, -1.0, right, nq, by_q)
        scatter(forces.Q_v, 1.0, right, 0, by_v)
        scatter(forces.S_v, 1.0, right, 0, by_v)
        scatter(phi.gamma_v, 1.0, right, nq, by_v)
        add_motion_by_parameters(combinations, b, t, q, v, a, lam, right, by_v + nq)
        solve(matrix, right, columns, found)
        for k in range(nq):
            found[k, 0] = a[k]
        for k in range(len(lam)):
            found[nq + k, 0] = lam[k]
    return trust


class PivotOrder:
    """The matrix [M Φ_qᵀ; Φ_q 0] of a system, with an order of pivots and independent equations.

    Attributes
    ----------
    lock : held while compiled functions write to the arrays
    rows : of independent equations, found at the first state, and where these are dependent; None if all are
    least : how far pivots must be trusted
    matrix, arrays : the matrix, and as compiled code takes it; None before the first state
    """

    matrix: PlacedMatrix | None = None
    arrays: Matrix | None = None
    rows: Array | None = None
    least = PRECISE

    def __init__(self, system: System) -> None:
        self.system, self.lock = system, Lock()
        self.entries, self.work = motion_entries(system), motion_work(system)

    def choose(self, b: Array, t: float, q: Array, again: bool) -> bool:
        """Choose pivots, and with `again` independent equations; false if those of before are dependent.

        Raises
        ------
        SarrusError
            In a singular configuration.
        """
        rows = independent_at(self.system, q, t) if again else self.rows
        try:
            self.matrix = matrix_at(self.system, q, t, b, rows)
        except SarrusError:
            if again:
                raise
            return False
        self.rows, self.arrays = rows, motion_arrays(self.matrix)
        return True


class PivotedFunction:
    """A compiled function ``f(entries, work, matrix, left out, *fixed, least, b, t, q, v, ...) -> trust``.

    Parameters
    ----------
    order : of pivots, which other functions may share
    function : marked with `compiled`
    fixed : arguments behind the four of the equations of motion
    """

    def __init__(self, order: PivotOrder, function: Callable[..., float], *fixed: Any) -> None:
        self._order, self._marked, self._fixed = order, function, fixed
        self._arrays: Matrix | None = None
        self._bound: LastingFunction | None = None
        self._function: Any = None
        self._data = np.zeros(0, np.int64)

    @property
    def bound(self) -> LastingFunction:
        """The function with its fixed arguments.

        Raises
        ------
        SarrusError
            Before the first state.
        """
        if self._bound is None:
            raise SarrusError(f"{self._order.system.name}: call the function with a state first.")
        return self._bound

    def __call__(self, b: Array, t: float, q: Array, v: Array, *others: Any) -> None:
        """Call it, the lock being held; with other pivots if those of before are poor.

        Raises
        ------
        SarrusError
            In a singular configuration.
        """
        order = self._order
        if self._arrays is not order.arrays:
            self._bind()  # another function has chosen pivots
        least = order.least
        if self._bound and self._function(self._data, least, b, t, q, v, *others) > least:
            return
        refuse_not_finite(q=q, v=v, t=t)
        trust = 0.0
        for again in (False, True) if order.matrix else (True,):
            if order.choose(b, t, q, again):
                self._bind()
                trust = self._function(self._data, TRUSTED, b, t, q, v, *others)
                if trust > TRUSTED:
                    order.least = min(PRECISE, LESS * trust)
                    return
        raise unsolved(order.system, t, trust)

    def _bind(self) -> None:
        """Pass the present order of pivots to compiled code."""
        order = self._order
        equations = order.entries, order.work, order.arrays, left_out(order.system, order.rows)
        self._bound = LastingFunction(self._marked, *equations, *self._fixed)
        self._function, self._data, self._arrays = self._bound.function, self._bound.fast, order.arrays
