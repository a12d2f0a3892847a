"""In which order are rows and columns of a small sparse matrix eliminated: few new entries, pivots that are large enough.

Markowitz (1957) with Zlatev's limited search (1980): of the columns with the fewest entries some are looked at; of
their entries that are not small in their column, that one is the pivot whose row and column have the fewest others.
The matrix is held dense while this goes on. A plain function, to be compiled by `compiled_function`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

LOOKED_AT = 4  # columns at each step
LARGE = 0.01  # of the largest in its column: an entry that may be a pivot


def order(indptr: Any, indices: Any, data: Any, row_place: Any, column_order: Any) -> Any:
    """Write the place of each row and the column at each place; false if the matrix is singular."""
    n = len(row_place)
    a, full = np.zeros((n, n), data.dtype), np.zeros((n, n), np.bool_)  # [column, row]
    in_row, in_column = np.zeros(n, np.int64), np.zeros(n, np.int64)
    row_place[:] = -1
    for j in range(n):
        for place in range(indptr[j], indptr[j + 1]):
            i = indices[place]
            a[j, i], full[j, i] = data[place], True
            in_row[i] += 1
            in_column[j] += 1
    left, looked = np.arange(n), np.zeros(LOOKED_AT, np.int64)
    rows, columns = np.zeros(n, np.int64), np.zeros(n, np.int64)
    for k in range(n):
        found = 0
        for slot in range(k, n):  # the columns with the fewest entries, by insertion
            at = found if found < LOOKED_AT else LOOKED_AT - 1
            if found < LOOKED_AT or in_column[left[slot]] < in_column[left[looked[at]]]:
                while at > 0 and in_column[left[slot]] < in_column[left[looked[at - 1]]]:
                    looked[at] = looked[at - 1]
                    at -= 1
                looked[at] = slot
                found = min(found + 1, LOOKED_AT)
        best, size, pivot, taken = np.int64(n * n + 1), 0.0, -1, -1
        for c in range(found):
            j, largest = left[looked[c]], 0.0
            for i in range(n):
                if full[j, i] and row_place[i] < 0:
                    largest = max(largest, abs(a[j, i]))
            for i in range(n):
                if full[j, i] and row_place[i] < 0 and abs(a[j, i]) >= LARGE * largest and largest > 0.0:
                    cost = (in_row[i] - 1) * (in_column[j] - 1)
                    if cost < best or (cost == best and abs(a[j, i]) > size * largest):
                        best, size, pivot, taken = cost, abs(a[j, i]) / largest, i, looked[c]
        if pivot < 0:
            return False
        j = left[taken]
        left[taken], left[k] = left[k], j
        row_place[pivot], column_order[k] = k, j
        below = 0
        for i in range(n):
            if full[j, i] and row_place[i] < 0:
                rows[below] = i
                below += 1
                in_row[i] -= 1
        beside = 0
        for slot in range(k + 1, n):
            if full[left[slot], pivot]:
                columns[beside] = left[slot]
                beside += 1
                in_column[left[slot]] -= 1
        for c in range(beside):
            other = columns[c]
            factor = a[other, pivot] / a[j, pivot]
            for r in range(below):
                i = rows[r]
                a[other, i] -= a[j, i] * factor
                if not full[other, i]:
                    full[other, i] = True
                    in_row[i] += 1
                    in_column[other] += 1
    return True
