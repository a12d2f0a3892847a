"""Six numbers, or a matrix of six by six, for the three translations and three rotations of a frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from ..errors import ModelError
from ..quantity import is_list, numbers, plain
from ..tape import values_of

Vector6: TypeAlias = Sequence[float] | tuple[float, ...]
Matrix6: TypeAlias = Sequence[float] | Sequence[Sequence[float]]
ROUND_OFF = 1e-9  # [-] of eigenvalues of a matrix with a diagonal of ones
_SIX = "Give six numbers, three translations and then three rotations."
_MATRIX = "Give six numbers for the diagonal, or six rows of six."


def vector6(value: Any, field: str) -> tuple[float, ...]:
    """Return ``value`` as six finite floats, or raise a ModelError about ``field``."""
    return numbers(value, 6, field, _SIX)


def dissipative6(value: Any, field: str) -> tuple[float, ...]:
    """Return a matrix whose quadratic form is never negative: no motion of any direction gets energy from it.

    Raises
    ------
    ModelError
        Otherwise; also for a direction without a number of its own that is coupled to others.
    """
    entries = matrix6(value, field)
    whole = values_of(np.array(entries, dtype=object)).reshape(6, 6)
    symmetric = 0.5 * (whole + whole.T)
    own = np.diag(symmetric)
    sizes = np.sqrt(np.where(own > 0, own, 1.0))  # one unit for forces and torques
    least = float(np.linalg.eigvalsh(symmetric / np.outer(sizes, sizes))[0])
    coupled = np.any(abs(symmetric[own == 0]) > 0)
    if np.any(own < 0) or coupled or least < -ROUND_OFF:
        raise ModelError(
            f"{field} is negative in some direction. Give numbers of at least 0, or a matrix without negative "
            "eigenvalues. Model what drives a motion by a force of its own.",
            field=field,
        )
    return entries


def matrix6(value: Any, field: str) -> tuple[float, ...]:
    """Return the 36 numbers of a matrix, row by row, given in full or by its diagonal."""
    if is_list(value) and len(value) == 6 and is_list(value[0]):
        return tuple(entry for row in value for entry in numbers(row, 6, field, _MATRIX))
    return tuple(plain(entry) for entry in np.diag(numbers(value, 6, field, _MATRIX)).flat)
