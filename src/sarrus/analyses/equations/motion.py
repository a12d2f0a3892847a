"""The equations of motion solved for acceleration and multipliers: M a + Φ_qᵀ lam = Q + S, Φ_q a = γ."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csc_array

from ...algebra import Array
from ...linalg.factors import DENSE_BELOW, LUFactors, SingularSystem
from ...linalg.sparse_solver import SingularMatrix, SparseLU
from ...system import System
from ...system.cached import once_alike


class Saddle:
    """The matrix [W Φ_qᵀ; Φ_q 0] for W = M ("M") or the identity ("I"), its pattern made once.

    Pivots would be chosen by the units of masses and lengths: with M, masses are divided by a power of two near the
    largest, Euler parameters are multiplied by one near the largest radius of gyration, rows of Φ_q are divided by one
    near their largest number. "I" is the identity for coordinates in such a unit, by a lever of Φ_q.

    Where constraints are redundant, `rows` are the places in Φ of independent ones; the multipliers of the others are
    0.
    """

    def __init__(self, system: System, weight: str, rows: Array | None = None) -> None:
        self._independent = np.arange(system.m) if rows is None else rows
        self.nq, self.m, self._all = system.nq, len(self._independent), system.m
        found = _all_independent(system, weight) if rows is None else _places_in(system, weight, rows)
        self._rows, self._columns, self._used = found
        size = self.nq + self.m
        if size < DENSE_BELOW:
            self._dense: Array | None = np.zeros((size, size))
        else:
            self._dense = None
            numbered = csc_array(
                (np.arange(len(self._rows)) + 1.0, (self._rows, self._columns)), shape=(size, size)
            )
            self._order = numbered.data.astype(np.int64) - 1
            self._indptr, self._indices = (x.astype(np.int64) for x in (numbered.indptr, numbered.indices))
        self._factors: LUFactors | SparseLU | None = None
        self._unit, self._row_scale, self._column_scale = 1.0, np.ones(self.m), np.ones(self.nq)
        self._weighted, self._is_length = weight == "M", system.layout.is_length

    def factor(self, W: Array, Phi_q: Array) -> None:
        """Factor the matrix of the numbers of W and Φ_q.

        Raises
        ------
        SingularSystem
            If it cannot be factored.
        """
        Phi_q = Phi_q[self._used]
        self._scale(W, Phi_q)
        places = self._rows[: len(W)], self._columns[: len(W)]
        by = self._column_scale[places[0]] * self._column_scale[places[1]] if self._weighted else 1.0
        self._unit = _power_of_two(W * by)
        scale, entries = np.concatenate([self._column_scale, self._row_scale]), len(W)
        numbers = np.concatenate([W / self._unit, Phi_q, Phi_q])
        scaled = slice(0 if self._weighted else entries, None)  # the identity stays one
        numbers[scaled] *= scale[self._rows[scaled]] * scale[self._columns[scaled]]
        if self._dense is not None:
            self._dense[self._rows, self._columns] = numbers
            self._factors = LUFactors(self._dense)
            return
        self._factor_sparse(numbers[self._order])

    def _scale(self, W: Array, Phi_q: Array) -> None:
        """Scales of Euler parameters, by a radius of gyration or else a lever of Φ_q, and of rows of Φ_q."""
        entries, count = len(W), len(Phi_q)
        transposed = slice(entries, entries + count)
        columns, rows = self._rows[transposed], self._columns[transposed] - self.nq
        turning = ~self._is_length[columns]
        if self._weighted:
            at = ~self._is_length[self._rows[:entries]]
            parts = abs(W[at]).max(initial=0.0), abs(W[~at]).max(initial=0.0)
            length = np.sqrt(parts[0] / parts[1]) if min(parts) > 0 else 1.0
        else:
            by_p, by_r = (_largest(rows[part], Phi_q[part], self.m) for part in (turning, ~turning))
            both = (by_p > 0) & (by_r > 0)
            length = float(np.max(by_p[both] / by_r[both], initial=0.0)) or 1.0
        inverse = 1.0 / _power_of_two(np.array([length]))
        self._column_scale = np.where(self._is_length, 1.0, inverse)
        largest = _largest(rows, Phi_q * self._column_scale[columns], self.m)
        self._row_scale = np.where(largest > 0, 2.0 ** -np.frexp(largest)[1], 1.0)

    def _factor_sparse(self, data: Array) -> None:
        try:
            if isinstance(self._factors, SparseLU):
                self._factors.factor(data)
            else:
                self._factors = SparseLU(self._indptr, self._indices, data)
        except SingularMatrix as error:
            self._factors = None
            raise SingularSystem(str(error)) from None

    def solve(self, f: Array, g: Array) -> tuple[Array, Array]:
        """x (nq,) and y (m,) for the right side f, g, or a column of both for each of theirs."""
        scale = np.concatenate([self._column_scale, self._row_scale]).reshape(-1, *(1,) * (f.ndim - 1))
        solution = scale * self._solved(scale * np.concatenate([f / self._unit, g[self._independent]]))
        if not np.all(np.isfinite(solution)):
            raise SingularSystem("the matrix is singular to working precision")
        y = np.zeros((self._all, *f.shape[1:]))
        y[self._independent] = self._unit * solution[self.nq :]
        return solution[: self.nq], y

    def _solved(self, right: Array) -> Array:
        assert self._factors is not None
        if self._dense is not None or right.ndim == 1:
            return np.asarray(self._factors.solve(right))
        return np.array([self._factors.solve(column) for column in right.T]).reshape(right.T.shape).T


def _largest(rows: Array, values: Array, count: int) -> Array:
    """The largest absolute value of each row; 0 for empty ones."""
    found = np.zeros(count)
    np.maximum.at(found, rows, abs(values))
    return found


def _power_of_two(W: Array) -> float:
    """The largest one that is not above |W|; 1 for zeros."""
    return float(2.0 ** (np.frexp(abs(W).max(initial=0.0))[1] - 1)) if np.any(W) else 1.0


def _places_in(system: System, weight: str, independent: Array) -> tuple[Array, Array, Array]:
    """Row and column of each number in the matrix, and which numbers of Φ_q there are."""
    rows, columns = _places(system.pattern("Phi_q"))
    used = np.isin(rows, independent)
    rows, columns = np.searchsorted(independent, rows[used]) + system.nq, columns[used]
    both = _places(system.pattern("M")) if weight == "M" else (np.arange(system.nq),) * 2
    return np.concatenate([both[0], columns, rows]), np.concatenate([both[1], rows, columns]), used


@once_alike
def _all_independent(system: System, weight: str) -> tuple[Array, Array, Array]:
    return _places_in(system, weight, np.arange(system.m))


def _places(pattern: Any) -> tuple[Array, Array]:
    rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr))
    return rows, pattern.indices.astype(np.int64)


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
        self._Phi_q, self._gamma = self._constraints.allocate()
        self._M, self._S = self._inertia.allocate()
        (self._Q,) = self._forces.allocate()
        self.keep(rows)

    def keep(self, rows: Array | None) -> None:
        """Go on with another choice of independent equations."""
        self._saddle = Saddle(self.system, "M", rows)

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
        self._saddle.factor(self._M, self._Phi_q)
        return self._saddle.solve(self._Q + self._S, self._gamma)

    def rate(self, t: float, y: Array) -> Array:
        """The first-order form: y = [q; v], its rate [v; a]."""
        q, v = np.split(y, 2)
        return np.concatenate([v, self.acceleration(t, q, v)[0]])
