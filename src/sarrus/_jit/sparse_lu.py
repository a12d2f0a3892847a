"""LU factors of a sparse matrix on a fixed pattern with fixed pivots, by columns (Gilbert and Peierls 1988).

The pattern of the factors is found once (`symbolic`); after that a matrix with the same pattern is factored without
searching, pivoting or allocating (`refactor`), from compiled code. The pivot order is the caller's. These are plain
functions, to be compiled by `compiled_function`.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def symbolic(n: Any, indptr: Any, indices: Any) -> Any:
    """Pattern of the factors of a matrix in pivot order: for every column its rows, rising (both factors in one).

    Returns
    -------
    column pointers (n + 1,), rows, and for every column the place of its diagonal entry (n,)
    """
    pointers, diagonal = np.zeros(n + 1, np.int64), np.zeros(n, np.int64)
    rows = np.empty(4 * len(indices) + 4 * n, np.int64)
    mark, stack, found = np.full(n, -1, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
    for j in range(n):
        count = 0
        for place in range(indptr[j], indptr[j + 1]):
            depth = 0
            if mark[indices[place]] != j:
                mark[indices[place]] = j
                stack[0], depth = indices[place], 1
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
            larger = np.empty(2 * len(rows) + count, np.int64)
            larger[: pointers[j]] = rows[: pointers[j]]
            rows = larger
        column = np.sort(found[:count])
        for c in range(count):
            rows[pointers[j] + c] = column[c]
            if column[c] == j:
                diagonal[j] = pointers[j] + c
        pointers[j + 1] = pointers[j] + count
    return pointers, rows[: pointers[n]].copy(), diagonal


def refactor(
    pointers: Any, rows: Any, diagonal: Any, indptr: Any, indices: Any, data: Any, factors: Any, work: Any
) -> Any:
    """Factor a matrix on a known pattern; U on and above the diagonal, L (unit diagonal) below, in one array.

    Returns
    -------
    smallest |pivot| over the largest entry below it: small values tell that the pivots no longer fit; zero or nan
    that the matrix is singular or not finite
    """
    n, worst = len(diagonal), 1.0
    for j in range(n):
        start, end, middle = pointers[j], pointers[j + 1], diagonal[j]
        for entry in range(start, end):
            work[rows[entry]] = 0.0
        for place in range(indptr[j], indptr[j + 1]):
            work[indices[place]] += data[place]
        for entry in range(start, middle):
            k = rows[entry]
            u = work[k]
            factors[entry] = u
            if u != 0.0:
                for lower in range(diagonal[k] + 1, pointers[k + 1]):
                    work[rows[lower]] -= factors[lower] * u
        pivot = work[j]
        factors[middle] = pivot
        largest = abs(pivot)
        for entry in range(middle + 1, end):
            largest = max(largest, abs(work[rows[entry]]))
        if not largest > 0.0 or pivot == 0.0:
            return 0.0
        worst = min(worst, abs(pivot) / largest)
        for entry in range(middle + 1, end):
            factors[entry] = work[rows[entry]] / pivot
    return worst


def solve(pointers: Any, rows: Any, diagonal: Any, factors: Any, x: Any) -> None:
    """Solve L U x = x in place."""
    n = len(diagonal)
    for j in range(n):
        if x[j] != 0.0:
            for entry in range(diagonal[j] + 1, pointers[j + 1]):
                x[rows[entry]] -= factors[entry] * x[j]
    for j in range(n - 1, -1, -1):
        x[j] /= factors[diagonal[j]]
        for entry in range(pointers[j], diagonal[j]):
            x[rows[entry]] -= factors[entry] * x[j]


def solve_transposed(pointers: Any, rows: Any, diagonal: Any, factors: Any, x: Any) -> None:
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
