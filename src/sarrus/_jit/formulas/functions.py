"""The scalar functions that kernels may call, for recorded, real, complex and extended-precision numbers alike.

The definitions for numbers are here, those that are compiled in `compiled_functions`. The complex forms carry
the derivative of a complex step to first order; they are what independent checks differentiate through.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np

from .expression import Expression

CLOSE = 1e-8  # of a root and its scale: a step of Newton's method that leaves an error of round-off
ROOT_STEPS, AFTERWARDS = (
    50,
    6,
)  # at most; and those after a step that is close, of numbers with more than a float
SHORT = 1e-7  # of a root's scale: a difference for slopes


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
    if isinstance(x, np.ndarray):
        return 1.0 * (x > 0)
    return x.call("positive") if isinstance(x, Expression) else int(real(x) > 0)


def sech2(x: Any) -> Any:
    """1 / cosh(x)², the slope of tanh, without the cancellation of 1 - tanh(x)²."""
    if hasattr(x, "call"):
        return x.call("sech2")
    e = np.exp(-2 * np.abs(x)) if isinstance(x, np.ndarray) else exp(-2 * x if real(x) > 0 else 2 * x)
    return 4 * e / ((1 + e) * (1 + e))


def sign(x: Any) -> Any:
    """1 where x > 0, -1 where x < 0, else 0 (its derivative is zero)."""
    return positive(x) - positive(-x)


def _kinked(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function with a kink, of recorded numbers that note it as their own context does."""

    @wraps(function)
    def wrapped(*args: Any) -> Any:
        contexts = (getattr(arg, "context", None) for arg in args)
        own = next((c for c in contexts if hasattr(c, function.__name__)), None)
        return getattr(own, function.__name__)(*args) if own else function(*args)

    return wrapped


@_kinked
def ramp(x: Any) -> Any:
    """x where x > 0, else 0."""
    return x * positive(x)


@_kinked
def absolute(x: Any) -> Any:
    """x without its sign."""
    return x * (2 * positive(x) - 1)


@_kinked
def minimum(a: Any, b: Any) -> Any:
    """The smaller of two numbers."""
    return a - ramp(a - b)


@_kinked
def maximum(a: Any, b: Any) -> Any:
    """The larger of two numbers."""
    return a + ramp(b - a)


def step(x: Any, x0: Any, h0: Any, x1: Any, h1: Any) -> Any:
    """h0 up to x0 and h1 from x1 on, between them the cubic with level ends."""
    s = minimum(ramp((x - x0) / (x1 - x0)), 1)
    return h0 + (h1 - h0) * (s * s * (3 - 2 * s))


def newton(g: Callable[[Any], Any], start: Any, scale: float) -> Any:
    """The number u with g(u) = 0 by Newton's method, for numbers of any kind, or arrays; see `roots`.

    Slopes are differences, so that errors, also those of derivatives that numbers carry, decrease by `SHORT` each time.
    """
    u, left = start, ROOT_STEPS
    while left:
        value = g(u)
        slope = (g(u + SHORT * scale) - value) / (SHORT * scale)
        change = value / slope
        u, left = u - change, left - 1
        if left >= AFTERWARDS and _size(change) <= CLOSE * (scale + _size(u)):
            left = AFTERWARDS
        elif left == AFTERWARDS:
            return u * math.nan
    return u


def _size(x: Any) -> float:
    """The largest absolute value of numbers."""
    return float(np.max(np.abs(np.asarray(getattr(x, "value", x)))))


NUMERIC: dict[str, Callable[..., Any]] = {
    f.__name__: f
    for f in (sin, cos, tan, asin, acos, atan, exp, log, tanh, sqrt, atan2, nearest, positive, sech2)
}
