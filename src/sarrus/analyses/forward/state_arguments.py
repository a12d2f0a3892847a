"""Vectors and numbers of a state as compiled functions take them."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

from ...algebra import Array


def vector(name: str, x: Any, *shapes: tuple[int, ...]) -> Array:
    """A contiguous array of floats; a read-only one as a copy: compiled code has one type of arrays.

    Raises
    ------
    TypeError
        For what is not made of real numbers.
    ValueError
        If it has another shape.
    """
    try:
        given = np.asarray(x)
        if given.dtype.kind not in "biuf":
            raise TypeError
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be real numbers, got {x!r:.60}. Pass a vector of floats.") from None
    if given.shape not in shapes:
        allowed = " or ".join(map(str, shapes))
        raise ValueError(
            f"{name} must have shape {allowed}, got {given.shape}. Pass a vector of this length."
        )
    found = np.ascontiguousarray(given, dtype=float)
    return found if found.flags.writeable else found.copy()


def number(name: str, value: Any) -> float:
    """A finite float.

    Raises
    ------
    TypeError
        For what is not one real number.
    ValueError
        If it is not finite.
    """
    if type(value) is not float:
        given = None if isinstance(value, str) or np.iscomplexobj(value) else value
        try:
            value = float(given)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            raise TypeError(f"{name} must be a number, got {value!r:.60}. Pass a float.") from None
    if not isfinite(value):
        raise ValueError(f"{name} must be finite, got {value}. Pass a finite number.")
    return float(value)


def refuse_no_inputs(u: Any) -> None:
    """Refuse values of inputs without names.

    Raises
    ------
    TypeError
    """
    if type(u) is not dict and not isinstance(u, Mapping):
        raise TypeError(
            f"u must be values of inputs by name, got {u!r:.60}. Pass a mapping such as {{'u': 1.0}}."
        )
