"""Powers of two by which rows and columns of a matrix of operators are multiplied, so that units do not matter.

The unknowns of such a matrix are changes of coordinates, in metres and Euler parameters, and of multipliers. Pivots
chosen by the numbers as they are would depend on the units in which a model is written. Displacements are measured in
a length of the system, each equation of Φ by its gradient; then blocks of rows and of columns are scaled so that the
largest entries of M, Φ_q and unit matrices are near 1. Powers of two leave all digits as they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from ...algebra import Array

COORDINATES, CONSTRAINTS = "coordinates", "constraints"


class Block(NamedTuple):
    """Sizes of the numbers of M, Φ_q or W: where it begins, kinds of its rows and columns, places in it."""

    row: int
    column: int
    kinds: tuple[str, str]
    rows: Array
    columns: Array
    sizes: Array


def exponents(n: int, blocks: list[Block], size: Mapping[str, int]) -> tuple[Array, Array]:
    """Exponents of two of all rows and columns of a matrix (n, n); `size` is that of each kind of block."""
    scale = _within_blocks(blocks, size)
    rows, columns = np.zeros(n, np.int64), np.zeros(n, np.int64)
    edges = [(one.row, one.column, _largest(one, scale)) for one in blocks]
    of_rows, of_columns = _of_blocks([edge for edge in edges if edge[2] is not None])  # type: ignore[misc]
    for one in blocks:
        for to, at, own, kind, of in (
            (rows, one.row, one.rows, one.kinds[0], of_rows),
            (columns, one.column, one.columns, one.kinds[1], of_columns),
        ):
            if len(own):  # a block may have only some equations
                first, end = int(own.min()), int(own.max()) + 1
                to[at + first : at + end] = scale[kind][first:end] + of.get(at, 0)
    return rows, columns


def _within_blocks(blocks: list[Block], size: Mapping[str, int]) -> dict[str, Array]:
    """Exponents of coordinates, by the length, and of equations, by the largest number of their gradients."""
    coordinates = np.where(np.arange(size[COORDINATES]) % 7 < 3, length_exponent(blocks), 0)
    largest = np.zeros(size[CONSTRAINTS])
    for one in blocks:
        if CONSTRAINTS in one.kinds:
            rows, columns = (one.rows, one.columns)[:: 1 if one.kinds[0] == CONSTRAINTS else -1]
            np.maximum.at(largest, rows, np.ldexp(one.sizes, coordinates[columns]))
    return {COORDINATES: coordinates, CONSTRAINTS: np.where(largest > 0, -np.frexp(largest)[1], 0)}


def length_exponent(blocks: Iterable[Block]) -> int:
    """Exponent of a length: the larger of a radius of gyration, by the largest numbers of M, and a lever of Φ_q."""
    length = 0.0
    for one in blocks:
        if one.kinds == (COORDINATES, COORDINATES) and np.any(one.rows != one.columns):
            alike = (one.rows % 7 >= 3) == (one.columns % 7 >= 3)
            together = np.zeros(int(alike.sum()), np.int64)
            length = max(length, float(np.sqrt(_ratio(one.columns[alike], one.sizes[alike], together))))
        elif CONSTRAINTS in one.kinds and COORDINATES in one.kinds:
            equations, at = (one.rows, one.columns)[:: 1 if one.kinds[0] == CONSTRAINTS else -1]
            length = max(length, _ratio(at, one.sizes, equations))
    return int(np.frexp(length)[1]) if length > 0 else 0


def _ratio(at: Array, sizes: Array, equations: Array) -> float:
    """The largest number of an equation that belongs to a rotation over the largest that belongs to a displacement.

    Equations without displacements have no length.
    """
    turning, moving = np.zeros((2, int(equations.max(initial=0)) + 1))
    np.maximum.at(turning, equations, np.where(at % 7 >= 3, sizes, 0.0))
    np.maximum.at(moving, equations, np.where(at % 7 < 3, sizes, 0.0))
    return float(np.divide(turning, moving, out=np.zeros_like(moving), where=moving > 0).max(initial=0.0))


def _largest(one: Block, scale: Mapping[str, Array]) -> int | None:
    """Exponent of the largest number of a block; None if all are zero."""
    by = scale[one.kinds[0]][one.rows] + scale[one.kinds[1]][one.columns]
    found = float(np.ldexp(one.sizes, by).max(initial=0.0))
    return int(np.frexp(found)[1]) if found > 0 else None


def _of_blocks(edges: list[tuple[int, int, int]]) -> tuple[dict[int, int], dict[int, int]]:
    """Exponents of blocks of rows and of columns with which the largest numbers of a tree of blocks are near 1."""
    rows: dict[int, int] = {}
    columns: dict[int, int] = {}
    for _, start, _ in edges:
        if start in columns:
            continue
        columns[start], grew = 0, True
        while grew:
            grew = False
            for row, column, size in edges:
                if (row in rows) != (column in columns):
                    grew = True
                    if row in rows:
                        columns[column] = -size - rows[row]
                    else:
                        rows[row] = -size - columns[column]
    return rows, columns
