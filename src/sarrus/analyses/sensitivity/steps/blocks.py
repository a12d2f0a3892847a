"""Buffers for blocks of operations that are linearized together, and the matrices of one run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...._jit.kernels import pointer
from ...._jit.kernels.vector import LANES
from ....algebra import Array
from ....linalg.columns_loop import COLUMNS, Rows
from ....linalg.panel_loop import Pattern
from ....linalg.row_order import by_rows, no_rows, rows_of, unsigned
from ....system import System
from ....system.cached import once_alike
from ....system.curves.lanes import aligned, buffer, used
from ...dynamics.methods.equations import GROUPS
from ...dynamics.methods.tables import DRIVERS, NOWHERE, Structure, Tables, tables_of
from ...dynamics.stepping.entries import joined
from ...equations.block_matrix import Numbers, spans
from ...equations.block_matrix import layout_of as pattern_of
from ...equations.length import kinematic_weights
from ..lagrangians.by_parameters import gradient_entry
from .block_loop import UNKNOWN, Block, Kernels, Matrices, RaggedPattern, RaggedRows
from .changes import UNCHANGED, changes
from .layout import drivers_of, kinds_of, layout_of
from .matrix import Placement
from .record import STEP, Operations
from .split_loop import SplitStages, Transformation
from .stacked import Ragged, ragged

OPERATIONS = 3  # see `record`
_PLACES, _NUMBERS = np.zeros(0, np.uint64), np.zeros((0, 0))
_BETWEEN = Transformation(_NUMBERS, _PLACES, _NUMBERS, _PLACES)
UNSPLIT = SplitStages(
    np.zeros((0, 3), np.int64), _PLACES, Pattern._make([_PLACES] * len(Pattern._fields)), _BETWEEN, _BETWEEN
)


class Product(NamedTuple):
    """The matrix by which changes of the stages enter the right sides: parts, places, pattern; and by rows."""

    parts: Array
    places: Array
    indptr: Array
    indices: Array
    rows: Rows


@once_alike
def product_of(system: System, structure: Structure) -> Product:
    """The product of an operation."""
    tables = tables_of(system, structure)
    numbers = Numbers(system, tables.names, tables.like)
    layout = pattern_of(system, max(tables.moved, tables.n), numbers.like, tables.product)
    parts = np.column_stack([spans(system, numbers.names, numbers.like, tables.product), layout.first])
    indptr = layout.indptr[: tables.moved + 1]
    rows = rows_of(indptr, layout.indices, np.arange(len(layout.indices)), tables.n)
    place, starts, indices = unsigned((layout.place, indptr, layout.indices))
    return Product(parts, place, starts, indices, rows)


def _whole(count: int) -> int:
    """The next multiple of the number of lanes."""
    return -(-count // LANES) * LANES


class Blocks:
    """Blocks of the operations of one run.

    Parameters
    ----------
    record : of the run
    columns : how many derivatives or responses are swept at once
    b_dot : (len(system.b), k) changes of the numbers, for a sweep forward
    by_parameters : whether a sweep backwards gives gradients by the numbers, or only adjoints

    Attributes
    ----------
    width : how many columns are handled side by side: forward those of a panel, or a single one; backward
        all, as many as fill whole vectors if they are several
    structures : of the operations, None where one does not occur
    panels : whether several columns are swept forward
    layout, kernels : see `layout` and `block_loop`
    block : see `block_loop`
    """

    def __init__(
        self, record: Operations, columns: int, b_dot: Array | None, by_parameters: bool = True
    ) -> None:
        system = record.system
        self._system, self._columns = system, columns
        tables = [one.tables if len(one) else None for one in record.operations]
        self.tables: list[Tables | None] = tables
        structures = tuple(one.structure if one else None for one in tables)
        self.structures = structures
        self.layout = layout_of(system, structures)
        self.panels = b_dot is not None and b_dot.shape[1] > 1
        self.width = COLUMNS if self.panels else columns if columns == 1 else _whole(columns)
        present = tuple(one for one in structures if one)
        self._products = [product_of(system, one) if one else None for one in structures]
        self.kernels = _kernels(system, present, b_dot is not None)
        self.block = self._block(record, b_dot, columns if by_parameters and b_dot is None else 0)

    def _block(self, record: Operations, b_dot: Array | None, columns: int) -> Block:
        layout, system = self.layout, self._system
        parts = [max(len(one.parts), len(one.product)) for one in self.tables if one]
        if record.split:
            parts.append(3 * len(record.operations[STEP].tables.parts))
        values, adjoint = buffer(layout.values_size), int(layout.adjoints[-1, 1])
        for tables, (_, redundant, _) in zip(self.tables, layout.values, strict=True):
            if tables:  # W of the kinematic equation, behind the numbers of redundant equations
                first = redundant + tables.m
                weights = np.repeat(kinematic_weights(system), LANES)
                values[first * LANES : (first + tables.nq) * LANES] = weights
        refined = np.ones((OPERATIONS, 3))
        refined[:, 2] = record.plain
        moved = UNCHANGED
        if b_dot is not None:
            moved = changes(system, self.tables, np.ascontiguousarray(b_dot.T), self.width)
        return Block(
            occurrences=np.zeros((OPERATIONS, LANES), np.int64), used=np.zeros((OPERATIONS, 2), np.int64),
            states=buffer(layout.states_size), values=values, weights=buffer(max(parts)), sheet=buffer(0),
            split=buffer(0), turned=buffer(0),
            starts=np.zeros(OPERATIONS, np.int64), strides=np.zeros(OPERATIONS, np.int64),
            cuts=np.zeros((OPERATIONS, 4), np.int64), work=buffer(int(layout.n.max())),
            growth=np.full((OPERATIONS, LANES), UNKNOWN), refined=refined, adjoint=buffer(adjoint, columns),
            by_b=buffer(system.nb, columns), moved=moved,
        )  # fmt: skip

    def arrange(self, factors: Sequence[Placement | None]) -> None:
        """Buffers for factors of all operations, in their orders of pivots."""
        cuts, ends = np.zeros((OPERATIONS, 4), np.int64), []
        for op, (own, product) in enumerate(zip(factors, self._products, strict=True)):
            if own and product:
                sizes = (own.factors, len(own.pattern.indices), len(product.indices))
                cuts[op] = np.cumsum([0, *map(_whole, sizes)])
            ends.append(cuts[op, 3] * LANES)
        starts = np.cumsum([0, *ends])
        sheet = max(int(max(cut[2], cut[3] - cut[2])) for cut in cuts)
        split = max((3 * len(own.split.pattern.indices) for own in factors if own and own.split), default=0)
        self.block = self.block._replace(
            sheet=aligned(LANES * sheet), split=used(LANES * split), turned=used(int(starts[-1])),
            starts=starts[:-1].astype(np.int64), strides=cuts[:, 3].copy(), cuts=cuts,
        )  # fmt: skip

    def matrices(self, factors: Sequence[Placement | None]) -> Matrices:
        """Patterns of all operations one after another."""
        return _matrices(factors, self._products, self.panels)

    def gradient(self) -> Array:
        """Return the gradient by the parameters (nb, k) from the adjoint variables, and clear it."""
        by_b = self.block.by_b
        if not len(by_b):
            return np.zeros((self._system.nb, self._columns))
        found = -by_b.reshape(self._columns, -1, LANES).sum(axis=2).T
        by_b[:] = 0.0
        return np.asarray(found)


@once_alike
def _kernels(system: System, structures: tuple[Structure, ...], forward: bool) -> Kernels:
    """The drivers that operations need."""
    needed = drivers_of(structures, system)
    operators: dict[str, Any] = {
        name: system.group(*GROUPS[name]).entry_in_lanes if name in needed else pointer.NONE
        for name in DRIVERS
    }
    gradients = [] if forward else [gradient_entry(system, kind) for kind in kinds_of(structures, system)]
    ends = np.cumsum([0, *(len(entry.addresses) for entry in gradients)]).astype(np.int64)
    return Kernels(**operators, gradient=joined(gradients), gradients=ends)


def _matrices(
    arranged: Sequence[Placement | None], products: Sequence[Product | None], panels: bool
) -> Matrices:
    """Patterns of all operations one after another."""
    none = np.zeros(0, np.uint64)

    def stacked(of: Sequence[NamedTuple | None], name: str) -> Ragged:
        empty = np.zeros((0, 3), np.int64) if name == "parts" else none
        return ragged([empty if one is None else getattr(one, name) for one in of], empty.dtype)

    patterns = [one and one.pattern for one in arranged]
    rows = [by_rows(one) if one and panels else None for one in patterns]
    by = (
        [one.upper if one else no_rows() for one in rows],
        [one.whole if one else no_rows() for one in rows],
        [one.rows if one and panels else no_rows() for one in products],
    )
    split = [one.split if one else None for one in arranged]
    which = next((n for n, one in enumerate(split) if one), NOWHERE)
    wide = (
        RaggedRows._make(ragged([getattr(one, name) for one in own], np.uint64) for name in Rows._fields)
        for own in by
    )
    return Matrices._make([
        *(stacked(arranged, name) for name in ("parts", "places")),
        RaggedPattern._make(stacked(patterns, name) for name in Pattern._fields),
        *(stacked(products, name) for name in ("parts", "places", "indptr", "indices")),
        *wide, (split[which] if which != NOWHERE else UNSPLIT), which,
    ])  # fmt: skip
