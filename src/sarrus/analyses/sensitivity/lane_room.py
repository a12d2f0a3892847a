"""Where do arrays in lanes, and panels of columns, have their room? Where the memory is read fastest."""

from __future__ import annotations

import numpy as np

from ..._jit.vector import LANES
from ...algebra import Array

LINE = 64  # bytes that are read at once


def aligned(*shape: int) -> Array:
    """Zeros that begin where a line of the memory does."""
    size = int(np.prod(shape))
    found = np.zeros(size + LINE // 8)
    first = -found.ctypes.data % LINE // 8
    return found[first : first + size].reshape(shape)


def room(entries: int, *rows: int) -> Array:
    """Zeros in lanes."""
    return aligned(*rows, entries * LANES)
