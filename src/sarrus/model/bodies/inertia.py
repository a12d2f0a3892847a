"""The inertia of a rigid body about its centre of mass: three ways to give it, one checked answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..quantity import ROUND_OFF, Array, has_rows, number, numbers, plain
from ..show import quote, suggest
from ..tape import values_of

Inertia: TypeAlias = Sequence[float] | Sequence[Sequence[float]] | Mapping[str, float] | NDArray[np.float64]
Inertia6: TypeAlias = tuple[float, float, float, float, float, float]

ENTRIES = ("xx", "yy", "zz", "xy", "xz", "yz")
_FORMS = "Give 3 principal moments, {xx, yy, zz, xy, xz, yz}, or a symmetric 3x3 matrix, in kg m²."


def inertia_entries(inertia: Any) -> Inertia6:
    """Return (xx, yy, zz, xy, xz, yz), the entries of the tensor J′ in body axes. [kg m²]

    Off-diagonal entries are the tensor's own: ``xy`` is −∫ x y dm.

    Raises
    ------
    ModelError
        If J′ is not symmetric, not positive definite, or if its principal moments break the
        triangle inequality J1 + J2 ≥ J3, which holds for every distribution of mass.
    """
    J = _matrix(inertia)
    _check_symmetric(J)
    _check_principal([float(moment) for moment in np.linalg.eigvalsh(values_of(J))])
    xx, yy, zz, xy, xz, yz = (plain(J[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return xx, yy, zz, xy, xz, yz


def vanishes(inertia: Any) -> bool:
    """Return whether all entries are zero."""
    return not np.any(values_of(_matrix(inertia)))


def _matrix(inertia: Any) -> Array:
    if isinstance(inertia, Mapping):
        return _from_entries(inertia)
    if has_rows(inertia):
        return np.array([numbers(row, 3, "inertia", _FORMS) for row in inertia])
    return np.diag(numbers(inertia, 3, "inertia", _FORMS))


def _from_entries(given: Mapping[str, float]) -> Array:
    for key in given:
        if key not in ENTRIES:
            raise ModelError(f"inertia has no entry {quote(key)}. {suggest(key, ENTRIES)}", field="inertia")
    for key in ENTRIES[:3]:
        if key not in given:
            raise ModelError(f"inertia lacks the entry {key}. {_FORMS}", field="inertia")
    xx, yy, zz, xy, xz, yz = (number(given.get(key, 0.0), "inertia", _FORMS) for key in ENTRIES)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _check_symmetric(J: Array) -> None:
    if np.max(np.abs(J - J.T)) > ROUND_OFF * np.max(np.abs(J)):
        message = "inertia must be symmetric, but its entries above and below the diagonal differ"
        raise ModelError(f"{message}. {_FORMS}", field="inertia")


def _check_principal(moments: list[float]) -> None:
    least, middle, largest = moments
    message = f"its principal moments are {least:.6g}, {middle:.6g}, {largest:.6g}"
    if least <= 0 or not np.isfinite(largest):
        remedy = "Give a full body's inertia about its centre of mass in kg m²."
        raise ModelError(f"inertia must be positive definite, but {message}. {remedy}", field="inertia")
    if least + middle < largest * (1 - ROUND_OFF):
        remedy = "Check the numbers, no mass distribution has one moment above the sum of the others."
        raise ModelError(f"inertia breaks the triangle inequality, {message}. {remedy}", field="inertia")
