"""Where do arrays in lanes, and panels of columns, have their room? Where the memory is read fastest."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod

import numpy as np

from ..._jit.vector import LANES
from ...algebra import Array

LINE = 64  # bytes that are read at once


def aligned(*shape: int) -> Array:
    """Zeros that begin where a line of the memory does."""
    size = prod(shape)
    found = np.zeros(size + LINE // 8)
    first = -found.ctypes.data % LINE // 8
    return found[first : first + size].reshape(shape)


def room(entries: int, *rows: int) -> Array:
    """Zeros in lanes."""
    return aligned(*rows, entries * LANES)


def rooms(entries: Mapping[str, int]) -> dict[str, Array]:
    """Zeros in lanes, of several names one after another."""
    whole, found, first = room(sum(entries.values())), {}, 0
    for name, count in entries.items():
        found[name] = whole[first * LANES : (first + count) * LANES]
        first += count
    return found
