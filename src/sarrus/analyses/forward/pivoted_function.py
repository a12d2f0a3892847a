"""Compiled functions that factorize the equations of motion, with pivots that are chosen anew where they are poor."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...system import System
from ..dynamics.dense_output.sample_loop import Matrix
from ..dynamics.dense_output.sampler import motion_arrays, motion_entries, motion_work
from ..equations.block_matrix import PRECISE, PlacedMatrix
from ..equations.minimum_norm import left_out
from ..equilibria.lasting_function import LastingFunction
from ..equilibria.motion_at import TRUSTED, independent_at, matrix_at, refuse_not_finite, unsolved

LESS = 0.1  # of the trust in pivots just chosen: below it they are chosen again


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
        self._bound = LastingFunction(order.system, self._marked, *equations, *self._fixed)
        self._function, self._data, self._arrays = self._bound.function, self._bound.fast, order.arrays
