"""The pivot order of a sparse matrix: few new entries, large enough pivots.

Markowitz (1957) with Zlatev's limited search (1980): of the columns with the fewest entries some are looked at; of
their entries that are not small in their column, that one is the pivot whose row and column have the fewest others.
What is not yet eliminated is stored by columns, with the columns of each row beside it. Compiled functions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._jit.linking.link import compiled
from ..algebra import Array

LOOKED_AT = 16  # columns at each step
LARGE = 0.01  # of the largest in its column: an entry that may be a pivot
LONGEST = 100, 400  # entries of a row or a column, most of the time, and at most: others have dense factors
FOUND, SINGULAR, DENSE = 0, 1, 2


class Work(NamedTuple):
    """The entries, zero or not, that are not yet eliminated.

    rows, values : (n, longest) of each column, rows rising
    columns : (n, longest) of each row, in any order
    in_row, in_column : how many each row and each column in `left` has
    left, slots, looked : columns, those that are done before the others; where each is; places that are looked at
    pivot_rows, pivot_values, new_rows, new_values : buffers, of the pivot's column and of a changed one
    """

    rows: Array
    values: Array
    columns: Array
    in_row: Array
    in_column: Array
    left: Array
    slots: Array
    looked: Array
    pivot_rows: Array
    pivot_values: Array
    new_rows: Array
    new_values: Array


@compiled
def fill(indptr: Array, indices: Array, data: Array, work: Work) -> bool:
    """Spread the matrix; false if a row or a column is too long."""
    longest = work.rows.shape[1]
    for j in range(len(indptr) - 1):
        if indptr[j + 1] - indptr[j] > longest:
            return False
        for place in range(indptr[j], indptr[j + 1]):
            i, slot = indices[place], work.in_column[j]
            if work.in_row[i] == longest:
                return False
            work.rows[j, slot], work.values[j, slot], work.columns[i, work.in_row[i]] = i, data[place], j
            work.in_row[i] += 1
            work.in_column[j] += 1
    return True


@compiled
def fewest(k: int, work: Work) -> int:
    """Put the columns with the fewest entries into `looked`, the k-th step; returns how many."""
    found, looked, count, most = 0, work.looked, work.in_column, 0
    for slot in range(k, len(count)):
        entries = count[slot]
        if found < LOOKED_AT or entries < most:
            at = min(found, LOOKED_AT - 1)
            while at > 0 and entries < count[looked[at - 1]]:
                looked[at] = looked[at - 1]
                at -= 1
            looked[at] = slot
            found = min(found + 1, LOOKED_AT)
            most = count[looked[found - 1]]
    return found


@compiled
def pivot_of(found: int, work: Work) -> tuple[int, int]:
    """Row of the pivot, -1 if there is none, and its column's place in `left`."""
    best, size, row, taken = np.inf, 0.0, -1, -1
    for c in range(found):
        if best == 0.0:
            break
        j, count, largest = work.left[work.looked[c]], work.in_column[work.looked[c]], 0.0
        for slot in range(count):
            largest = max(largest, abs(work.values[j, slot]))
        for slot in range(count):
            i, here = work.rows[j, slot], abs(work.values[j, slot])
            cost = float((work.in_row[i] - 1) * (count - 1))
            fewer = cost < best or (cost == best and here > size * largest)
            if fewer and largest > 0.0 and here >= LARGE * largest:
                best, size, row, taken = cost, here / largest, i, work.looked[c]
    return row, taken


@compiled
def take_out(row: int, column: int, work: Work) -> int:
    """Move the pivot's column into its buffer; how many other entries it has. The pivot is behind them."""
    count, length = 0, work.in_column[work.slots[column]]
    for slot in range(length):
        i, value = work.rows[column, slot], work.values[column, slot]
        if i == row:
            work.pivot_values[length - 1] = value
        else:
            work.pivot_rows[count], work.pivot_values[count] = i, value
            count += 1
            last = work.in_row[i] - 1
            for place in range(last):
                if work.columns[i, place] == column:
                    work.columns[i, place] = work.columns[i, last]
            work.in_row[i] = last
    return count


@compiled
def subtract(row: int, below: int, other: int, work: Work) -> bool:
    """Eliminate the entry of a column in the pivot's row; false if a row or a column becomes too long."""
    longest, length, factor = work.rows.shape[1], work.in_column[work.slots[other]], work.pivot_values[below]
    for slot in range(length):
        if work.rows[other, slot] == row:
            factor = work.values[other, slot] / factor
            break
    first, second, count = 0, 0, 0
    while first < length or second < below:
        i = work.rows[other, first] if first < length else len(work.in_row)
        at = work.pivot_rows[second] if second < below else len(work.in_row)
        value = work.values[other, first] if i <= at else 0.0 * factor
        if at <= i:
            value -= work.pivot_values[second] * factor
            second += 1
        if at < i:
            if work.in_row[at] == longest:
                return False
            work.columns[at, work.in_row[at]] = other
            work.in_row[at] += 1
        else:
            first += 1
        if min(i, at) != row:
            if count == longest:
                return False
            work.new_rows[count], work.new_values[count] = min(i, at), value
            count += 1
    for slot in range(count):
        work.rows[other, slot], work.values[other, slot] = work.new_rows[slot], work.new_values[slot]
    work.in_column[work.slots[other]] = count
    return True


@compiled
def eliminate(row: int, column: int, work: Work) -> bool:
    """One step, with the pivot in this row and column; false if the others become too long."""
    below = take_out(row, column, work)
    for place in range(work.in_row[row]):
        other = work.columns[row, place]
        if other != column and not subtract(row, below, other, work):
            return False
    return True


@compiled
def bring(taken: int, k: int, work: Work) -> int:
    """Exchange two places of `left`; the column that is then in the second."""
    column, other, left, count = work.left[taken], work.left[k], work.left, work.in_column
    left[taken], left[k], work.slots[column], work.slots[other] = other, column, k, taken
    count[taken], count[k] = count[k], count[taken]
    return int(column)


@compiled(entry=True)
def order(
    indptr: Array, indices: Array, data: Array, row_place: Array, column_order: Array, longest: int
) -> int:
    """Write the place of each row and the column at each place; whether they are found, with rows so long at most."""
    n = len(row_place)
    lists, places = np.empty((2, n, longest), np.int32), np.zeros((2, n), np.int64)
    values, buffers = np.empty((n, longest), data.dtype), np.empty((2, n), data.dtype)
    rows = np.empty((2, n), np.int64)
    work = Work(
        lists[0], values, lists[1], places[0], places[1], np.arange(n), np.arange(n), np.zeros(LOOKED_AT, np.int64),
        rows[0], buffers[0], rows[1], buffers[1],
    )  # fmt: skip
    if not fill(indptr, indices, data, work):
        return DENSE
    for k in range(n):
        row, taken = pivot_of(fewest(k, work), work)
        if row < 0:
            return SINGULAR
        column = bring(taken, k, work)
        row_place[row], column_order[k] = k, column
        if not eliminate(row, column, work):
            return DENSE
    return FOUND
