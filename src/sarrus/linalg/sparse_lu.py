"""LU factors of a sparse matrix on a fixed pattern with fixed pivots, by columns (Gilbert and Peierls 1988).

The pattern of the factors is found once (`postorder`, `symbolic`, `slots`); after that a matrix with the same pattern
is written into the places of its factors and factored there without searching, pivoting or allocating (`refactor`),
from compiled code. The pivot order is the caller's. These are compiled functions.

A matrix is given by columns (`indptr`, `indices`) in its own order; its row r becomes row `row_place[r]` of the
factors, its column `column_order[j]` becomes column j. Indices take 4 bytes each; those read in hot loops are unsigned,
which need no look whether they count from the end.
"""

from __future__ import annotations

import numpy as np

from .._jit.linking.link import compiled
from ..algebra import Array


@compiled(entry=True)
def compressed(n: int, rows: Array, columns: Array) -> tuple[Array, Array, Array]:
    """The pattern by columns, rows rising, of numbers that may share places: indptr, indices, and the place of each."""
    count = len(rows)
    start, by_row, order = np.zeros(n + 1, np.int32), np.empty(count, np.int32), np.empty(count, np.int32)
    for k in range(count):
        start[rows[k] + 1] += 1
    for k in range(n):
        start[k + 1] += start[k]
    for k in range(count):
        by_row[start[rows[k]]] = k
        start[rows[k]] += 1
    start[:] = 0
    for k in range(count):
        start[columns[k] + 1] += 1
    for k in range(n):
        start[k + 1] += start[k]
    for number in range(count):
        k = by_row[number]
        order[start[columns[k]]] = k
        start[columns[k]] += 1
    place, indptr, used = by_row, np.zeros(n + 1, np.int32), 0
    row, column = -1, -1
    for number in range(count):
        k = order[number]
        if rows[k] != row or columns[k] != column:
            row, column = rows[k], columns[k]
            indptr[column + 1] += 1
            used += 1
        place[k] = used - 1
    indices = np.empty(used, np.int32)
    for k in range(count):
        indices[place[k]] = rows[k]
    for k in range(n):
        indptr[k + 1] += indptr[k]
    return indptr, indices, place


@compiled(entry=True)
def transposed(
    n: int, indptr: Array, indices: Array, row_place: Array, column_order: Array
) -> tuple[Array, Array]:
    """The pattern of a matrix in pivot order, by rows: pointers, columns."""
    pointers, columns = np.zeros(n + 1, np.int32), np.empty(len(indices), np.int32)
    for r in indices:
        pointers[row_place[r] + 1] += 1
    for k in range(n):
        pointers[k + 1] += pointers[k]
    filled = pointers[:-1].copy()
    for j in range(n):
        for place in range(indptr[column_order[j]], indptr[column_order[j] + 1]):
            r = row_place[indices[place]]
            columns[filled[r]] = j
            filled[r] += 1
    return pointers, columns


@compiled(entry=True)
def postorder(n: int, indptr: Array, indices: Array, row_place: Array, column_order: Array) -> Array:
    """An order of the pivots with the same factors in which what depends on each other is near: where each goes (n,).

    It goes through the elimination tree of A + Aᵀ (Liu 1990), each branch to its end before the next.
    """
    pointers, columns = transposed(n, indptr, indices, row_place, column_order)
    parent, ancestor = np.full(n, -1, np.int32), np.full(n, -1, np.int32)
    for j in range(n):
        first, last = indptr[column_order[j]], indptr[column_order[j] + 1]
        for k in range(last - first + pointers[j + 1] - pointers[j]):
            i = row_place[indices[first + k]] if k < last - first else columns[pointers[j] + k - last + first]
            while i != -1 and i < j:
                above = ancestor[i]
                ancestor[i] = j
                if above == -1:
                    parent[i] = j
                i = above
    child, sibling = ancestor, np.empty(n, np.int32)
    child[:] = -1
    to, stack, count = np.empty(n, np.int32), np.empty(n, np.int32), 0
    for j in range(n - 1, -1, -1):
        if parent[j] != -1:
            sibling[j] = child[parent[j]]
            child[parent[j]] = j
    for root in range(n):
        depth = 0
        if parent[root] == -1:
            stack[0], depth = root, 1
        while depth > 0:
            j = stack[depth - 1]
            if child[j] == -1:
                depth -= 1
                to[j] = count
                count += 1
            else:
                stack[depth] = child[j]
                child[j] = sibling[child[j]]
                depth += 1
    return to


@compiled(entry=True)
def symbolic(
    n: int, indptr: Array, indices: Array, row_place: Array, column_order: Array
) -> tuple[Array, Array, Array]:
    """Pattern of the factors: for every column its rows, rising (both factors in one).

    Returns
    -------
    column pointers (n + 1,), rows, and for every column the place of its diagonal entry (n,)
    """
    pointers, diagonal = np.zeros(n + 1, np.uint32), np.zeros(n, np.uint32)
    rows = np.empty(2 * len(indices) + 2 * n, np.uint32)
    mark, stack, found = np.full(n, -1, np.int32), np.empty(n, np.int32), np.empty(n, np.int32)
    for j in range(n):
        count = 0
        for place in range(indptr[column_order[j]], indptr[column_order[j] + 1]):
            depth = 0
            if mark[row_place[indices[place]]] != j:
                mark[row_place[indices[place]]] = j
                stack[0], depth = row_place[indices[place]], 1
            while depth > 0:
                depth -= 1
                k = stack[depth]
                found[count] = k
                count += 1
                if k < j:
                    for entry in range(diagonal[k] + 1, pointers[k + 1]):
                        i = rows[entry]
                        if mark[i] != j:
                            mark[i] = j
                            stack[depth] = i
                            depth += 1
        if mark[j] != j:
            found[count] = j
            count += 1
        if pointers[j] + count > len(rows):
            larger = np.empty(len(rows) + len(rows) // 2 + count, np.uint32)
            for entry in range(pointers[j]):
                larger[entry] = rows[entry]
            rows = larger
        rise(found, count)
        for c in range(count):
            rows[pointers[j] + c] = found[c]
            if found[c] == j:
                diagonal[j] = pointers[j] + c
        pointers[j + 1] = pointers[j] + count
    return pointers, rows[: pointers[n]].copy(), diagonal


@compiled
def rise(x: Array, count: int) -> None:
    """Sort the first numbers of x (Shell 1959)."""
    gap = 1
    while 3 * gap < count:
        gap = 3 * gap + 1
    while gap > 0:
        for k in range(gap, count):
            value, to = x[k], k
            while to >= gap and x[to - gap] > value:
                x[to] = x[to - gap]
                to -= gap
            x[to] = value
        gap //= 3


@compiled(entry=True)
def slots(
    n: int, indptr: Array, indices: Array, row_place: Array, column_order: Array, pointers: Array, rows: Array
) -> Array:
    """The place of every number of the matrix among those of the factors."""
    found, where = np.empty(len(indices), np.uint32), np.empty(n, np.uint32)
    for j in range(n):
        for entry in range(pointers[j], pointers[j + 1]):
            where[rows[entry]] = entry
        for place in range(indptr[column_order[j]], indptr[column_order[j] + 1]):
            found[place] = where[row_place[indices[place]]]
    return found


@compiled(entry=True)
def refactor(
    pointers: Array, rows: Array, diagonal: Array, factors: Array, work: Array, scale: Array
) -> float:
    """Factor the matrix in `factors`: U on and above the diagonal, L (unit diagonal) below, in its place.

    Returns
    -------
    smallest pivot over the largest entry below it, rows multiplied by `scale`: with small values the pivots no longer
    fit; zero or nan that the matrix is singular or not finite. The size of a complex number is |Re| + |Im|
    """
    worst = 1.0
    for j in range(len(diagonal)):
        start, end, middle = pointers[j], pointers[j + 1], diagonal[j]
        for entry in range(start, end):
            work[rows[entry]] = factors[entry]
        for entry in range(start, middle):
            k = rows[entry]
            u = work[k]
            factors[entry] = u
            if u != 0.0:
                for lower in range(diagonal[k] + 1, pointers[k + 1]):
                    work[rows[lower]] -= factors[lower] * u
        pivot = work[j]
        factors[middle] = pivot
        size = scale[j] * (abs(pivot.real) + abs(pivot.imag))
        largest = size
        for entry in range(middle + 1, end):
            x = work[rows[entry]]
            largest = max(largest, scale[rows[entry]] * (abs(x.real) + abs(x.imag)))
        if not largest > 0.0 or pivot == 0.0:
            return 0.0
        worst = min(worst, size / largest)
        inverse = 1.0 / pivot
        if pivot.imag == 0.0:
            for entry in range(middle + 1, end):
                factors[entry] = work[rows[entry]] / pivot
        else:  # divisions of complex numbers take several times as long
            for entry in range(middle + 1, end):
                factors[entry] = work[rows[entry]] * inverse
    return worst


@compiled(entry=True)
def solve(pointers: Array, rows: Array, diagonal: Array, factors: Array, x: Array) -> None:
    """Solve L U x = x in place."""
    n = len(diagonal)
    for j in range(n):
        value = x[j]
        if value != 0.0:
            for entry in range(diagonal[j] + 1, pointers[j + 1]):
                x[rows[entry]] -= factors[entry] * value
    for j in range(n - 1, -1, -1):
        value = x[j] / factors[diagonal[j]]
        x[j] = value
        for entry in range(pointers[j], diagonal[j]):
            x[rows[entry]] -= factors[entry] * value


@compiled(entry=True)
def solve_columns(pointers: Array, rows: Array, diagonal: Array, factors: Array, x: Array) -> None:
    """Solve L U x = x in place, for all columns of x (n, k)."""
    n, count = x.shape
    for j in range(n):
        for entry in range(diagonal[j] + 1, pointers[j + 1]):
            by, row = factors[entry], rows[entry]
            for column in range(count):
                x[row, column] -= by * x[j, column]
    for j in range(n - 1, -1, -1):
        pivot = factors[diagonal[j]]
        for column in range(count):
            x[j, column] /= pivot
        for entry in range(pointers[j], diagonal[j]):
            by, row = factors[entry], rows[entry]
            for column in range(count):
                x[row, column] -= by * x[j, column]


@compiled(entry=True)
def solve_transposed(pointers: Array, rows: Array, diagonal: Array, factors: Array, x: Array) -> None:
    """Solve (L U)ᵀ x = x in place."""
    n = len(diagonal)
    for j in range(n):
        total = x[j]
        for entry in range(pointers[j], diagonal[j]):
            total -= factors[entry] * x[rows[entry]]
        x[j] = total / factors[diagonal[j]]
    for j in range(n - 1, -1, -1):
        total = x[j]
        for entry in range(diagonal[j] + 1, pointers[j + 1]):
            total -= factors[entry] * x[rows[entry]]
        x[j] = total
