"""Solution of the equations of three stages by iteration with two matrices of one stage. (Functions that are compiled.)

With the operators of one stage for all three, the matrix of a step is split into a real and a complex matrix
(`dynamics.methods.splitting`). Their factors precondition the exact matrix, which has the operators of each stage.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...._jit.kernels.pairs import (
    crossed,
    exchanged,
    load_pair,
    load_triple,
    minus_pair,
    minus_parts,
    pair,
    pair_product,
    plus_parts,
    store_pair,
    straight,
)
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
def lessened(rows: Array, factors: Array, x: Array, own: Any, first: Any, last: Any) -> Any:
    """A pair less some factors times the entries of x at their rows: two sums, which need not wait for each other."""
    none = pair(0.0, 0.0, 0.0)
    a, b, c, d, k = none, none, none, none, first
    while k + ONE < last:
        factor, entry = load_triple(factors, k), load_pair(x, rows[k])
        a, b = minus_parts(a, factor, entry), minus_parts(b, factor, exchanged(entry))
        factor, entry = load_triple(factors, k + ONE), load_pair(x, rows[k + ONE])
        c, d = minus_parts(c, factor, entry), minus_parts(d, factor, exchanged(entry))
        k = k + TWO
    if k < last:
        factor, entry = load_triple(factors, k), load_pair(x, rows[k])
        a, b = minus_parts(a, factor, entry), minus_parts(b, factor, exchanged(entry))
    return plus_parts(plus_parts(own, a, b), c, d)


@compiled
def subtract(rows: Array, factors: Array, x: Array, own: Any, first: Any, last: Any) -> None:
    """Subtract some factors times a pair from the entries of x at their rows."""
    along, across = straight(own), crossed(own)
    for k in range(first, last):
        store_pair(x, rows[k], minus_pair(load_pair(x, rows[k]), load_triple(factors, k), along, across))


@compiled
def solve_factors(pattern: Pattern, factors: Array, transposed: bool, x: Array) -> None:
    """Solve L U x = x or (L U)ᵀ x = x in place for both matrices.

    x has a pair for each row, factors three numbers for each entry.
    """
    n: Any = np.uint64(len(pattern.diagonal))
    pointers, rows, diagonal = pattern.pointers, pattern.rows, pattern.diagonal
    for j in range(n):
        own = load_pair(x, j)
        if transposed:
            own = lessened(rows, factors, x, own, pointers[j], diagonal[j])
            inverse = load_triple(factors, diagonal[j])
            store_pair(x, j, pair_product(own, straight(inverse), crossed(inverse)))
        else:
            subtract(rows, factors, x, own, diagonal[j] + ONE, pointers[j + ONE])
    for back in range(n):
        j = n - ONE - back
        own = load_pair(x, j)
        if transposed:
            store_pair(x, j, lessened(rows, factors, x, own, diagonal[j] + ONE, pointers[j + ONE]))
        else:
            inverse = load_triple(factors, diagonal[j])
            own = pair_product(own, straight(inverse), crossed(inverse))
            store_pair(x, j, own)
            subtract(rows, factors, x, own, pointers[j], diagonal[j])


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
                x[4 * k + i] = way.enter[i, 0] * r0 + way.enter[i, 1] * r1 + way.enter[i, 2] * r2
            x[4 * k + 3] = 0.0
        solve_factors(split.pattern, factors, transposed, x)
        for k in range(n):
            j, w0, w1, w2 = way.target[k], x[4 * k], x[4 * k + 1], x[4 * k + 2]
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
    for with the transpose only. `changes` is a buffer (k,), as are `buffers`, the first one of pairs.
    """
    scratch, rest, change = buffers[0], buffers[1][: len(right)], buffers[2][: len(right)]
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
