"""LU factors of a real and a complex matrix of one pattern and one order of pivots, at once. (Compiled functions.)

Storage is that of `sparse_lu`, with four numbers for every entry, see `_jit.kernels.pairs`; in place of pivots, their
inverses. Of neighbouring columns of L with the same rows, a panel, two are subtracted at a time.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._jit.kernels.pairs import (
    crossed,
    load_pair,
    minus_pair,
    pair,
    pair_product,
    plus_multiple,
    store_pair,
    straight,
)
from .._jit.linking.link import compiled
from ..algebra import Array

ONE: Any = np.uint64(1)
TWO: Any = np.uint64(2)
FOUR: Any = np.uint64(4)


class PairFactors(NamedTuple):
    """Factors of both matrices, in the order of the pivots.

    pointers, rows, diagonal : see `sparse_lu`
    ends : of panels, see `panel_loop.panel_ends`
    scale : powers of two by which rows are multiplied where pivots are compared
    factors, work : four numbers for every entry and every row
    """

    pointers: Array
    rows: Array
    diagonal: Array
    ends: Array
    scale: Array
    factors: Array
    work: Array


@compiled
def assemble_pairs(parts: Array, places: Array, weights: Array, values: Array, data: Array) -> None:
    """Sum the numbers of all parts, weighted by pairs, as `equations.block_matrix.assemble` does."""
    data[:] = 0.0
    for s in range(np.uint64(len(parts))):
        first, count, at = np.uint64(parts[s, 0]), np.uint64(parts[s, 1]), np.uint64(parts[s, 2])
        weight = load_pair(weights, s)
        for k in range(count):
            to = np.uint64(places[at + k])
            store_pair(data, to, plus_multiple(load_pair(data, to), weight, values[first + k]))


@compiled
def subtract_columns(lu: PairFactors, x: Array, k: Any, pair_up: bool) -> Any:
    """Subtract from x what column k of L, or also the next one, contributes; returns how many columns.

    With two columns, x of the second one is what the first one leaves of it.
    """
    rows, factors = lu.rows, lu.factors
    u = load_pair(x, k)
    along, across = straight(u), crossed(u)
    first, last = np.uint64(lu.diagonal[k]) + ONE, np.uint64(lu.pointers[k + ONE])
    if not pair_up:
        for entry in range(first, last):
            row = np.uint64(rows[entry])
            store_pair(x, row, minus_pair(load_pair(x, row), load_pair(factors, entry), along, across))
        return ONE
    u = minus_pair(load_pair(x, k + ONE), load_pair(factors, first), along, across)
    store_pair(x, k + ONE, u)
    along_next, across_next = straight(u), crossed(u)
    first, second = first + ONE, np.uint64(lu.diagonal[k + ONE]) + ONE
    for i in range(last - first):
        row = np.uint64(rows[first + i])
        rest = minus_pair(load_pair(x, row), load_pair(factors, first + i), along, across)
        store_pair(x, row, minus_pair(rest, load_pair(factors, second + i), along_next, across_next))
    return TWO


@compiled
def refactor_pairs(lu: PairFactors) -> float:
    """Factor both matrices in place; returns the least of what `sparse_lu.refactor` returns for each."""
    pointers, rows, diagonal, factors, work = lu.pointers, lu.rows, lu.diagonal, lu.factors, lu.work
    worst = 1.0
    for j in range(np.uint64(len(diagonal))):
        start, middle, end = np.uint64(pointers[j]), np.uint64(diagonal[j]), np.uint64(pointers[j + ONE])
        for entry in range(start, end):
            store_pair(work, np.uint64(rows[entry]), load_pair(factors, entry))
        at: Any = start
        while at < middle:
            k = np.uint64(rows[at])
            count = subtract_columns(lu, work, k, k + ONE < min(np.uint64(lu.ends[k]), j))
            for i in range(count):
                store_pair(factors, at + i, load_pair(work, k + i))
            at = at + count
        trust = trust_in_pivot(lu, j)
        if not trust > 0.0:
            return 0.0
        worst = min(worst, trust)
        inverse = inverse_of(work[FOUR * j], work[FOUR * j + ONE], work[FOUR * j + TWO])
        along, across = straight(inverse), crossed(inverse)
        store_pair(factors, middle, inverse)
        for entry in range(middle + ONE, end):
            store_pair(factors, entry, pair_product(load_pair(work, np.uint64(rows[entry])), along, across))
    return worst


@compiled
def trust_in_pivot(lu: PairFactors, j: Any) -> float:
    """Size of the pivots of column j in `work`, over the largest entries below them; zero if one is zero or none."""
    scale, work, rows = lu.scale, lu.work, lu.rows
    real = scale[j] * abs(work[FOUR * j])
    other = scale[j] * (abs(work[FOUR * j + ONE]) + abs(work[FOUR * j + TWO]))
    largest, largest_other = real, other
    for entry in range(np.uint64(lu.diagonal[j]) + ONE, np.uint64(lu.pointers[j + ONE])):
        row = np.uint64(rows[entry])
        at, unit = FOUR * row, scale[row]
        largest = max(largest, unit * abs(work[at]))
        largest_other = max(largest_other, unit * (abs(work[at + ONE]) + abs(work[at + TWO])))
    if not (real > 0.0 and other > 0.0):
        return 0.0
    return float(min(real / largest, other / largest_other))


@compiled
def inverse_of(real: float, re: float, im: float) -> Any:
    """One over both numbers; the larger part of the complex one is divided by, so that no square overflows."""
    if abs(re) >= abs(im):
        ratio = im / re
        size = re + im * ratio
        return pair(1.0 / real, 1.0 / size, -ratio / size)
    ratio = re / im
    size = im + re * ratio
    return pair(1.0 / real, ratio / size, -1.0 / size)


@compiled
def solve_pairs(lu: PairFactors, x: Array) -> None:
    """Solve L U x = x in place, for both matrices."""
    n: Any = np.uint64(len(lu.diagonal))
    k: Any = np.uint64(0)
    while k < n:
        k = k + subtract_columns(lu, x, k, k + ONE < np.uint64(lu.ends[k]))
    while k > np.uint64(0):
        k = k - ONE
        middle = np.uint64(lu.diagonal[k])
        inverse = load_pair(lu.factors, middle)
        u = pair_product(load_pair(x, k), straight(inverse), crossed(inverse))
        store_pair(x, k, u)
        along, across = straight(u), crossed(u)
        for entry in range(np.uint64(lu.pointers[k]), middle):
            row = np.uint64(lu.rows[entry])
            store_pair(x, row, minus_pair(load_pair(x, row), load_pair(lu.factors, entry), along, across))
