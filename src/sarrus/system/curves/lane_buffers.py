"""Arrays in SIMD lanes, aligned in memory; large arrays take memory that was used before.

The system takes as long to provide and release fresh pages as a sweep takes to fill them, so large arrays reuse memory
that nothing refers to any more.
"""

from __future__ import annotations

import sys
from math import prod
from threading import Lock

import numpy as np

from ..._jit.kernels.vector import LANES
from ...algebra import Array

LINE = 64  # bytes that are read at once
SMALL, LARGE, MOST = (
    1 << 14,
    1 << 20,
    1 << 23,
)  # numbers: limits of stored arrays, and of all of them together
UNUSED = 3  # references to an array that only the list below holds, while it is looked at
_LENT: list[Array] = []
_LOOKING = Lock()


def used(*shape: int) -> Array:
    """An uninitialized array."""
    size = prod(shape) + LINE // 8
    found = _lent(-(-size // LINE) * LINE) if SMALL < size < LARGE else np.empty(size)
    first = -found.ctypes.data % LINE // 8
    return found[first : first + prod(shape)].reshape(shape)


def _lent(size: int) -> Array:
    with _LOOKING:
        for n in range(len(_LENT)):
            if len(_LENT[n]) == size and sys.getrefcount(_LENT[n]) < UNUSED:
                _LENT.append(_LENT.pop(n))
                return _LENT[-1]
        while _LENT and sum(map(len, _LENT)) + size > MOST:
            _LENT.pop(0)
        _LENT.append(np.empty(size))
        return _LENT[-1]


def aligned(*shape: int) -> Array:
    """Zeros aligned to a cache line."""
    found = used(*shape)
    found[...] = 0.0
    return found


def buffer(entries: int, *rows: int) -> Array:
    """Zeros in lanes."""
    return aligned(*rows, entries * LANES)
