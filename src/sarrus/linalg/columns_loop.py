"""Solutions of many columns at once: panels of them side by side in vectors. (Functions that are compiled.)

A panel is as many columns as fill two vectors: its rows lie one after another, and stay in the fast memory while a step
is made with them. Where sums can wait for nothing, they are taken by rows, two or three of which have the same columns:
then each entry of the unknowns is read once for all of them, and nothing is written in between.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._jit.kernels.lanes import fill, load, minus_product, plus_product, product, store
from .._jit.kernels.vector import LANES
from .._jit.linking.link import compiled
from ..algebra import Array
from .panel_loop import REFINED, Factors, error_left

COLUMNS = 2 * LANES  # of a panel
ONE: Any = np.uint64(1)
TWO: Any = np.uint64(2)
THREE: Any = np.uint64(3)
FOUR: Any = np.uint64(4)
FIVE: Any = np.uint64(5)


class Rows(NamedTuple):
    """A matrix by rows: where each begins, columns, and the places of the numbers, which are stored by columns.

    more : how many rows next to one have the same columns, and numbers next to its own
    """

    indptr: Array
    columns: Array
    places: Array
    more: Array


class ByRows(NamedTuple):
    """The matrix U of factors and the matrix itself, the latter not in the order of the pivots."""

    upper: Rows
    whole: Rows


@compiled
def minus_rows(rows: Rows, numbers: Array, x: Array, out: Array) -> None:
    """Out -= A x, of a panel."""
    n: Any = np.uint64(len(rows.more))
    k: Any = np.uint64(0)
    while k < n:
        at, more = k * TWO, rows.more[k]
        a0, b0 = load(out, at), load(out, at + ONE)
        if more == TWO:
            a1, b1 = load(out, at + TWO), load(out, at + THREE)
            a2, b2 = load(out, at + FOUR), load(out, at + FIVE)
            for entry in range(rows.indptr[k], rows.indptr[k + ONE]):
                place, column = rows.places[entry], rows.columns[entry] * TWO
                a, b = load(x, column), load(x, column + ONE)
                u, v, w = fill(numbers[place]), fill(numbers[place + ONE]), fill(numbers[place + TWO])
                a0, b0 = minus_product(a0, u, a), minus_product(b0, u, b)
                a1, b1 = minus_product(a1, v, a), minus_product(b1, v, b)
                a2, b2 = minus_product(a2, w, a), minus_product(b2, w, b)
            store(out, at + TWO, a1)
            store(out, at + THREE, b1)
            store(out, at + FOUR, a2)
            store(out, at + FIVE, b2)
        elif more == ONE:
            a1, b1 = load(out, at + TWO), load(out, at + THREE)
            for entry in range(rows.indptr[k], rows.indptr[k + ONE]):
                place, column = rows.places[entry], rows.columns[entry] * TWO
                a, b = load(x, column), load(x, column + ONE)
                u, v = fill(numbers[place]), fill(numbers[place + ONE])
                a0, b0 = minus_product(a0, u, a), minus_product(b0, u, b)
                a1, b1 = minus_product(a1, v, a), minus_product(b1, v, b)
            store(out, at + TWO, a1)
            store(out, at + THREE, b1)
        else:
            for entry in range(rows.indptr[k], rows.indptr[k + ONE]):
                u, column = fill(numbers[rows.places[entry]]), rows.columns[entry] * TWO
                a0, b0 = (
                    minus_product(a0, u, load(x, column)),
                    minus_product(b0, u, load(x, column + ONE)),
                )
        store(out, at, a0)
        store(out, at + ONE, b0)
        k = k + more + ONE


@compiled
def lower_panel(matrix: Factors, x: Array) -> None:
    """Solve L x = x in place, of a panel: three neighbouring columns of L with the same rows subtract at once."""
    pattern, factors = matrix.pattern, matrix.factors
    pointers, rows, diagonal = pattern.pointers, pattern.rows, pattern.diagonal
    n: Any = np.uint64(len(diagonal))
    k: Any = np.uint64(0)
    while k < n:
        behind = pattern.ends[k]
        while k + TWO < behind:
            first, second, third = diagonal[k] + ONE, diagonal[k + ONE] + ONE, diagonal[k + TWO] + ONE
            at, end = k * TWO, pointers[k + ONE]
            a0, b0 = load(x, at), load(x, at + ONE)
            u, v, w = fill(factors[first]), fill(factors[first + ONE]), fill(factors[second])
            a1, b1 = minus_product(load(x, at + TWO), u, a0), minus_product(load(x, at + THREE), u, b0)
            a2, b2 = minus_product(load(x, at + FOUR), v, a0), minus_product(load(x, at + FIVE), v, b0)
            a2, b2 = minus_product(a2, w, a1), minus_product(b2, w, b1)
            store(x, at + TWO, a1)
            store(x, at + THREE, b1)
            store(x, at + FOUR, a2)
            store(x, at + FIVE, b2)
            k, first, second = k + THREE, first + TWO, second + ONE
            for i in range(end - first):
                u, v, w = fill(factors[first + i]), fill(factors[second + i]), fill(factors[third + i])
                row = rows[first + i] * TWO
                a = minus_product(minus_product(load(x, row), u, a0), v, a1)
                b = minus_product(minus_product(load(x, row + ONE), u, b0), v, b1)
                store(x, row, minus_product(a, w, a2))
                store(x, row + ONE, minus_product(b, w, b2))
        while k < behind:
            a0, b0 = load(x, k * TWO), load(x, k * TWO + ONE)
            for entry in range(diagonal[k] + ONE, pointers[k + ONE]):
                u, row = fill(factors[entry]), rows[entry] * TWO
                store(x, row, minus_product(load(x, row), u, a0))
                store(x, row + ONE, minus_product(load(x, row + ONE), u, b0))
            k = k + ONE


@compiled
def upper_panel(matrix: Factors, upper: Rows, x: Array) -> None:
    """Solve U x = x in place, of a panel, from the last row up: two with the same columns at once."""
    diagonal, factors = matrix.pattern.diagonal, matrix.factors
    k: Any = np.uint64(len(diagonal))
    while k > np.uint64(0):
        k = k - ONE
        at = k * TWO
        a0, b0, pivot = load(x, at), load(x, at + ONE), fill(factors[diagonal[k]])
        if upper.more[k] == ONE:
            a1, b1 = load(x, at - TWO), load(x, at - ONE)
            for entry in range(upper.indptr[k], upper.indptr[k + ONE]):
                place, column = upper.places[entry], upper.columns[entry] * TWO
                a, b = load(x, column), load(x, column + ONE)
                u, v = fill(factors[place]), fill(factors[place - ONE])
                a0, b0 = minus_product(a0, u, a), minus_product(b0, u, b)
                a1, b1 = minus_product(a1, v, a), minus_product(b1, v, b)
            a0, b0, u = product(a0, pivot), product(b0, pivot), fill(factors[diagonal[k] - ONE])
            store(x, at, a0)
            store(x, at + ONE, b0)
            k, at = k - ONE, at - TWO
            pivot = fill(factors[diagonal[k]])
            a0, b0 = minus_product(a1, u, a0), minus_product(b1, u, b0)
        else:
            for entry in range(upper.indptr[k], upper.indptr[k + ONE]):
                u, column = fill(factors[upper.places[entry]]), upper.columns[entry] * TWO
                a0, b0 = (
                    minus_product(a0, u, load(x, column)),
                    minus_product(b0, u, load(x, column + ONE)),
                )
        store(x, at, product(a0, pivot))
        store(x, at + ONE, product(b0, pivot))


@compiled
def solve_rest(matrix: Factors, by_rows: ByRows, rest: Array, x: Array) -> None:
    """x = (L U)⁻¹ rest, of a panel; x in the order of the pivots."""
    for k in range(np.uint64(len(matrix.pattern.row_place))):
        at = matrix.pattern.row_place[k] * TWO
        store(x, at, load(rest, k * TWO))
        store(x, at + ONE, load(rest, k * TWO + ONE))
    lower_panel(matrix, x)
    upper_panel(matrix, by_rows.upper, x)


@compiled
def solve_panel(
    matrix: Factors, by_rows: ByRows, right: Array, solution: Array, x: Array, rest: Array, most: int
) -> tuple[float, float]:
    """Solution = matrix⁻¹ right of a panel, refined so often at most; its first relative change, and the error left.

    x, rest : memory for panels
    """
    n: Any = np.uint64(len(matrix.pattern.diagonal))
    solve_rest(matrix, by_rows, right, x)
    for k in range(n):
        at = matrix.pattern.column_order[k] * TWO
        store(solution, at, load(x, k * TWO))
        store(solution, at + ONE, load(x, k * TWO + ONE))
    first, error, before = 0.0, 1.0, 1.0
    for _ in range(most):
        for k in range(n * TWO):
            store(rest, k, load(right, k))
        minus_rows(by_rows.whole, matrix.data, solution, rest)
        solve_rest(matrix, by_rows, rest, x)
        change = add_panel(matrix.pattern.column_order, x, solution)
        first, error, before = max(first, change), error_left(change, before), change
        if not error > REFINED:
            break
    return first, error


@compiled
def add_panel(order: Array, x: Array, solution: Array) -> float:
    """Add x, in another order, to a panel of solutions; the change's size over theirs, not a number if one is none."""
    one, zero = fill(1.0), fill(0.0)
    a, b, c, d = zero, zero, zero, zero
    for k in range(np.uint64(len(order))):
        at = order[k] * TWO
        u, v, w, z = load(x, k * TWO), load(x, k * TWO + ONE), load(solution, at), load(solution, at + ONE)
        a, b, c, d = (
            plus_product(a, u, u),
            plus_product(b, v, v),
            plus_product(c, w, w),
            plus_product(d, z, z),
        )
        store(solution, at, plus_product(w, one, u))
        store(solution, at + ONE, plus_product(z, one, v))
    store(x, np.uint64(0), plus_product(a, one, b))
    store(x, ONE, plus_product(c, one, d))
    changed, whole = 0.0, 1e-300
    for k in range(LANES):
        changed += x[k]
        whole += x[LANES + k]
    return float(np.sqrt(changed / whole))
