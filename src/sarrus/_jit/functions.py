"""The scalar functions that kernels may call, for recorded, real, complex and extended-precision numbers alike.

Each is written twice: for numbers, and in the few words that are compiled (`COMPILED`). The complex forms carry the
derivative of a complex step to first order; they are what independent checks differentiate through.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any

from .expression import Expression


def sqrt(x: Any) -> Any:
    """Square root."""
    if isinstance(x, Expression):
        return x.sqrt()
    if isinstance(x, complex):
        return cmath.sqrt(x)
    return x.context.sqrt(x) if hasattr(x, "context") else math.sqrt(x)


def atan2(y: Any, x: Any) -> Any:
    """Angle of the point (x, y)."""
    if isinstance(y, Expression) or isinstance(x, Expression):
        return y.call("atan2", x) if isinstance(y, Expression) else x.graph.constant(y).call("atan2", x)
    if isinstance(y, complex) or isinstance(x, complex):
        y, x = complex(y), complex(x)
        angle = math.atan2(y.real, x.real)
        return complex(angle, (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2))
    if hasattr(y, "context"):
        return y.context.atan2(y, x)
    return math.atan2(y, x)


def nearest(x: Any) -> Any:
    """Nearest whole number (its derivative is zero)."""
    if isinstance(x, Expression):
        return x.call("nearest")
    return math.floor(real(x) + 0.5)


def real(x: Any) -> float:
    """The real part, as a plain number."""
    return float(x.real if isinstance(x, complex) else x)


def piece(numbers: Any, at: int, x: Any) -> int:
    """Index of the cubic piece of the curve stored at ``numbers[at:]`` in which x lies."""
    count = int(real(numbers[at]))
    low = 0
    while low < count - 1 and real(x) >= real(numbers[at + 2 + low]):
        low += 1
    return low


def curve(numbers: Any, at: int, x: Any) -> Any:
    """Value at x of the piecewise cubic stored at ``numbers[at:]``: count, count + 1 knots, 4 coefficients a piece."""
    k, count = piece(numbers, at, x), int(real(numbers[at]))
    c, u = at + 2 + count + 4 * k, x - numbers[at + 1 + k]
    return ((numbers[c] * u + numbers[c + 1]) * u + numbers[c + 2]) * u + numbers[c + 3]


def curve_slope(numbers: Any, at: int, x: Any) -> Any:
    """First derivative of `curve` to x."""
    k, count = piece(numbers, at, x), int(real(numbers[at]))
    c, u = at + 2 + count + 4 * k, x - numbers[at + 1 + k]
    return (3 * numbers[c] * u + 2 * numbers[c + 1]) * u + numbers[c + 2]


def _curve(numbers, where, x):  # type: ignore[no-untyped-def]
    at = int(where)
    low, high = 0, int(numbers[at]) - 1
    while low < high:
        middle = (low + high) // 2
        if x >= numbers[at + 2 + middle]:
            low = middle + 1
        else:
            high = middle
    c = at + 2 + int(numbers[at]) + 4 * low
    u = x - numbers[at + 1 + low]
    return ((numbers[c] * u + numbers[c + 1]) * u + numbers[c + 2]) * u + numbers[c + 3]


def _curve_slope(numbers, where, x):  # type: ignore[no-untyped-def]
    at = int(where)
    low, high = 0, int(numbers[at]) - 1
    while low < high:
        middle = (low + high) // 2
        if x >= numbers[at + 2 + middle]:
            low = middle + 1
        else:
            high = middle
    c = at + 2 + int(numbers[at]) + 4 * low
    u = x - numbers[at + 1 + low]
    return (3.0 * numbers[c] * u + 2.0 * numbers[c + 1]) * u + numbers[c + 2]


def _nearest(x):  # type: ignore[no-untyped-def]
    return math.floor(x + 0.5)


def _atan2(y, x):  # type: ignore[no-untyped-def]
    return math.atan2(y, x)


READS_NUMBERS = {"curve", "curve_slope"}
COMPILED: dict[str, Callable[..., float]] = {
    "atan2": _atan2,
    "nearest": _nearest,
    "curve": _curve,
    "curve_slope": _curve_slope,
}
