"""The sparsity pattern of an operator, with the positions of the elements' blocks. Computed once, in linear time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from scipy.sparse import csr_array

from ..._jit.linking.cache import stored_value
from ...algebra import Array
from ...elements import BUILT_IN
from ...elements.operators import Axis, Operator
from ...elements.recorder import Variant, structure
from ...linalg.rank import with_data
from .population import Population


@dataclass(frozen=True)
class Atoms:
    """The pieces of an axis: first index and width of each, and the total length."""

    start: Array
    width: Array
    length: int


@dataclass(frozen=True)
class Pattern:
    """CSR pattern (for vectors: their length), and per population the place table (count, blocks, [base, stride])."""

    shape: tuple[int, ...]
    indptr: Array
    indices: Array
    places: tuple[Array, ...]

    @property
    def size(self) -> int:
        """Number of stored values."""
        return len(self.indices) if len(self.shape) == 2 else self.shape[0]

    def matrix(self, data: Array) -> csr_array:
        """A matrix with these values, which shares only their memory; SciPy checks the pattern once."""
        if data.shape != (self.size,):
            raise ValueError(
                f"data must have shape ({self.size},), got {data.shape}. Pass an array of this shape."
            )
        found = with_data(self._empty, data)
        found.indices, found.indptr = self.indices.copy(), self.indptr.copy()
        return found

    @cached_property
    def _empty(self) -> csr_array:
        return csr_array((np.zeros(self.size), self.indices, self.indptr), shape=self.shape)


class Axes:
    """The axes of a system, divided into atoms: its coordinates, constraint equations and parameters."""

    def __init__(
        self, populations: Sequence[Population], widths: Array, row_count: int, number_count: int
    ) -> None:
        self.populations = populations
        self._coordinates = _atoms(widths, int(widths.sum()))
        self._rows = self._row_atoms(row_count)
        self._numbers, self._first_number = self._number_atoms(number_count)

    def _row_atoms(self, row_count: int) -> Atoms:
        constraints = [p for p in self.populations if p.kind.rows]
        count = sum(p.count for p in constraints)
        width = np.zeros(count, dtype=np.int64)
        for p in constraints:
            width[p.constraints] = p.kind.rows
        return _atoms(width, row_count)

    def _number_atoms(self, number_count: int) -> tuple[Atoms, list[int]]:
        first, widths, at = [], [], 0
        for p in self.populations:
            first.append(at)
            widths.append(np.tile(np.array(p.kind.widths(), dtype=np.int64), p.count))
            at += len(widths[-1])
        return _atoms(np.concatenate(widths), number_count), first

    def atoms(self, axis: Axis) -> Atoms:
        """The pieces of an axis."""
        if axis is Axis.COORDINATES:
            return self._coordinates
        return self._rows if axis is Axis.ROWS else self._numbers

    def atom_of(self, n: int, axis: Axis, piece: int) -> Array:
        """For every element of population n: the atom of its block row (or column) `piece`."""
        p = self.populations[n]
        if axis is Axis.ROWS:
            return p.constraints
        if axis is Axis.PARAMETERS:
            return self._first_number[n] + piece + len(p.kind.fields) * np.arange(p.count)
        slot, offset = p.variant.blocks[piece]
        return np.searchsorted(self._coordinates.start, p.bodies[:, slot] + offset)

    def pattern(self, operator: Operator) -> Pattern:
        """Pattern and positions of an operator over all populations of its family."""
        members = [n for n, p in enumerate(self.populations) if operator in p.kind.family]
        if operator.is_vector:
            return self._vector(operator, members)
        return self._matrix(operator, members)

    def blocks(self, n: int, operator: Operator) -> tuple[tuple[int, int], ...]:
        """Block row and column of each block that the elements of population n contribute to an operator."""
        population = self.populations[n]
        return _structure(population.variant, operator) if population.count else ()

    def _vector(self, operator: Operator, members: list[int]) -> Pattern:
        atoms, places = self.atoms(operator.axes[0]), []
        for n in members:
            blocks = self.blocks(n, operator)
            table = np.ones((self.populations[n].count, len(blocks), 2), dtype=np.int64)
            for k, (m, _) in enumerate(blocks):
                atom = self.atom_of(n, operator.axes[0], m)
                table[:, k, 0] = atoms.start[atom]
            places.append(table)
        none = np.zeros(0, dtype=np.int64)
        return Pattern((atoms.length,), none, none, tuple(places))

    def _matrix(self, operator: Operator, members: list[int]) -> Pattern:
        rows, columns = (self.atoms(axis) for axis in operator.axes)
        keys = [self._keys(n, operator, len(columns.start)) for n in members]
        unique = _unique(np.concatenate([key.reshape(-1) for key in keys]))
        row, column = np.divmod(unique, max(len(columns.start), 1))
        per_row = np.bincount(row, weights=columns.width[column], minlength=len(rows.start)).astype(np.int64)
        indptr = np.concatenate([[0], np.cumsum(np.repeat(per_row, rows.width))]).astype(np.int64)
        widths = columns.width[column]
        before = np.cumsum(widths) - widths
        first = np.searchsorted(row, np.arange(len(rows.start)))
        base = indptr[rows.start[row]] + before - (before[first[row]] if len(row) else 0)
        indices = _indices(indptr[-1], base, per_row[row], rows.width[row], widths, columns.start[column])
        places = tuple(_places(key, unique, base, per_row[row]) for key in keys)
        return Pattern((rows.length, columns.length), indptr.astype(np.int32), indices, places)

    def _keys(self, n: int, operator: Operator, column_count: int) -> Array:
        blocks = self.blocks(n, operator)
        keys = np.zeros((self.populations[n].count, len(blocks)), dtype=np.int64)
        for k, (m, c) in enumerate(blocks):
            row, column = self.atom_of(n, operator.axes[0], m), self.atom_of(n, operator.axes[1], c)
            keys[:, k] = row * column_count + column
        return keys


@cache
def _structure(variant: Variant, operator: Operator) -> tuple[tuple[int, int], ...]:
    """The recorded blocks of an operator; those of built-in elements are cached on disk, beside their kernels."""
    if variant.kind not in BUILT_IN:
        return structure(variant, operator)
    found = stored_value(f"{variant.name}.{operator.name}", lambda: structure(variant, operator))
    return tuple((row, column) for row, column in found)


def _unique(keys: Array) -> Array:
    """The distinct keys in ascending order; by sorting, which is faster than the hashing of `numpy.unique`."""
    ordered = np.sort(keys)
    return ordered[np.concatenate([[True], ordered[1:] != ordered[:-1]])] if len(keys) else keys


def _atoms(width: Array | list[int], length: int) -> Atoms:
    width = np.asarray(width, dtype=np.int64)
    return Atoms(np.cumsum(width) - width, width, length)


def _indices(size: int, base: Array, stride: Array, height: Array, width: Array, first: Array) -> Array:
    indices = np.zeros(size, dtype=np.int32)
    for r in range(int(height.max(initial=0))):
        for c in range(int(width.max(initial=0))):
            has = (height > r) & (width > c)
            indices[base[has] + r * stride[has] + c] = first[has] + c
    return indices


def _places(keys: Array, unique: Array, base: Array, stride: Array) -> Array:
    at = np.searchsorted(unique, keys)
    return (
        np.stack([base[at], stride[at]], axis=-1)
        if len(unique)
        else np.zeros((*keys.shape, 2), dtype=np.int64)
    )
