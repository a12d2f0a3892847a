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
def assemble_pairs_lanes(parts: Array, places: Array, weights: Array, values: Array, data: Array) -> None:
    """Sum the weighted numbers of all parts into those of a real and a complex matrix.

    weights : real, those of the real matrix, then real and imaginary parts of those of the complex one
    data : for each entry of the pattern the number of the real matrix, then the parts of that of the complex one
    """
    clear_lanes(data)
    count: Any = np.uint64(len(parts))
    for s in range(count):
        first, size, at = parts[s, 0], parts[s, 1], parts[s, 2]
        a, b, c = load(weights, s), load(weights, count + s), load(weights, TWO * count + s)
        for k in range(size):
            value, to = load(values, first + k), places[at + k] * THREE
            store(data, to, plus_product(load(data, to), a, value))
            store(data, to + ONE, plus_product(load(data, to + ONE), b, value))
            store(data, to + TWO, plus_product(load(data, to + TWO), c, value))


@compiled
def subtract_pair(x: Array, k: Any, factors: Array, entry: Any, w: Any, u: Any, v: Any) -> None:
    """Entry k of x -= a real factor times w, and a complex one times u + i v."""
    at, of = k * THREE, entry * THREE
    re, im = load(factors, of + ONE), load(factors, of + TWO)
    store(x, at, minus_product(load(x, at), load(factors, of), w))
    store(x, at + ONE, plus_product(minus_product(load(x, at + ONE), re, u), im, v))
    store(x, at + TWO, minus_product(minus_product(load(x, at + TWO), re, v), im, u))


@compiled
def factor_pairs_lanes(pattern: Pattern, data: Array, factors: Array, work: Array) -> None:
    """Factor a real and a complex matrix of one pattern, two columns of a panel at a time.

    Of every entry the real number and the parts of the complex one are neighbours: both matrices share places.
    """
    pointers, rows, diagonal, ends = pattern.pointers, pattern.rows, pattern.diagonal, pattern.ends
    indptr, indices = pattern.indptr, pattern.indices
    zero, one = fill(0.0), fill(1.0)
    for j in range(np.uint64(len(diagonal))):
        start, middle, end = pointers[j], diagonal[j], pointers[j + ONE]
        for entry in range(start, end):
            to = rows[entry] * THREE
            store(work, to, zero)
            store(work, to + ONE, zero)
            store(work, to + TWO, zero)
        for place in range(indptr[j], indptr[j + ONE]):
            to = indices[place] * THREE
            store(work, to, load(data, place * THREE))
            store(work, to + ONE, load(data, place * THREE + ONE))
            store(work, to + TWO, load(data, place * THREE + TWO))
        entry = start
        while entry < middle:
            k = rows[entry]
            w, u, v = load(work, k * THREE), load(work, k * THREE + ONE), load(work, k * THREE + TWO)
            store(factors, entry * THREE, w)
            store(factors, entry * THREE + ONE, u)
            store(factors, entry * THREE + TWO, v)
            entry, first, end_of_column = entry + ONE, diagonal[k] + ONE, pointers[k + ONE]
            if k + ONE < min(ends[k], j):
                k = k + ONE
                subtract_pair(work, k, factors, first, w, u, v)
                r, s, t = load(work, k * THREE), load(work, k * THREE + ONE), load(work, k * THREE + TWO)
                store(factors, entry * THREE, r)
                store(factors, entry * THREE + ONE, s)
                store(factors, entry * THREE + TWO, t)
                entry, first, second = entry + ONE, first + ONE, diagonal[k] + ONE
                for i in range(end_of_column - first):
                    at, p, q = rows[first + i] * THREE, (first + i) * THREE, (second + i) * THREE
                    z = minus_product(load(work, at), load(factors, p), w)
                    store(work, at, minus_product(z, load(factors, q), r))
                    a, b = load(factors, p + ONE), load(factors, p + TWO)
                    c, d = load(factors, q + ONE), load(factors, q + TWO)
                    x = plus_product(minus_product(load(work, at + ONE), a, u), b, v)
                    y = minus_product(minus_product(load(work, at + TWO), a, v), b, u)
                    store(work, at + ONE, plus_product(minus_product(x, c, s), d, t))
                    store(work, at + TWO, minus_product(minus_product(y, c, t), d, s))
            else:
                for below in range(first, end_of_column):
                    subtract_pair(work, rows[below], factors, below, w, u, v)
        w, u, v = load(work, j * THREE), load(work, j * THREE + ONE), load(work, j * THREE + TWO)
        size = plus_product(product(u, u), v, v)
        w, u, v = ratio(one, w), ratio(u, size), ratio(minus_product(zero, v, one), size)
        store(factors, middle * THREE, w)
        store(factors, middle * THREE + ONE, u)
        store(factors, middle * THREE + TWO, v)
        for entry in range(middle + ONE, end):
            at = rows[entry] * THREE
            a, b = load(work, at + ONE), load(work, at + TWO)
            store(factors, entry * THREE, product(load(work, at), w))
            store(factors, entry * THREE + ONE, minus_product(product(a, u), b, v))
            store(factors, entry * THREE + TWO, plus_product(product(a, v), b, u))


@compiled
def turn_lanes(sheet: Array, count: int, turned: Array, stride: int, to: int) -> None:
    """Entries of an array in lanes, multiples of their number, to stretches of an array, one for each lane."""
    step: Any = np.uint64(stride)
    target = turned[to:]
    for k in range(np.uint64(0), np.uint64(count), WIDE):
        turn(sheet, k, target, step)
