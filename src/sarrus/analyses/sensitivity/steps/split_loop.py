"""Solution of the equations of three stages by iteration with two matrices of one stage. (Functions that are compiled.)

With the operators of one stage for all three, the matrix of a step is split into a real and a complex matrix
(`dynamics.methods.splitting`). Their factors precondition the exact matrix, which has the operators of each stage.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...._jit.linking.link import compiled
from ....algebra import Array
from ....linalg.lanes_loop import assemble_pairs_lanes, factor_pairs_lanes
from ....linalg.panel_loop import (
    Buffers,
    Factors,
    Pattern,
    copy,
    error_left,
    times_arranged_transposed,
    times_flat,
)

ONE: Any = np.uint64(1)
TWO: Any = np.uint64(2)
THREE: Any = np.uint64(3)
LEFT = 1e-14  # relative error left in a column of a solution, by how much its corrections contract
LEAST = 2  # corrections of a solution: the contraction is the ratio of two of them
CORRECTIONS = 16  # most corrections of a solution; each has to be a sixth of the one before, or less


class Transformation(NamedTuple):
    """From right sides of three stages to those of a real and a complex matrix, and from their solutions back.

    source, target : rows of a right side and of a solution, of one stage, in the order of the pivots
    enter, leave : (3, 3) of the stages: to the real entry and the parts of the complex one, and from these
    """

    enter: Array
    source: Array
    leave: Array
    target: Array


class SplitStages(NamedTuple):
    """The real and the complex matrix of an operation whose stages are split.

    parts, places, pattern : of both
    forward, transposed : for solutions with the matrices, and with their transposes
    """

    parts: Array
    places: Array
    pattern: Pattern
    forward: Transformation
    transposed: Transformation


@compiled
def factor_split(
    split: SplitStages, weights: Array, values: Array, data: Array, factors: Array, work: Array
) -> None:
    """Assemble and factor both matrices, in lanes."""
    assemble_pairs_lanes(split.parts, split.places, weights, values, data)
    factor_pairs_lanes(split.pattern, data, factors, work)


@compiled
def lessen(rows: Array, factors: Array, x: Array, at: Any, first: Any, last: Any) -> None:
    """Subtract from the entries of x at one row some factors times those at their rows; x as in `solve_factors`."""
    a, b, c = x[at], x[at + ONE], x[at + TWO]
    for k in range(first, last):
        by, re, im = rows[k] * THREE, factors[k * THREE + ONE], factors[k * THREE + TWO]
        a -= factors[k * THREE] * x[by]
        b -= re * x[by + ONE] - im * x[by + TWO]
        c -= re * x[by + TWO] + im * x[by + ONE]
    x[at], x[at + ONE], x[at + TWO] = a, b, c


@compiled
def subtract(rows: Array, factors: Array, x: Array, at: Any, first: Any, last: Any) -> None:
    """Subtract some factors times the entries of x at one row from those at their rows."""
    a, b, c = x[at], x[at + ONE], x[at + TWO]
    for k in range(first, last):
        to, re, im = rows[k] * THREE, factors[k * THREE + ONE], factors[k * THREE + TWO]
        x[to] -= factors[k * THREE] * a
        x[to + ONE] -= re * b - im * c
        x[to + TWO] -= re * c + im * b


@compiled
def divide(x: Array, at: Any, pivot: Any, factors: Array) -> None:
    """Divide the entries of x at one row by the pivots, whose inverses are stored."""
    b, c, re, im = x[at + ONE], x[at + TWO], factors[pivot * THREE + ONE], factors[pivot * THREE + TWO]
    x[at] *= factors[pivot * THREE]
    x[at + ONE], x[at + TWO] = b * re - c * im, b * im + c * re


@compiled
def solve_factors(pattern: Pattern, factors: Array, transposed: bool, x: Array) -> None:
    """Solve L U x = x or (L U)ᵀ x = x in place for both matrices.

    x has of each row a real number, and the parts of a complex one.
    """
    n: Any = np.uint64(len(pattern.diagonal))
    pointers, rows, diagonal = pattern.pointers, pattern.rows, pattern.diagonal
    for j in range(n):
        if transposed:
            lessen(rows, factors, x, j * THREE, pointers[j], diagonal[j])
            divide(x, j * THREE, diagonal[j], factors)
        else:
            subtract(rows, factors, x, j * THREE, diagonal[j] + ONE, pointers[j + ONE])
    for back in range(n):
        j = n - ONE - back
        if transposed:
            lessen(rows, factors, x, j * THREE, diagonal[j] + ONE, pointers[j + ONE])
        else:
            divide(x, j * THREE, diagonal[j], factors)
            subtract(rows, factors, x, j * THREE, pointers[j], diagonal[j])


@compiled
def precondition(
    split: SplitStages, factors: Array, transposed: bool, right: Array, solution: Array, buffer: Array
) -> None:
    """Solution = P⁻¹ right or P⁻ᵀ right (n, k), where P is the matrix with the operators of one stage."""
    way = split.transposed if transposed else split.forward
    n, x = len(way.source), buffer.reshape(buffer.shape[0] * buffer.shape[1])
    for c in range(right.shape[1]):
        for k in range(n):
            j = way.source[k]
            r0, r1, r2 = right[j, c], right[n + j, c], right[2 * n + j, c]
            for i in range(3):
                x[3 * k + i] = way.enter[i, 0] * r0 + way.enter[i, 1] * r1 + way.enter[i, 2] * r2
        solve_factors(split.pattern, factors, transposed, x)
        for k in range(n):
            j, w0, w1, w2 = way.target[k], x[3 * k], x[3 * k + 1], x[3 * k + 2]
            for i in range(3):
                solution[i * n + j, c] = way.leave[i, 0] * w0 + way.leave[i, 1] * w1 + way.leave[i, 2] * w2


@compiled
def correct(change: Array, x: Array, before: Array) -> float:
    """x += change (n, k); the largest error left in a column, not a number if one of the changes is none.

    before : largest change of each column over its largest entry, of the last correction; then of this one (k,)
    """
    error = 0.0
    for c in range(x.shape[1]):
        most, largest, total = 0.0, 1e-300, 0.0
        for k in range(x.shape[0]):
            most, largest = max(most, abs(change[k, c])), max(largest, abs(x[k, c]))
            x[k, c] += change[k, c]
            total += change[k, c]
        if not abs(total) < np.inf:
            return np.nan
        now = most / largest
        error = max(error, error_left(now, before[c]))
        before[c] = now
    return error


@compiled
def solve_split(
    split: SplitStages, matrix: Factors, transposed: bool, right: Array, solution: Array, buffers: Buffers,
    changes: Array, left: float,
) -> float:  # fmt: skip
    """Solve with the exact matrix or its transpose (n, k); 0, or 1 where corrections do not converge.

    `left` is the relative error that may be left. Where it exceeds that of exact derivatives, the first correction is
    compared with the solution itself.

    `matrix` is the exact one, in the order of the unknowns, with the factors of the others. Several columns are solved
    for with the transpose only. `changes` is a buffer (k,).
    """
    scratch, rest, change = buffers[0], buffers[1], buffers[2]
    solution[:] = 0.0
    least = LEAST if left <= LEFT else LEAST - 1
    for n in range(CORRECTIONS + 1):
        copy(right, rest)
        if n > 0 and transposed:
            times_arranged_transposed(matrix, solution, rest)
        elif n > 0:
            times_flat(matrix, solution.reshape(len(right)), rest.reshape(len(right)))
        precondition(split, matrix.factors, transposed, rest, change, scratch)
        error = correct(change, solution, changes)
        if n == 0:  # the solution itself
            changes[:] = 1.0
        if n >= least and error <= left:
            return 0.0
    return 1.0
