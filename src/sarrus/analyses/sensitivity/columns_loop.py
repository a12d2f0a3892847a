"""Sparse operators and factored matrices with many columns at once, compiled: all vectors are arrays (n, columns).

Pivots are chosen for few numbers first, and their order is kept for many steps: every solution is refined once, by the
matrix as it was assembled.
"""

from __future__ import annotations

from typing import Any

ASSEMBLE: Any = None  # put in place when this is compiled
REFACTOR: Any = None


def add(values: Any, places: Any, weight: Any, x: Any, out: Any) -> None:
    """Out += weight A x; the rows and columns of the numbers of A are in `places`."""
    for k in range(len(values)):
        value, row, column = weight * values[k], places[0, k], places[1, k]
        for c in range(x.shape[1]):
            out[row, c] += value * x[column, c]


def add_transposed(values: Any, places: Any, weight: Any, x: Any, out: Any) -> None:
    """Out += weight Aᵀ x."""
    for k in range(len(values)):
        value, row, column = weight * values[k], places[0, k], places[1, k]
        for c in range(x.shape[1]):
            out[column, c] += value * x[row, c]


def eliminate(matrix: Any, x: Any) -> None:
    """X becomes the solution for the right side x, both in the order of the pivots."""
    n, width = x.shape
    for j in range(n):
        for entry in range(matrix.diagonal[j] + 1, matrix.pointers[j + 1]):
            value, row = matrix.factors[entry], matrix.rows[entry]
            for c in range(width):
                x[row, c] -= value * x[j, c]
    for j in range(n - 1, -1, -1):
        pivot = 1.0 / matrix.factors[matrix.diagonal[j]]
        for c in range(width):
            x[j, c] *= pivot
        for entry in range(matrix.pointers[j], matrix.diagonal[j]):
            value, row = matrix.factors[entry], matrix.rows[entry]
            for c in range(width):
                x[row, c] -= value * x[j, c]


def eliminate_transposed(matrix: Any, x: Any) -> None:
    """The same for the transposed matrix."""
    n, width = x.shape
    for j in range(n):
        for entry in range(matrix.pointers[j], matrix.diagonal[j]):
            value, row = matrix.factors[entry], matrix.rows[entry]
            for c in range(width):
                x[j, c] -= value * x[row, c]
        pivot = 1.0 / matrix.factors[matrix.diagonal[j]]
        for c in range(width):
            x[j, c] *= pivot
    for j in range(n - 1, -1, -1):
        for entry in range(matrix.diagonal[j] + 1, matrix.pointers[j + 1]):
            value, row = matrix.factors[entry], matrix.rows[entry]
            for c in range(width):
                x[j, c] -= value * x[row, c]


def factor_kept(values: Any, matrix: Any, data: Any) -> Any:
    """Assemble and factor a matrix, and keep its numbers in `data`; returns how far its pivots can be trusted."""
    ASSEMBLE(matrix.parts, matrix.places, matrix.weights, values, matrix.factors)
    for k in range(len(data)):
        data[k] = matrix.factors[k]
    return REFACTOR(matrix.pointers, matrix.rows, matrix.diagonal, matrix.factors, matrix.work)


def copy(x: Any, out: Any) -> None:
    """Out = x."""
    for k in range(x.shape[0]):
        for c in range(x.shape[1]):
            out[k, c] = x[k, c]


def solve(matrix: Any, data: Any, right: Any, solution: Any, room: Any) -> None:
    """Solution = matrix⁻¹ right; `data` are the numbers of the matrix, `room` is (3, n, columns)."""
    b, x, rest = room[0], room[1], room[2]
    for k in range(len(right)):
        for c in range(right.shape[1]):
            b[matrix.row_place[k], c] = right[k, c]
    copy(b, x)
    eliminate(matrix, x)
    copy(b, rest)
    for j in range(len(right)):
        for entry in range(matrix.pointers[j], matrix.pointers[j + 1]):
            for c in range(right.shape[1]):
                rest[matrix.rows[entry], c] -= data[entry] * x[j, c]
    eliminate(matrix, rest)
    for k in range(len(right)):
        for c in range(right.shape[1]):
            solution[matrix.column_order[k], c] = x[k, c] + rest[k, c]


def solve_transposed(matrix: Any, data: Any, right: Any, solution: Any, room: Any) -> None:
    """Solution = matrix⁻ᵀ right; `data` are the numbers of the matrix, `room` is (3, n, columns)."""
    b, x, rest = room[0], room[1], room[2]
    for k in range(len(right)):
        for c in range(right.shape[1]):
            b[k, c] = right[matrix.column_order[k], c]
    copy(b, x)
    eliminate_transposed(matrix, x)
    copy(b, rest)
    for j in range(len(right)):
        for entry in range(matrix.pointers[j], matrix.pointers[j + 1]):
            for c in range(right.shape[1]):
                rest[j, c] -= data[entry] * x[matrix.rows[entry], c]
    eliminate_transposed(matrix, rest)
    for k in range(len(right)):
        for c in range(right.shape[1]):
            solution[k, c] = x[matrix.row_place[k], c] + rest[matrix.row_place[k], c]


def by_numbers(numbers: Any, n: Any, weight: Any, x: Any, out: Any) -> None:
    """Out += weight A x for operator n by b."""
    for place in range(numbers.b_segments[n, 0], numbers.b_segments[n, 1]):
        k = numbers.chosen[place]
        value, row, column = weight * numbers.b_values[k], numbers.b_rows[k], numbers.b_columns[k]
        for c in range(x.shape[1]):
            out[row, c] += value * x[column, c]


def by_numbers_transposed(numbers: Any, n: Any, weight: Any, x: Any, out: Any) -> None:
    """Out += weight Aᵀ x for operator n by b."""
    for place in range(numbers.b_segments[n, 0], numbers.b_segments[n, 1]):
        k = numbers.chosen[place]
        value, row, column = weight * numbers.b_values[k], numbers.b_rows[k], numbers.b_columns[k]
        for c in range(x.shape[1]):
            out[column, c] += value * x[row, c]
