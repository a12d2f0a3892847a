"""Matrices of one pattern assembled and factored at once, one in every lane. (Functions that are compiled.)

In arrays "in lanes" every entry is as many numbers as there are lanes, side by side. Factors are those of `panel_loop`;
no pivot is looked at: where one fails, so does the refinement of a solution.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .._jit.kernels.lanes import fill, load, minus_product, plus_product, product, ratio, store, turn
from .._jit.kernels.vector import LANES
from .._jit.linking.link import compiled
from ..algebra import Array
from .panel_loop import Pattern

ONE: Any = np.uint64(1)
TWO: Any = np.uint64(2)
THREE: Any = np.uint64(3)
WIDE: Any = np.uint64(LANES)


@compiled
def clear_lanes(x: Array) -> None:
    """x = 0, in lanes."""
    zero = fill(0.0)
    for k in range(np.uint64(len(x)) // WIDE):
        store(x, k, zero)


@compiled
def assemble_lanes(parts: Array, places: Array, weights: Array, values: Array, data: Array) -> None:
    """Sum the weighted numbers of all parts into the numbers of a matrix, as `equations.block_matrix.assemble` does."""
    clear_lanes(data)
    for s in range(np.uint64(len(parts))):
        first, count, at, weight = parts[s, 0], parts[s, 1], parts[s, 2], load(weights, s)
        for k in range(count):
            place = places[at + k]
            store(data, place, plus_product(load(data, place), weight, load(values, first + k)))


@compiled
def factor_lanes(pattern: Pattern, data: Array, factors: Array, work: Array, growth: Array) -> None:
    """Factor, three columns of a panel at a time; all but places are in lanes.

    growth : takes the sum of the squares of L, by which pivots that do not suit are noticed
    """
    pointers, rows, diagonal, ends = pattern.pointers, pattern.rows, pattern.diagonal, pattern.ends
    indptr, indices = pattern.indptr, pattern.indices
    zero, one = fill(0.0), fill(1.0)
    grown = fill(1.0)
    for j in range(np.uint64(len(diagonal))):
        start, middle, end = pointers[j], diagonal[j], pointers[j + ONE]
        for entry in range(start, end):
            store(work, rows[entry], zero)
        for place in range(indptr[j], indptr[j + ONE]):
            store(work, indices[place], load(data, place))
        entry = start
        while entry < middle:
            k = rows[entry]
            behind = min(ends[k], j)
            base = diagonal[behind - ONE] + ONE
            size = pointers[behind] - base
            while k + TWO < behind:
                u0 = load(work, k)
                first, second, third = diagonal[k] + ONE, diagonal[k + ONE] + ONE, diagonal[k + TWO] + ONE
                u1 = minus_product(load(work, k + ONE), load(factors, first), u0)
                u2 = minus_product(load(work, k + TWO), load(factors, first + ONE), u0)
                u2 = minus_product(u2, load(factors, second), u1)
                store(factors, entry, u0)
                store(factors, entry + ONE, u1)
                store(factors, entry + TWO, u2)
                k, entry, first, second = k + THREE, entry + THREE, first + TWO, second + ONE
                for i in range(behind - k):
                    x = minus_product(load(work, k + i), load(factors, first + i), u0)
                    x = minus_product(x, load(factors, second + i), u1)
                    store(work, k + i, minus_product(x, load(factors, third + i), u2))
                first, second, third = first + (behind - k), second + (behind - k), third + (behind - k)
                for i in range(size):
                    row = rows[base + i]
                    x = minus_product(load(work, row), load(factors, first + i), u0)
                    x = minus_product(x, load(factors, second + i), u1)
                    store(work, row, minus_product(x, load(factors, third + i), u2))
            if k + ONE < behind:
                u0 = load(work, k)
                first, second = diagonal[k] + ONE, diagonal[k + ONE] + ONE
                u1 = minus_product(load(work, k + ONE), load(factors, first), u0)
                store(factors, entry, u0)
                store(factors, entry + ONE, u1)
                k, entry, first = k + TWO, entry + TWO, first + ONE
                for i in range(behind - k):
                    x = minus_product(load(work, k + i), load(factors, first + i), u0)
                    store(work, k + i, minus_product(x, load(factors, second + i), u1))
                first, second = first + (behind - k), second + (behind - k)
                for i in range(size):
                    row = rows[base + i]
                    x = minus_product(load(work, row), load(factors, first + i), u0)
                    store(work, row, minus_product(x, load(factors, second + i), u1))
            while k < behind:
                u0 = load(work, k)
                store(factors, entry, u0)
                for i in range(diagonal[k] + ONE, pointers[k + ONE]):
                    store(work, rows[i], minus_product(load(work, rows[i]), load(factors, i), u0))
                k, entry = k + ONE, entry + ONE
        inverse = ratio(one, load(work, j))
        store(factors, middle, inverse)
        for entry in range(middle + ONE, end):
            x = product(load(work, rows[entry]), inverse)
            grown = plus_product(grown, x, x)
            store(factors, entry, x)
    store(growth, 0, grown)


@compiled
def subtract_complex(x: Array, k: Any, factors: Array, entry: Any, u: Any, v: Any) -> None:
    """Entry k of x -= a factor times u + i v; real and imaginary parts are neighbours."""
    at, re, im = k * TWO, load(factors, entry * TWO), load(factors, entry * TWO + ONE)
    store(x, at, plus_product(minus_product(load(x, at), re, u), im, v))
    store(x, at + ONE, minus_product(minus_product(load(x, at + ONE), re, v), im, u))


@compiled
def factor_complex_lanes(pattern: Pattern, data: Array, factors: Array, work: Array) -> None:
    """Factor complex matrices, two columns of a panel at a time: the parts of an entry are neighbours."""
    pointers, rows, diagonal, ends = pattern.pointers, pattern.rows, pattern.diagonal, pattern.ends
    indptr, indices = pattern.indptr, pattern.indices
    zero, one = fill(0.0), fill(1.0)
    for j in range(np.uint64(len(diagonal))):
        start, middle, end = pointers[j], diagonal[j], pointers[j + ONE]
        for entry in range(start, end):
            store(work, rows[entry] * TWO, zero)
            store(work, rows[entry] * TWO + ONE, zero)
        for place in range(indptr[j], indptr[j + ONE]):
            store(work, indices[place] * TWO, load(data, place * TWO))
            store(work, indices[place] * TWO + ONE, load(data, place * TWO + ONE))
        entry = start
        while entry < middle:
            k = rows[entry]
            u, v = load(work, k * TWO), load(work, k * TWO + ONE)
            store(factors, entry * TWO, u)
            store(factors, entry * TWO + ONE, v)
            entry, first, end_of_column = entry + ONE, diagonal[k] + ONE, pointers[k + ONE]
            if k + ONE < min(ends[k], j):
                k = k + ONE
                subtract_complex(work, k, factors, first, u, v)
                s, t = load(work, k * TWO), load(work, k * TWO + ONE)
                store(factors, entry * TWO, s)
                store(factors, entry * TWO + ONE, t)
                entry, first, second = entry + ONE, first + ONE, diagonal[k] + ONE
                for i in range(end_of_column - first):
                    at = rows[first + i] * TWO
                    a, b = load(factors, (first + i) * TWO), load(factors, (first + i) * TWO + ONE)
                    c, d = load(factors, (second + i) * TWO), load(factors, (second + i) * TWO + ONE)
                    x = plus_product(minus_product(load(work, at), a, u), b, v)
                    y = minus_product(minus_product(load(work, at + ONE), a, v), b, u)
                    store(work, at, plus_product(minus_product(x, c, s), d, t))
                    store(work, at + ONE, minus_product(minus_product(y, c, t), d, s))
            else:
                for below in range(first, end_of_column):
                    subtract_complex(work, rows[below], factors, below, u, v)
        u, v = load(work, j * TWO), load(work, j * TWO + ONE)
        size = plus_product(product(u, u), v, v)
        u, v = ratio(u, size), ratio(minus_product(zero, v, one), size)
        store(factors, middle * TWO, u)
        store(factors, middle * TWO + ONE, v)
        for entry in range(middle + ONE, end):
            a, b = load(work, rows[entry] * TWO), load(work, rows[entry] * TWO + ONE)
            store(factors, entry * TWO, minus_product(product(a, u), b, v))
            store(factors, entry * TWO + ONE, plus_product(product(a, v), b, u))


@compiled
def turn_lanes(sheet: Array, count: int, turned: Array, stride: int, to: int) -> None:
    """Entries of an array in lanes, multiples of their number, to stretches of an array, one for each lane."""
    step: Any = np.uint64(stride)
    target = turned[to:]
    for k in range(np.uint64(0), np.uint64(count), WIDE):
        turn(sheet, k, target, step)
