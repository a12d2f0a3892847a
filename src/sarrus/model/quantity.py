"""The numbers that a person gives: checked once, returned as plain floats."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from math import isfinite
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .errors import ModelError
from .show import show
from .tape import Tracer, values_of

Vec3: TypeAlias = tuple[float, float, float]
Vector: TypeAlias = Sequence[float] | NDArray[np.float64]
Array: TypeAlias = NDArray[np.float64]

SLOWEST = 1e-100  # [m/s] the square of a smaller speed is not a number with all digits
LARGEST = 1e50  # beyond any quantity in SI units, and its cube is still a number
ROUND_OFF = 1e-9  # [-] of the largest number: what rounded numbers and computed ones may differ by
SMALLEST_LENGTH = 1e-12  # [m or -] below this a vector has no direction


class InputNumber(float):
    """The number of an input, by whose name its places among the parameters are found; NaN where it is not set."""

    name: str

    @classmethod
    def of(cls, name: str, value: Any) -> Any:
        """Mark a number; one that is traced stays as it is."""
        if isinstance(value, Tracer):
            return value
        found = cls(value)
        found.name = name
        return found


def number(value: Any, field: str, remedy: str = "Give one finite number.") -> float:
    """Return ``value`` as a finite float, or raise a ModelError about ``field``."""
    if type(value) is float and (value == 0.0 or sys.float_info.min <= abs(value) <= LARGEST):
        return value
    if isinstance(value, Tracer | InputNumber):
        return value  # type: ignore[return-value]  # represents a number that was checked
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ModelError(f"{field} must be a number, but is {show(value)}. {remedy}", field=field)
    try:
        result = float(value)
    except OverflowError:
        result = float("inf")
    if not isfinite(result):
        raise ModelError(f"{field} must be a finite number, but is {show(result)}. {remedy}", field=field)
    if 0.0 < abs(result) < sys.float_info.min:
        raise ModelError(
            f"{field} is too small, it is {show(result)}. Give 0, or a larger number.", field=field
        )
    if abs(result) > LARGEST:
        raise ModelError(f"{field} is too large, it is {show(result)}. {remedy}", field=field)
    return result


def positive(value: Any, field: str, remedy: str) -> float:
    """Return ``value`` as a float greater than 0, or raise a ModelError about ``field``."""
    result = number(value, field, remedy)
    if result <= 0.0:
        raise ModelError(f"{field} must be greater than 0, but is {show(result)}. {remedy}", field=field)
    return result


def regularization(creep: Any, field: str = "creep", unit: str = "m/s") -> float:
    """Return the speed below which a law is linear, whose square must be a number."""
    result = positive(creep, field, f"Give a small speed in {unit}.")
    if result < SLOWEST:
        message = f"{field} is too small, it is {show(result)}. Give a small speed in {unit}."
        raise ModelError(message, field=field)
    return result


def not_negative(value: Any, field: str, remedy: str) -> float:
    """Return ``value`` as a float of at least 0, or raise a ModelError about ``field``."""
    result = number(value, field, remedy)
    if result < 0.0:
        raise ModelError(f"{field} must not be negative, but is {show(result)}. {remedy}", field=field)
    return result


def fraction(value: Any, field: str, remedy: str) -> float:
    """Return ``value`` as a float between 0 and 1, or raise a ModelError about ``field``."""
    result = number(value, field, remedy)
    if result < 0.0 or result > 1.0:
        raise ModelError(f"{field} must be between 0 and 1, but is {show(result)}. {remedy}", field=field)
    return result


def numbers(value: Any, count: int, field: str, remedy: str) -> tuple[float, ...]:
    """Return ``value`` as ``count`` finite floats, or raise a ModelError about ``field``."""
    entries = _entries(value, field, remedy)
    if len(entries) != count:
        message = f"{field} must have {count} numbers, but has {len(entries)}. {remedy}"
        raise ModelError(message, field=field)
    return tuple([number(entry, field, remedy) for entry in entries])


def vector(value: Any, field: str, remedy: str = "Give three numbers [x, y, z].") -> Vec3:
    """Return ``value`` as three finite floats, or raise a ModelError about ``field``."""
    x, y, z = numbers(value, 3, field, remedy)
    return x, y, z


def direction(value: Any, field: str) -> Array:
    """Return the unit vector along ``value``, or raise a ModelError about ``field``. (3,) [-]"""
    components = np.array(vector(value, field))
    largest = float(abs(values_of(components)).max())
    if largest < SMALLEST_LENGTH:
        message = f"{field} has zero length. Give three numbers that are not all zero, for example [0, 0, 1]."
        raise ModelError(message, field=field)
    scaled = components / largest
    return np.asarray(scaled / np.sqrt(scaled @ scaled))


def triple(values: Array) -> Vec3:
    """Return three array entries as a tuple of plain floats (or traced numbers)."""
    return plain(values[0]), plain(values[1]), plain(values[2])


def plain(value: Any) -> float:
    """Return one entry of an array as a plain float; a traced number as it is."""
    return value if isinstance(value, Tracer) else float(value)  # type: ignore[return-value]


def is_list(value: Any) -> bool:
    """Return whether ``value`` is a list, a tuple or the like, or an array with at least one axis."""
    if isinstance(value, (list, tuple, str, bytes, float)):
        return isinstance(value, (list, tuple))
    return isinstance(value, Sequence) or getattr(value, "ndim", 0) > 0


def has_rows(value: Any) -> bool:
    """Return whether ``value`` is a list of three whose first is a list: meant as a 3x3 matrix."""
    return is_list(value) and len(value) == 3 and is_list(value[0])


def _entries(value: Any, field: str, remedy: str) -> list[Any]:
    if not is_list(value):
        raise ModelError(f"{field} must be a list of numbers, but is {show(value)}. {remedy}", field=field)
    return list(value)
