"""The scalar functions that kernels may call, for recorded, real, complex and extended-precision numbers alike.

Each stands here for numbers, and in `compiled_functions` in the few words that are compiled. The complex forms carry
the derivative of a complex step to first order; they are what independent checks differentiate through.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any

from .expression import Expression


def real(x: Any) -> float:
    """The real part, as a plain number."""
    return float(x.real if isinstance(x, complex) else x)


def _elementary(name: str) -> Callable[[Any], Any]:
    def function(x: Any) -> Any:
        if isinstance(x, Expression):
            return x.call(name)
        if isinstance(x, complex):
            return getattr(cmath, name)(x)
        return getattr(x.context if hasattr(x, "context") else math, name)(x)

    function.__name__ = name
    function.__doc__ = f"{name} of a number of any kind."
    return function


sin, cos, tan = _elementary("sin"), _elementary("cos"), _elementary("tan")
asin, acos, atan = _elementary("asin"), _elementary("acos"), _elementary("atan")
exp, log, tanh, sqrt = _elementary("exp"), _elementary("log"), _elementary("tanh"), _elementary("sqrt")


def atan2(y: Any, x: Any) -> Any:
    """Angle of the point (x, y)."""
    if isinstance(y, Expression) or isinstance(x, Expression):
        return y.call("atan2", x) if isinstance(y, Expression) else x.graph.constant(y).call("atan2", x)
    if isinstance(y, complex) or isinstance(x, complex):
        y, x = complex(y), complex(x)
        angle = math.atan2(y.real, x.real)
        return complex(angle, (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2))
    context = next((part.context for part in (y, x) if hasattr(part, "context")), math)
    return context.atan2(y, x)


def nearest(x: Any) -> Any:
    """Nearest whole number (its derivative is zero)."""
    return x.call("nearest") if isinstance(x, Expression) else math.floor(real(x) + 0.5)


def positive(x: Any) -> Any:
    """1 where x > 0, else 0 (its derivative is zero)."""
    return x.call("positive") if isinstance(x, Expression) else int(real(x) > 0)


def ramp(x: Any) -> Any:
    """x where x > 0, else 0."""
    return x * positive(x)


def absolute(x: Any) -> Any:
    """x without its sign."""
    return x * (2 * positive(x) - 1)


def minimum(a: Any, b: Any) -> Any:
    """The smaller of two numbers."""
    return a - ramp(a - b)


def maximum(a: Any, b: Any) -> Any:
    """The larger of two numbers."""
    return a + ramp(b - a)


NUMERIC: dict[str, Callable[..., Any]] = {
    f.__name__: f for f in (sin, cos, tan, asin, acos, atan, exp, log, tanh, sqrt, atan2, nearest, positive)
}
