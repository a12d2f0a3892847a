"""Solutions with the factors of one matrix, whose neighbouring columns of L make panels. (Functions that are compiled.)

Neighbouring columns of L with the same rows below them make a panel (Demmel, Eisenstat, Gilbert, Li and Liu 1999):
`lanes_loop` factors three at a time. All places are unsigned numbers: a signed one might count from the end, which
compiled code would check at every access. Storage is that of `sparse_lu`.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._jit.kernels.lanes import fill, load, minus_product, product, store
from .._jit.kernels.vector import LANES
from .._jit.linking.link import compiled
from ..algebra import Array

# Relative error left in a solution, by how much refinements contract, up to which it is not refined again; how often
# at most
REFINED = float(np.finfo(float).eps) / 2
REFINEMENTS = 4
ONE: Any = np.uint64(1)
TWO: Any = np.uint64(2)
THREE: Any = np.uint64(3)
FOUR: Any = np.uint64(4)


Buffers: TypeAlias = Array | tuple[Array, ...]  # workspace arrays of the size of the unknowns


class Pattern(NamedTuple):
    """The order of the pivots of a matrix, and the pattern of its factors; all places are unsigned.

    Attributes
    ----------
    indptr, indices : the matrix, rows and columns in the order of the pivots
    pointers, rows, diagonal : of the factors, see `sparse_lu`
    ends : of panels, see `panel_ends`
    """

    indptr: Array
    indices: Array
    pointers: Array
    rows: Array
    diagonal: Array
    ends: Array
    row_place: Array
    column_order: Array


class Factors(NamedTuple):
    """Numbers of one matrix and of its factors; pivots are stored as what they are divided by."""

    pattern: Pattern
    data: Array
    factors: Array


@compiled(entry=True)
def panel_ends(pointers: Array, rows: Array, diagonal: Array) -> Array:
    """For each column the one behind the last of its panel."""
    n = len(diagonal)
    behind = np.arange(1, n + 1).astype(np.uint64)
    for j in range(n - 2, -1, -1):
        first, second = diagonal[j] + ONE, diagonal[j + 1] + ONE
        size = pointers[j + 2] - second
        if pointers[j + 1] - first == size + ONE and rows[first] == j + 1:
            same = True
            for k in range(size):
                same = same and rows[first + ONE + k] == rows[second + k]
            if same:
                behind[j] = behind[j + 1]
    return behind


@compiled
def sparse_product(numbers: Array, places: Array, x: Array, first: Any, last: Any) -> Any:
    """Sum of some numbers times the entries of x at their places: four sums, which need not wait for each other."""
    a, b, c, d, k = 0.0, 0.0, 0.0, 0.0, first
    while k + THREE < last:
        a += numbers[k] * x[places[k]]
        b += numbers[k + ONE] * x[places[k + ONE]]
        c += numbers[k + TWO] * x[places[k + TWO]]
        d += numbers[k + THREE] * x[places[k + THREE]]
        k = k + FOUR
    while k < last:
        a += numbers[k] * x[places[k]]
        k = k + ONE
    return (a + b) + (c + d)


@compiled
def lower_upper_flat(matrix: Factors, x: Array) -> None:
    """Solve L U x = x in place (n,)."""
    n: Any = np.uint64(len(x))
    pattern, factors = matrix.pattern, matrix.factors
    pointers, rows, diagonal = pattern.pointers, pattern.rows, pattern.diagonal
    for j in range(n):
        value = x[j]
        for entry in range(diagonal[j] + ONE, pointers[j + ONE]):
            x[rows[entry]] -= factors[entry] * value
    for back in range(n):
        j = n - ONE - back
        value = x[j] * factors[diagonal[j]]
        x[j] = value
        for entry in range(pointers[j], diagonal[j]):
            x[rows[entry]] -= factors[entry] * value


@compiled
def upper_lower_flat(matrix: Factors, x: Array) -> None:
    """Solve (L U)ᵀ x = x in place (n,)."""
    n: Any = np.uint64(len(x))
    pattern, factors = matrix.pattern, matrix.factors
    pointers, rows, diagonal = pattern.pointers, pattern.rows, pattern.diagonal
    for j in range(n):
        x[j] = (x[j] - sparse_product(factors, rows, x, pointers[j], diagonal[j])) * factors[diagonal[j]]
    for back in range(n):
        j = n - ONE - back
        x[j] -= sparse_product(factors, rows, x, diagonal[j] + ONE, pointers[j + ONE])


@compiled
def upper_lower(matrix: Factors, x: Array) -> None:
    """Solve (L U)ᵀ x = x in place, all columns at once (n, k): one, or those of whole vectors."""
    n: Any = np.uint64(x.shape[0])
    if x.shape[1] == 1:
        upper_lower_flat(matrix, x.reshape(n))
        return
    across: Any = np.uint64(x.shape[1] // LANES)
    pattern, factors = matrix.pattern, matrix.factors
    pointers, rows, diagonal = pattern.pointers, pattern.rows, pattern.diagonal
    flat = x.reshape(x.shape[0] * x.shape[1])
    for j in range(n):
        pivot = fill(factors[diagonal[j]])
        for p in range(across):
            total = load(flat, j * across + p)
            for entry in range(pointers[j], diagonal[j]):
                total = minus_product(total, fill(factors[entry]), load(flat, rows[entry] * across + p))
            store(flat, j * across + p, product(total, pivot))
    for back in range(n):
        j = n - ONE - back
        for p in range(across):
            total = load(flat, j * across + p)
            for entry in range(diagonal[j] + ONE, pointers[j + ONE]):
                total = minus_product(total, fill(factors[entry]), load(flat, rows[entry] * across + p))
            store(flat, j * across + p, total)


@compiled
def copy(x: Array, out: Array) -> None:
    """Out = x (n, k), where out may have more rows."""
    size = x.shape[0] * x.shape[1]
    source, target = x.reshape(size), out.reshape(out.shape[0] * out.shape[1])
    for k in range(size):
        target[k] = source[k]


@compiled
def error_left(change: float, before: float) -> float:
    """The relative error that a refinement leaves, by the change that it makes and that of the one before.

    A change contracts by the ratio of both. With pivots of another step it may be small already, and contract slowly.
    """
    return change * change / before if before > 0.0 else change


@compiled
def solve_flat(
    matrix: Factors, right: Array, solution: Array, x: Array, rest: Array, whole: Array, most: int
) -> tuple[float, float]:
    """Solution = matrix⁻¹ right (n,), refined so often at most; its first relative change, and the error left.

    x, rest, whole : buffers
    """
    n: Any = np.uint64(len(right))
    for k in range(n):
        whole[matrix.pattern.row_place[k]] = right[k]
    for k in range(n):
        x[k] = whole[k]
    lower_upper_flat(matrix, x)
    first, error, before = 0.0, 1.0, 1.0
    for _ in range(most):
        for k in range(n):
            rest[k] = whole[k]
        times_flat(matrix, x, rest)
        lower_upper_flat(matrix, rest)
        change = add_flat(rest, x)
        first, error, before = max(first, change), error_left(change, before), change
        if not error > REFINED:
            break
    for k in range(n):
        solution[matrix.pattern.column_order[k]] = x[k]
    return first, error


@compiled
def solve_plain_transposed(matrix: Factors, right: Array, solution: Array, buffers: Buffers) -> None:
    """Solution = matrix⁻ᵀ right (n, k), not refined."""
    n, width, x = np.uint64(right.shape[0]), right.shape[1], buffers[0]
    for k in range(n):
        for c in range(width):
            x[k, c] = right[matrix.pattern.column_order[k], c]
    upper_lower(matrix, x)
    for k in range(n):
        for c in range(width):
            solution[k, c] = x[matrix.pattern.row_place[k], c]


@compiled
def solve_columns_transposed(
    matrix: Factors, right: Array, solution: Array, buffers: Buffers
) -> tuple[float, float]:
    """Solution = matrix⁻ᵀ right (n, k), refined; its first relative change, and the error left."""
    n, width = np.uint64(right.shape[0]), right.shape[1]
    x, rest, whole = buffers[0], buffers[1], buffers[2]
    for k in range(n):
        for c in range(width):
            whole[k, c] = right[matrix.pattern.column_order[k], c]
    copy(whole, x)
    upper_lower(matrix, x)
    first, error, before = 0.0, 1.0, 1.0
    for _ in range(REFINEMENTS):
        copy(whole, rest)
        times_arranged_transposed(matrix, x, rest)
        upper_lower(matrix, rest)
        change = add(rest, x)
        first, error, before = max(first, change), error_left(change, before), change
        if not error > REFINED:
            break
    for k in range(n):
        for c in range(width):
            solution[k, c] = x[matrix.pattern.row_place[k], c]
    return first, error


@compiled
def times_arranged_transposed(matrix: Factors, x: Array, rest: Array) -> None:
    """rest -= matrixᵀ x, all as they are arranged (n, k)."""
    n: Any = np.uint64(x.shape[0])
    if x.shape[1] == 1:
        times_flat_transposed(matrix, x.reshape(n), rest.reshape(n))
        return
    indptr, indices = matrix.pattern.indptr, matrix.pattern.indices
    across: Any = np.uint64(x.shape[1] // LANES)
    size = x.shape[0] * x.shape[1]
    source, target = x.reshape(size), rest.reshape(size)
    for j in range(n):
        for p in range(across):
            total = load(target, j * across + p)
            for entry in range(indptr[j], indptr[j + ONE]):
                own = load(source, indices[entry] * across + p)
                total = minus_product(total, fill(matrix.data[entry]), own)
            store(target, j * across + p, total)


@compiled
def times_flat(matrix: Factors, x: Array, rest: Array) -> None:
    """rest -= matrix x, all as they are arranged (n,)."""
    indptr, indices = matrix.pattern.indptr, matrix.pattern.indices
    for j in range(np.uint64(len(x))):
        value = x[j]
        for entry in range(indptr[j], indptr[j + ONE]):
            rest[indices[entry]] -= matrix.data[entry] * value


@compiled
def times_flat_transposed(matrix: Factors, x: Array, rest: Array) -> None:
    """rest -= matrixᵀ x, all as they are arranged (n,)."""
    indptr, indices = matrix.pattern.indptr, matrix.pattern.indices
    for j in range(np.uint64(len(x))):
        rest[j] -= sparse_product(matrix.data, indices, x, indptr[j], indptr[j + ONE])


@compiled
def add(change: Array, x: Array) -> float:
    """x += change (n, k); see `add_flat`."""
    size = x.shape[0] * x.shape[1]
    return add_flat(change.reshape(size), x.reshape(size))


@compiled
def add_flat(changes: Array, values: Array) -> float:
    """Add; the largest change over the largest entry, not a number if one of the changes is none."""
    most, largest, total = 0.0, 1e-300, 0.0
    for k in range(len(values)):
        most, largest = max(most, abs(changes[k])), max(largest, abs(values[k]))
        values[k] += changes[k]
        total += changes[k]
    return most / largest if abs(total) < np.inf else np.nan
