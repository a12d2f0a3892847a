"""One sparse matrix in which the numbers of operators stand at several places, each with a weight: made on one pattern.

The numbers of all operators lie one after another in one array. A part is an operator at a place in the matrix; every
number of a part knows its place among the numbers of the matrix, so that assembling is one pass:
data[place] += weight of the part x number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_array

from ..._jit.linking.link import compiled, link
from ...algebra import Array
from ...linalg.sparse_lu import compressed
from ...linalg.sparse_lu import refactor as factor_in_place
from ...linalg.sparse_lu import solve as solve_in_place
from ...linalg.sparse_lu import solve_columns as solve_columns_in_place
from ...linalg.sparse_lu import solve_transposed as solve_transposed_in_place
from ...linalg.sparse_solver import SingularMatrix, SparseLU
from ...system import System
from ...system.cached import once, once_alike
from .equilibration import BETWEEN_COORDINATES, GRADIENT, TRANSPOSED, Blocks, Sizes, exponents
from .length import kinematic_weights

# diagonal blocks (nq, nq), see `kinematic_weights`, and (m, m) with 1 for equations left out
UNIT, LEFT_OUT = "unit", "left_out"
PRECISE = 1e-3  # pivot over column, above which an order of pivots chosen for other numbers is as good as new
LESS = 0.1  # of the trust in pivots just chosen: below it they are chosen again
DEFINITE = ("M", "Phi_q", UNIT)  # operators whose largest numbers give the scales of rows and columns
STRETCH = 5000  # numbers that are summed before the next part takes its turn
FACTORS = ("row_place", "column_order", "factors", "weights", "scale")


class Part(NamedTuple):
    """An operator whose first number is at a row and a column of the matrix, perhaps transposed; or only some rows."""

    name: str
    row: int
    column: int
    transposed: bool = False
    rows: tuple[int, int] | None = None


class Assembler(NamedTuple):
    """What compiled code needs to assemble and factor: see `assemble` and `linalg.sparse_solver.SparseLU`.

    `scale` are powers of two by which rows are multiplied where pivots are compared, in their order.
    """

    parts: Array
    places: Array
    weights: Array
    pointers: Array
    rows: Array
    diagonal: Array
    factors: Array
    work: Array
    row_place: Array
    column_order: Array
    scale: Array


class Numbers:
    """The numbers of operators, one array: `views[name]` is an operator's part of `values`.

    Φ_q is among them, and `LEFT_OUT`. `like` names, for numbers of an operator at another state, the operator.

    Attributes
    ----------
    values, views : the numbers, which others write
    row_of : the equation that each number of Φ_q belongs to
    left_out : (m,) 1 for equations that are left out because others imply them, else 0: their multipliers become 0
    """

    def __init__(self, system: System, names: Sequence[str], like: Mapping[str, str] | None = None) -> None:
        self.system, self.names, self.like = system, tuple(names), tuple((like or {}).items())
        starts, self.row_of = numbering(system, self.names, self.like)
        self.values = np.zeros(starts[-1])
        self.start = dict(zip(names, starts, strict=False))
        self.views = {n: self.values[starts[k] : starts[k + 1]] for k, n in enumerate(names)}
        self.left_out = self.views[LEFT_OUT]
        if UNIT in self.views:
            self.views[UNIT][:] = kinematic_weights(system)

    def keep(self, rows: Array | None) -> None:
        """Solve only the equations in these places of Φ (None: all)."""
        self.left_out[:] = 0.0 if rows is None else 1.0
        self.left_out[[] if rows is None else rows] = 0.0

    def of(self, names: Sequence[str]) -> list[Array]:
        """The parts of some operators."""
        return [self.views[name] for name in names]

    def evaluate(
        self, group: Sequence[str], b: Array, operands: Mapping[str, Any], to: Sequence[str] = ()
    ) -> None:
        """Write the numbers of operators that are computed together; equations left out have no gradient.

        `to` are the names under which they are stored, where they are those at another state.
        """
        found, to = self.system.group(*group), to or group
        found.run(b, *(operands[name] for name in found.operands), *self.of(to))
        if "Phi_q" in group:
            link(leave_out)(self.views[to[group.index("Phi_q")]], self.row_of, self.left_out)


class PlacedMatrix:
    """The pattern of a matrix (n, n), and its factors; `kind` is the type of its weights, real or complex.

    Parts that also stand in another matrix, a `host`, need neither a pattern nor an analysis of their own: they take
    the order of its pivots, if it fits them.

    Attributes
    ----------
    numbers, weights : what it is assembled of
    placed : the matrix as compiled code takes it, or None before pivots are chosen
    """

    def __init__(
        self,
        numbers: Numbers,
        n: int,
        parts: Sequence[Part],
        kind: type = float,
        host: PlacedMatrix | None = None,
    ) -> None:
        self.numbers, self.n, self._host, self._kinds = numbers, n, host, tuple(parts)
        self._layout: Layout
        if host is None:
            self._layout = layout_of(numbers.system, n, numbers.like, self._kinds)
            first = self._layout.first
        else:
            self._layout = host._layout
            first = tuple(self._layout.first[host._kinds.index(part)] for part in self._kinds)
        own = spans(numbers.system, numbers.names, numbers.like, self._kinds)
        self.parts = np.column_stack([own, first])
        self.weights: Array = np.ones(len(parts), dtype=kind)
        self.placed: Assembler | None = None
        self._order: Assembler | None = None

    def take_order(self) -> None:
        """Take the order of pivots that the host has now."""
        self._order = self._host.placed if self._host else None

    def assembled(self) -> Array:
        """The numbers of the matrix, by columns, for the numbers and weights that are there now."""
        data = np.zeros(len(self._layout.indices), dtype=self.weights.dtype)
        link(assemble)(self.parts, self._layout.place, self.weights, self.numbers.values, data)
        return data

    def matrix(self) -> csc_array:
        """The matrix of the numbers and weights that are there now (n, n)."""
        found = (self.assembled(), self._layout.indices, self._layout.indptr)
        return csc_array(found, shape=(self.n, self.n))

    def pattern(self) -> csc_array:
        """1 wherever a number may stand (n, n)."""
        places = self._layout.indices, self._layout.indptr
        return csc_array((np.ones(len(places[0])), *places), shape=(self.n, self.n))

    def factor(self, least: float) -> Assembler:
        """Factor the numbers and weights that are there now; with new pivots, if old ones can be trusted less.

        Raises
        ------
        SingularMatrix
            If the matrix is singular.
        """
        placed = self.placed or self._lodged()
        if placed and link(refactor)(self.numbers.values, placed) > least:
            self.placed = placed
            return placed
        return self.choose_pivots()

    def choose_pivots(self) -> Assembler:
        """Choose the pivot order for the numbers and weights that are there now, and factor.

        Raises
        ------
        SingularMatrix
            If the matrix is singular.
        """
        self.placed, (indptr, indices, _, _) = None, self._layout
        (rows, columns), data = self._exponents(), self.assembled()
        data *= np.exp2(rows[indices] + np.repeat(columns, np.diff(indptr)))
        placed = self._show(SparseLU(indptr, indices, data), rows)
        link(refactor)(self.numbers.values, placed)
        return placed

    def _exponents(self) -> tuple[Array, Array]:
        """Exponents of two by which rows and columns are multiplied where pivots are chosen, see `equilibration`."""
        numbers, system, used = self.numbers, self.numbers.system, tuple((self.weights != 0.0).tolist())
        blocks = blocks_of(system, numbers.like, self._kinds, used)
        sizes = Sizes(numbers.values, self.parts[:, 0].copy(), abs(self.weights))
        rows, columns = np.zeros((2, self.n), np.int64)
        link(exponents)(blocks, sizes, system.m, rows, columns)
        for part, weight in zip(self._kinds, self.weights, strict=True):
            if part.name == UNIT and part.rows is not None:  # in place of multipliers that there are not
                own = abs(weight) * numbers.views[UNIT][span(system, UNIT, part.rows)]
                at = part.row + np.arange(len(own))
                rows[at] = -columns[at] - np.frexp(np.asarray(own, dtype=float))[1]
        return rows, columns

    def solve(self, right: Array) -> Array:
        """x of A x = right, with the factors at hand."""
        solution = np.zeros(self.n)
        assert self.placed is not None
        link(backsolve)(self.placed, right, solution)
        return solution

    def state(self) -> dict[str, Array]:
        """Pivot order, factors and weights; nothing before pivots are chosen."""
        return {} if self.placed is None else {name: getattr(self.placed, name).copy() for name in FACTORS}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Take over such a state."""
        if not state:
            self.placed = None
            return
        row_place, column_order, factors, self.weights[:], scale = (state[name] for name in FACTORS)
        own = self.placed
        if (
            own
            and np.array_equal(own.row_place, row_place)
            and np.array_equal(own.column_order, column_order)
        ):
            own.factors[:], own.scale[:] = factors, scale
            return
        pattern = self._layout.indptr, self._layout.indices
        placed = self._show(SparseLU.ordered(*pattern, row_place, column_order, factors), np.zeros(self.n))
        self.placed = placed._replace(scale=scale)

    def _lodged(self) -> Assembler | None:
        """With the order of the host, or else that of the model's position, and memory for factors."""
        if self._host is not None:
            found = self._order or self._host.placed
        else:
            own, left_out = self.numbers, self.numbers.left_out.tobytes()
            (found,) = first_order(own.system, own.names, own.like, self.n, self._kinds, left_out)
            found = found and found._replace(scale=_scale(found, self._exponents()[0]))
        if found is None:
            return None
        factors, work = np.zeros(len(found.rows), self.weights.dtype), np.zeros(self.n, self.weights.dtype)
        return found._replace(parts=self.parts, weights=self.weights, factors=factors, work=work)

    def _show(self, lu: SparseLU, exponents: Array) -> Assembler:
        self.placed = Assembler(
            self.parts, lu.slots[self._layout.place], self.weights, lu.pointers, lu.rows, lu.diagonal, lu.factors,
            np.zeros_like(lu.factors, shape=self.n), lu.row_place, lu.column_order, _scale(lu, exponents),
        )  # fmt: skip
        return self.placed


def _scale(order: SparseLU | Assembler, exponents: Array) -> Array:
    """The powers of two by which rows are multiplied, in the order of the pivots."""
    scale = np.zeros(len(exponents))
    scale[order.row_place] = np.exp2(exponents)
    return scale


@once
def first_order(
    system: System, names: tuple[str, ...], like: tuple[tuple[str, str], ...], n: int, parts: tuple[Part, ...],
    left_out: bytes,
) -> tuple[Assembler | None]:  # fmt: skip
    """The order of pivots for M and Φ_q at the model's position, which fits most other states; none if it is singular.

    It is kept with the system, and depends on nothing else: runs do not depend on those before them.
    """
    numbers = Numbers(system, names, dict(like))
    numbers.left_out[:] = np.frombuffer(left_out)
    for name in names:
        operator = dict(like).get(name, name)
        if operator in ("M", "Phi_q"):
            numbers.evaluate((operator,), system.b, {"t": 0.0, "q": system.q0}, (name,))
    matrix = PlacedMatrix(numbers, n, parts)
    try:
        return (matrix.choose_pivots()._replace(factors=np.zeros(0), work=np.zeros(0)),)
    except (SingularMatrix, ValueError):
        return (None,)


class Layout(NamedTuple):
    """The pattern by columns, the place of every number of all parts in it, and where those of each part begin."""

    indptr: Array
    indices: Array
    place: Array
    first: tuple[int, ...]


@once_alike
def layout_of(system: System, n: int, like: tuple[tuple[str, str], ...], parts: tuple[Part, ...]) -> Layout:
    """The pattern of all matrices (n, n) of a system with these parts."""
    found = [_entries(system, part, dict(like)) for part in parts]
    rows, columns = (np.concatenate(axis) for axis in zip(*found, strict=True))
    first = np.cumsum([0, *(len(own) for own, _ in found)])[:-1]
    indptr, indices, place = link(compressed)(n, rows, columns)
    return Layout(indptr, indices, place, tuple(first.tolist()))


@once_alike
def blocks_of(
    system: System, like: tuple[tuple[str, str], ...], parts: tuple[Part, ...], used: tuple[bool, ...]
) -> Blocks:
    """The blocks by which a matrix is equilibrated: those of `DEFINITE` operators among the parts that are used."""
    found, places = list[tuple[int, int, int, int]](), [(np.zeros(0, np.int32),) * 2]
    for n, part in enumerate(parts):
        operator = dict(like).get(part.name, part.name)
        if used[n] and operator in DEFINITE and (operator != UNIT or part.rows is None):
            gradient = TRANSPOSED if part.transposed else GRADIENT
            kind = gradient if operator == "Phi_q" else BETWEEN_COORDINATES
            found.append((n, kind, part.row, part.column))
            places.append(_entries(system, part._replace(row=0, column=0), dict(like)))
    rows, columns = (np.concatenate(axis) for axis in zip(*places, strict=True))
    bounds = np.cumsum([len(own) for own, _ in places])
    numbers, kinds, row, column = np.array(found, np.int64).reshape(-1, 4).T.copy()
    return Blocks(numbers, kinds, row, column, bounds, rows, columns, system.layout.is_length)


@once_alike
def numbering(
    system: System, names: tuple[str, ...], like: tuple[tuple[str, str], ...]
) -> tuple[list[int], Array]:
    """Where each operator's numbers begin, and the end of all; and the row of each number of Φ_q."""
    sizes = [len(entries_of(system, dict(like).get(name, name))[0]) for name in names]
    return [0, *np.cumsum(sizes).tolist()], entries_of(system, "Phi_q")[0]


def _entries(system: System, part: Part, like: dict[str, str]) -> tuple[Array, Array]:
    """Rows and columns of the numbers of a part."""
    operator = like.get(part.name, part.name)
    rows, columns = (x[span(system, operator, part.rows)] for x in entries_of(system, operator))
    if part.transposed:
        rows, columns = columns, rows
    return rows + np.int32(part.row), columns + np.int32(part.column)


@once_alike
def spans(
    system: System, names: tuple[str, ...], like: tuple[tuple[str, str], ...], parts: tuple[Part, ...]
) -> Array:
    """Where the numbers of each part begin among all, and how many they are (parts, 2)."""
    start = dict(zip(names, numbering(system, names, like)[0], strict=False))
    own = [span(system, dict(like).get(part.name, part.name), part.rows) for part in parts]
    found = [(start[part.name] + x.start, x.stop - x.start) for part, x in zip(parts, own, strict=True)]
    return np.array(found, np.int64).reshape(-1, 2)


@once_alike
def span(system: System, operator: str, rows: tuple[int, int] | None) -> slice:
    """The numbers of some rows of an operator, which lie one after another."""
    every = entries_of(system, operator)[0]
    return slice(0, len(every)) if rows is None else slice(*np.searchsorted(every, rows).tolist())


@once_alike
def entries_of(system: System, name: str) -> tuple[Array, Array]:
    """Rows and columns of an operator's numbers."""
    if name in (UNIT, LEFT_OUT):
        along = np.arange(system.nq if name == UNIT else system.m, dtype=np.int32)
        return along, along
    pattern = system.pattern(name)
    rows = np.repeat(np.arange(pattern.shape[0], dtype=np.int32), np.diff(pattern.indptr))
    return rows, pattern.indices.astype(np.int32)


@compiled(entry=True)
def assemble(parts: Array, places: Array, weights: Array, values: Array, data: Array) -> None:
    """Sum the weighted numbers of all parts into the numbers of the matrix.

    A stretch of each part in turn: bodies come in one order in all parts, so that large matrices are passed only once.
    """
    for k in range(len(data)):
        data[k] = 0.0
    stretches = 1 + len(places) // STRETCH
    for n in range(stretches):
        for s in range(len(parts)):
            first, count, at, weight = parts[s, 0], parts[s, 1], parts[s, 2], weights[s]
            begin, end = count * n // stretches, count * (n + 1) // stretches
            numbers, where = values[first + begin : first + end], places[at + begin : at + end]
            for k in range(len(numbers)):
                data[where[k]] += weight * numbers[k]


@compiled(entry=True)
def refactor(values: Array, placed: Assembler) -> float:
    """Assemble and factor a matrix; returns how far its pivots can be trusted."""
    assemble(placed.parts, placed.places, placed.weights, values, placed.factors)
    return factor_in_place(
        placed.pointers, placed.rows, placed.diagonal, placed.factors, placed.work, placed.scale
    )


@compiled(entry=True)
def backsolve(placed: Assembler, right: Array, solution: Array) -> None:
    """solution = matrix⁻¹ right."""
    work = placed.work
    for k in range(len(right)):
        work[placed.row_place[k]] = right[k]
    solve_in_place(placed.pointers, placed.rows, placed.diagonal, placed.factors, work)
    for k in range(len(right)):
        solution[placed.column_order[k]] = work[k]


@compiled(entry=True)
def backsolve_columns(placed: Assembler, right: Array, work: Array, solution: Array) -> None:
    """solution = matrix⁻¹ right, for all columns (n, k)."""
    for k in range(len(right)):
        for column in range(right.shape[1]):
            work[placed.row_place[k], column] = right[k, column]
    solve_columns_in_place(placed.pointers, placed.rows, placed.diagonal, placed.factors, work)
    for k in range(len(right)):
        for column in range(right.shape[1]):
            solution[placed.column_order[k], column] = work[k, column]


@compiled(entry=True)
def backsolve_transposed(placed: Assembler, right: Array, solution: Array) -> None:
    """solution = matrix⁻ᵀ right."""
    work = placed.work
    for k in range(len(placed.column_order)):
        work[k] = right[placed.column_order[k]]
    solve_transposed_in_place(placed.pointers, placed.rows, placed.diagonal, placed.factors, work)
    for k in range(len(placed.row_place)):
        solution[k] = work[placed.row_place[k]]


@compiled(entry=True)
def leave_out(Phi_q: Array, row_of: Array, left_out: Array) -> None:
    """Equations that are left out have no gradient."""
    for k in range(len(Phi_q)):
        Phi_q[k] *= 1.0 - left_out[row_of[k]]
