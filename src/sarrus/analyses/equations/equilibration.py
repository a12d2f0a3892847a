"""Powers of two by which rows and columns of a matrix of operators are multiplied, so that units do not matter.

The unknowns of such a matrix are changes of coordinates, in metres and Euler parameters, and of multipliers. Pivots
chosen by the numbers as they are would depend on the units in which a model is written. Displacements are measured in
a length of the system, each equation of Φ by its gradient; then blocks of rows and of columns are scaled so that the
largest entries of M, Φ_q and unit matrices are near 1. Powers of two leave all digits as they are. Compiled functions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._jit.linking.link import compiled
from ...algebra import Array

BETWEEN_COORDINATES, GRADIENT, TRANSPOSED = 0, 1, 2  # kinds of blocks: M and unit matrices, Φ_q, Φ_qᵀ


class Blocks(NamedTuple):
    """The blocks M, Φ_q and W of a matrix, and the places of their numbers.

    part, kind : (blocks,) which part of the matrix each is, and its kind
    row, column : (blocks,) where each begins in the matrix
    bounds : (blocks + 1,) where the numbers of each begin
    rows, columns : places of all numbers in their blocks
    is_length : which coordinates are displacements (nq,)
    """

    part: Array
    kind: Array
    row: Array
    column: Array
    bounds: Array
    rows: Array
    columns: Array
    is_length: Array


class Sizes(NamedTuple):
    """The numbers of operators, of each part the place of the first of them, and its weight, which is not negative."""

    values: Array
    first: Array
    weights: Array


@compiled
def size_of(blocks: Blocks, sizes: Sizes, n: int, k: int) -> float:
    """The size of number k, of block n."""
    part = blocks.part[n]
    return float(sizes.weights[part] * abs(sizes.values[sizes.first[part] + k - blocks.bounds[n]]))


@compiled
def length_exponent(blocks: Blocks, sizes: Sizes, turning: Array, moving: Array) -> int:
    """Exponent of a length: the larger of a radius of gyration, by the largest numbers of M, and a lever of Φ_q.

    A lever is the largest number of an equation that belongs to a rotation over the largest that belongs to a
    displacement; equations without displacements have no length.
    """
    length = 0.0
    for n in range(len(blocks.part)):
        turning[:], moving[:], diagonal = 0.0, 0.0, True
        for k in range(blocks.bounds[n], blocks.bounds[n + 1]):
            row, column, size = blocks.rows[k], blocks.columns[k], size_of(blocks, sizes, n, k)
            if blocks.kind[n] == BETWEEN_COORDINATES:
                diagonal = diagonal and row == column
                if blocks.is_length[row] != blocks.is_length[column]:
                    continue
                equation, at = 0, column
            elif blocks.kind[n] == GRADIENT:
                equation, at = row, column
            else:
                equation, at = column, row
            if blocks.is_length[at]:
                moving[equation] = max(moving[equation], size)
            else:
                turning[equation] = max(turning[equation], size)
        ratio = 0.0
        for k in range(len(moving)):
            if moving[k] > 0.0:
                ratio = max(ratio, turning[k] / moving[k])
        if blocks.kind[n] != BETWEEN_COORDINATES:
            length = max(length, ratio)
        elif not diagonal:
            length = max(length, math.sqrt(ratio))
    return math.frexp(length)[1] if length > 0.0 else 0


@compiled
def equation_exponents(
    blocks: Blocks, sizes: Sizes, of_length: int, largest: Array, exponents: Array
) -> None:
    """Exponents of equations, by the largest number of their gradients."""
    largest[:] = 0.0
    for n in range(len(blocks.part)):
        for k in range(blocks.bounds[n], blocks.bounds[n + 1]):
            equation, at = blocks.rows[k], blocks.columns[k]
            if blocks.kind[n] == TRANSPOSED:
                equation, at = at, equation
            if blocks.kind[n] != BETWEEN_COORDINATES:
                size = math.ldexp(size_of(blocks, sizes, n, k), of_length if blocks.is_length[at] else 0)
                largest[equation] = max(largest[equation], size)
    for k in range(len(exponents)):
        exponents[k] = -math.frexp(largest[k])[1] if largest[k] > 0.0 else 0


@compiled
def exponent_of(blocks: Blocks, place: int, constraint: bool, of_length: int, equations: Array) -> int:
    """Exponent of a row or a column within its block."""
    if constraint:
        return int(equations[place])
    return of_length if blocks.is_length[place] else 0


@compiled
def largest_exponents(blocks: Blocks, sizes: Sizes, of_length: int, equations: Array, edges: Array) -> None:
    """Exponent of the largest number of each block; 0 and a mark for those without any (2, blocks)."""
    for n in range(len(blocks.part)):
        largest = 0.0
        for k in range(blocks.bounds[n], blocks.bounds[n + 1]):
            by = exponent_of(blocks, blocks.rows[k], blocks.kind[n] == GRADIENT, of_length, equations)
            by += exponent_of(blocks, blocks.columns[k], blocks.kind[n] == TRANSPOSED, of_length, equations)
            largest = max(largest, math.ldexp(size_of(blocks, sizes, n, k), by))
        edges[0, n], edges[1, n] = math.frexp(largest)[1] if largest > 0.0 else 0, largest > 0.0


@compiled
def balance(blocks: Blocks, edges: Array, of_rows: Array, of_columns: Array) -> None:
    """Exponents of blocks of rows and of columns with which the largest numbers of a tree of blocks are near 1.

    They are stored where the blocks begin, with a mark (2, n).
    """
    for first in range(len(blocks.part)):
        if not edges[1, first] or of_columns[1, blocks.column[first]]:
            continue
        of_columns[1, blocks.column[first]], grew = 1, True
        while grew:
            grew = False
            for n in range(len(blocks.part)):
                row, column = blocks.row[n], blocks.column[n]
                if edges[1, n] and of_rows[1, row] != of_columns[1, column]:
                    grew = True
                    if of_rows[1, row]:
                        of_columns[0, column], of_columns[1, column] = -edges[0, n] - of_rows[0, row], 1
                    else:
                        of_rows[0, row], of_rows[1, row] = -edges[0, n] - of_columns[0, column], 1


@compiled(entry=True)
def exponents(blocks: Blocks, sizes: Sizes, m: int, rows: Array, columns: Array) -> None:
    """Write the exponents of two of all rows and columns of a matrix (n,); m is the number of constraints."""
    turning, moving, equations = np.zeros(max(m, 1)), np.zeros(max(m, 1)), np.zeros(m, np.int64)
    of_length = length_exponent(blocks, sizes, turning, moving)
    equation_exponents(blocks, sizes, of_length, turning, equations)
    edges, of_rows = np.zeros((2, len(blocks.part)), np.int64), np.zeros((2, len(rows)), np.int64)
    largest_exponents(blocks, sizes, of_length, equations, edges)
    of_columns = np.zeros((2, len(rows)), np.int64)
    balance(blocks, edges, of_rows, of_columns)
    for n in range(len(blocks.part)):
        row, column = blocks.row[n], blocks.column[n]
        for k in range(blocks.bounds[n], blocks.bounds[n + 1]):
            i, j = blocks.rows[k], blocks.columns[k]
            of_row = exponent_of(blocks, i, blocks.kind[n] == GRADIENT, of_length, equations)
            of_column = exponent_of(blocks, j, blocks.kind[n] == TRANSPOSED, of_length, equations)
            rows[row + i], columns[column + j] = of_row + of_rows[0, row], of_column + of_columns[0, column]
