"""Functions of any kind of number: plain and complex numbers, arrays, and types that bring their own methods."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

LARGEST_POWER = 64  # whole exponents up to this are products, so that they need only multiplication


def _arctan2(y: Any, x: Any) -> Any:
    """Return the angle of (x, y); for complex numbers to first order, as a complex step needs it."""
    if not (np.iscomplexobj(y) or np.iscomplexobj(x)):
        return np.arctan2(y, x)
    turn = np.real(x) * np.imag(y) - np.real(y) * np.imag(x)
    return np.arctan2(np.real(y), np.real(x)) + 1j * turn / (np.real(x) ** 2 + np.real(y) ** 2)


UFUNCS: dict[str, Callable[..., Any]] = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": _arctan2,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "min": np.minimum,
    "max": np.maximum,
    "select": lambda a, b, x, y: np.choose(np.real(a) <= np.real(b), (y, x)),
}
PLAIN: dict[str, Callable[..., Any]] = {
    **{name: getattr(math, name) for name in UFUNCS if name not in ("min", "max", "select")},
    "min": min,
    "max": max,
    "select": lambda a, b, x, y: x if a <= b else y,
}


def apply(name: str, *args: Any) -> Any:
    """Return a function's value.

    Plain numbers go to ``math``, arrays and complex numbers to NumPy, numbers of mpmath to their context. Any other
    type is asked for a method of the function's name, as in ``x.sin()`` and ``x.max(0)``, or for the method ``call``
    of recorded numbers.
    """
    if all(isinstance(arg, (int, float)) for arg in args):
        return PLAIN[name](*args)
    for place, arg in enumerate(args):
        if not isinstance(arg, (int, float, complex, np.ndarray, np.generic)):
            return _own(name, arg, place, args)
    return UFUNCS[name](*args)


def power(x: Any, n: Any) -> Any:
    """Return x to the power n: a product where n is a small whole number, else exp(n log x)."""
    if isinstance(x, (int, float)) and isinstance(n, (int, float)):
        return math.pow(x, n)
    if isinstance(n, (int, float)) and float(n).is_integer() and abs(n) <= LARGEST_POWER:
        return product(x, int(n)) if n >= 0 else 1 / product(x, -int(n))
    return apply("exp", n * apply("log", x))


def product(x: Any, n: int) -> Any:
    """Return x x … x, n times, by repeated squaring."""
    if n < 2:
        return x if n else 1
    half = product(x, n // 2)
    return half * half * x if n % 2 else half * half


def _own(name: str, arg: Any, place: int, args: tuple[Any, ...]) -> Any:
    context = getattr(arg, "context", None)
    if hasattr(context, name):
        return getattr(context, name)(*args)
    if context is not None:
        return PLAIN[name](*args)
    first = arg if place == 0 else arg * 0 + args[0]
    if hasattr(first, name):
        return getattr(first, name)(*args[1:])
    if not hasattr(first, "call"):
        raise TypeError(f"numbers of type {type(arg).__name__} have no method {name}")
    return first.call(name, *args[1:])
