"""3- and 4-vectors and blocks, as NumPy arrays of any kind of number: floats, fractions, complex or recorded ones.

No physics. Whole numbers stay whole, so that a polynomial kernel stays exact on exact numbers.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]
Block: TypeAlias = "Array | None"
Row: TypeAlias = "tuple[Block, ...]"

I3: Array = np.eye(3, dtype=int)
I4: Array = np.eye(4, dtype=int)


def skew(a: Array) -> Array:
    """The matrix ã with ã b = a x b. Eq. (8)."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def cross(a: Array, b: Array) -> Array:
    """Vector product a x b."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def outer(a: Array, b: Array) -> Array:
    """Dyadic product a bᵀ."""
    return a[:, None] * b[None, :]


def stack(rows: Iterable[Iterable[Array]]) -> Array:
    """A matrix from rows of blocks."""
    return np.concatenate([np.concatenate(list(row), axis=1) for row in rows])


def row(a: Array) -> Array:
    """A vector as a matrix of one row."""
    return a[None, :]


def column(a: Array) -> Array:
    """A vector as a matrix of one column."""
    return a[:, None]


def single(value: Any) -> Array:
    """A number as a 1x1 block."""
    return np.array([[value]])


def present(block: Block) -> Array:
    """A block that is known not to be zero."""
    assert block is not None
    return block


def total(terms: Iterable[Block]) -> Block:
    """Sum of blocks, None standing for zero."""
    result: Block = None
    for term in terms:
        if term is not None:
            result = term if result is None else result + term
    return result


def times(block: Block, a: Array) -> Block:
    """Block times vector, None standing for zero."""
    return None if block is None else block @ a


def scaled(factor: Any, block: Block) -> Block:
    """Number times block, None standing for zero."""
    return None if block is None else factor * block
