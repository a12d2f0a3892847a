"""In which order are rows and columns of a small sparse matrix eliminated: few new entries, large enough pivots.

Markowitz (1957) with Zlatev's limited search (1980): of the columns with the fewest entries some are looked at; of
their entries that are not small in their column, that one is the pivot whose row and column have the fewest others.
The matrix is held dense while this goes on, a column in one line. Compiled functions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit.linking.link import compiled
from ..algebra import Array

LOOKED_AT = 4  # columns at each step
LARGE = 0.01  # of the largest in its column: an entry that may be a pivot


class Work(NamedTuple):
    """The matrix on its way, [column, row]: numbers, and where there are entries, zero or not; how many of them."""

    a: Array
    full: Array
    in_row: Array
    in_column: Array
    left: Array  # columns: those that are done, then the others
    looked: Array  # places in `left`
    rows: Array
    columns: Array


@compiled
def fill(indptr: Array, indices: Array, data: Array, work: Work) -> None:
    """Spread the matrix."""
    for j in range(len(indptr) - 1):
        for place in range(indptr[j], indptr[j + 1]):
            i = indices[place]
            work.a[j, i], work.full[j, i] = data[place], True
            work.in_row[i] += 1
            work.in_column[j] += 1


@compiled
def fewest(k: int, work: Work) -> int:
    """Put the columns with the fewest entries into `looked`, the k-th step; returns how many."""
    found, left, looked, count = 0, work.left, work.looked, work.in_column
    for slot in range(k, len(left)):
        at = min(found, LOOKED_AT - 1)
        if found < LOOKED_AT or count[left[slot]] < count[left[looked[at]]]:
            while at > 0 and count[left[slot]] < count[left[looked[at - 1]]]:
                looked[at] = looked[at - 1]
                at -= 1
            looked[at] = slot
            found = min(found + 1, LOOKED_AT)
    return found


@compiled
def pivot_of(found: int, work: Work, row_place: Array) -> tuple[int, int]:
    """Row of the pivot, -1 if there is none, and its column's place in `left`."""
    n, best, size, row, taken = len(row_place), np.inf, 0.0, -1, -1
    for c in range(found):
        j, largest = work.left[work.looked[c]], 0.0
        for i in range(n):
            if work.full[j, i] and row_place[i] < 0:
                largest = max(largest, abs(work.a[j, i]))
        for i in range(n):
            if work.full[j, i] and row_place[i] < 0:
                here, cost = abs(work.a[j, i]), float((work.in_row[i] - 1) * (work.in_column[j] - 1))
                fewer = cost < best or (cost == best and here > size * largest)
                if fewer and largest > 0.0 and here >= LARGE * largest:
                    best, size, row, taken = cost, here / largest, i, work.looked[c]
    return row, taken


@compiled
def eliminate(k: int, row: int, column: int, work: Work, row_place: Array) -> None:
    """The k-th step, with the pivot in this row and column."""
    a, full, below, beside = work.a, work.full, 0, 0
    for i in range(len(row_place)):
        if full[column, i] and row_place[i] < 0:
            work.rows[below] = i
            below += 1
            work.in_row[i] -= 1
    for slot in range(k + 1, len(row_place)):
        if full[work.left[slot], row]:
            work.columns[beside] = work.left[slot]
            beside += 1
            work.in_column[work.left[slot]] -= 1
    for other in work.columns[:beside]:
        factor = a[other, row] / a[column, row]
        for i in work.rows[:below]:
            a[other, i] -= a[column, i] * factor
            if not full[other, i]:
                full[other, i] = True
                work.in_row[i] += 1
                work.in_column[other] += 1


@compiled(entry=True)
def order(indptr: Array, indices: Array, data: Array, row_place: Array, column_order: Array) -> bool:
    """Write the place of each row and the column at each place; false if the matrix is singular."""
    n = len(row_place)
    counts, places = np.zeros((2, n), np.int64), np.zeros((2, n), np.int64)
    looked = np.zeros(LOOKED_AT, np.int64)
    a, full = np.zeros((n, n), data.dtype), np.zeros((n, n), np.bool_)
    work = Work(a, full, counts[0], counts[1], np.arange(n), looked, places[0], places[1])
    fill(indptr, indices, data, work)
    row_place[:] = -1
    for k in range(n):
        row, taken = pivot_of(fewest(k, work), work, row_place)
        if row < 0:
            return False
        column = work.left[taken]
        work.left[taken], work.left[k] = work.left[k], column
        row_place[row], column_order[k] = k, column
        eliminate(k, row, column, work, row_place)
    return True
