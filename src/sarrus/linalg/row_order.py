"""Patterns by rows of matrices whose numbers are stored by columns, for `columns_loop`."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.sparse import csc_array

from ..algebra import Array
from .columns_loop import ByRows, Rows
from .panel_loop import Pattern

MOST = 3  # rows that are taken together


def unsigned(arrays: Iterable[Array]) -> list[Array]:
    """Places as compiled code looks them up fastest."""
    return [np.ascontiguousarray(array).astype(np.uint64) for array in arrays]


def no_rows() -> Rows:
    """Return an empty pattern."""
    return Rows._make(unsigned([np.zeros(0)] * 4))


def rows_of(indptr: Array, indices: Array, places: Array, count: int) -> Rows:
    """A matrix of some rows, by columns, whose numbers have these places."""
    pointers, columns, places = _turned(indptr, indices, places, count)
    sizes = np.diff(pointers)
    like = sizes[:-1] == sizes[1:]
    first = np.flatnonzero(np.repeat(np.append(like, False), sizes))
    second = first + np.repeat(sizes, sizes)[first]
    differ = (columns[first] != columns[second]) | (places[first] + 1 != places[second])
    rows = np.repeat(np.arange(count), sizes)[first]
    like[rows[differ]] = False
    return Rows._make(unsigned((pointers, columns, places, _groups(like, count))))


def _turned(indptr: Array, indices: Array, places: Array, count: int) -> tuple[Array, Array, Array]:
    """Pointers, columns (ascending) and places by rows."""
    shape = (count, len(indptr) - 1)
    found = csc_array((places.astype(np.int64), indices.astype(np.int64), indptr.astype(np.int64)), shape)
    turned = found.tocsr()
    return turned.indptr, turned.indices, turned.data


def _groups(like: Array, count: int) -> Array:
    """Return the number of further rows that are processed with each first row."""
    more, k = np.zeros(count), 0
    while k < count:
        while more[k] < MOST - 1 and k + more[k] + 1 < count and like[k + int(more[k])]:
            more[k] += 1
        k += int(more[k]) + 1
    return more


def by_rows(matrix: Pattern) -> ByRows:
    """U and the matrix itself, the latter in the order of the equations and unknowns."""
    return ByRows(_upper(matrix), _whole(matrix))


def _upper(matrix: Pattern) -> Rows:
    """The rows above the diagonal, the last columns first; `more` where the row before has the same ones, and this."""
    first, last = matrix.pointers[:-1].astype(np.int64), matrix.diagonal.astype(np.int64)
    n = len(last)
    places = _ranges(first, last - first)
    indptr = np.concatenate([[0], np.cumsum(last - first)])
    pointers, columns, places = _turned(indptr, matrix.rows[places], places, n)
    backward = _ranges(pointers[:-1], np.diff(pointers))[::-1]
    rows = np.repeat(np.arange(n), np.diff(pointers))
    backward = backward[np.argsort(rows[backward], kind="stable")]
    columns, places = columns[backward], places[backward]
    more, k = np.zeros(n), n - 1
    while k > 0:
        own, before = slice(pointers[k], pointers[k + 1]), slice(pointers[k - 1], pointers[k])
        more[k] = _follows(columns[own], columns[before], k)
        k -= 1 + int(more[k])
    return Rows._make(unsigned((pointers, columns, places, more)))


def _follows(own: Array, before: Array, k: int) -> bool:
    """Whether the row before row k has the same columns, and k."""
    return len(before) == len(own) + 1 and before[-1] == k and np.array_equal(before[:-1], own)


def _whole(matrix: Pattern) -> Rows:
    starts, order = matrix.indptr.astype(np.int64), matrix.column_order.astype(np.int64)
    n = len(order)
    at, own_row = np.empty(n, np.int64), np.empty(n, np.int64)
    at[order], own_row[matrix.row_place.astype(np.int64)] = np.arange(n), np.arange(n)
    sizes = np.diff(starts)[at]
    places = _ranges(starts[at], sizes)
    rows = own_row[matrix.indices[places].astype(np.int64)]
    return rows_of(np.concatenate([[0], np.cumsum(sizes)]), rows, places, n)


def _ranges(first: Array, sizes: Array) -> Array:
    """first, first + 1, ... as many as the sizes, for all one after another."""
    ends = np.cumsum(sizes)
    return np.repeat(first - ends + sizes, sizes) + np.arange(ends[-1] if len(ends) else 0)
