"""Six numbers, or a matrix of six by six, for the three translations and three rotations of a frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from .quantity import is_list, numbers, plain

Vector6: TypeAlias = Sequence[float] | tuple[float, ...]
Matrix6: TypeAlias = Sequence[float] | Sequence[Sequence[float]]
_SIX = "give six numbers, three translations and then three rotations"
_MATRIX = "give six numbers for the diagonal, or six rows of six"


def vector6(value: Any, field: str) -> tuple[float, ...]:
    """Return ``value`` as six finite floats, or raise a ModelError about ``field``."""
    return numbers(value, 6, field, _SIX)


def matrix6(value: Any, field: str) -> tuple[float, ...]:
    """Return the 36 numbers of a matrix, row by row, given in full or by its diagonal."""
    if is_list(value) and len(value) == 6 and is_list(value[0]):
        return tuple(entry for row in value for entry in numbers(row, 6, field, _MATRIX))
    return tuple(plain(entry) for entry in np.diag(numbers(value, 6, field, _MATRIX)).flat)
