"""Vectors and numbers of a state as compiled functions take them."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any, TypeAlias

import numpy as np

from ...algebra import Array

InputValues: TypeAlias = Mapping[str, float] | None  # by name, or those of the system


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
        numbers = np.asarray(x)
        if numbers.dtype.kind not in "biuf":
            raise TypeError
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be real numbers, got {x!r:.60}. Pass a vector of floats.") from None
    if numbers.shape not in shapes:
        allowed = " or ".join(map(str, shapes))
        raise ValueError(
            f"{name} must have shape {allowed}, got {numbers.shape}. Pass a vector of this length."
        )
    return np.require(numbers, float, ("C", "W"))


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
        real = None if isinstance(value, str) or np.iscomplexobj(value) else value
        try:
            value = float(real)  # type: ignore[arg-type]
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
