"""Functions of any kind of number: plain, complex and recorded ones, arrays, types with their own methods."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ... import functions

LARGEST_POWER = 64  # whole exponents up to this are products, so that they need only multiplication


def _select(a: Any, b: Any, x: Any, y: Any) -> Any:
    """Return x where a <= b, else y."""
    return x + (y - x) * functions.positive(a - b)


NAMES = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp", "log", "tanh")
NUMPY = {name: name.replace("a", "arc", 1) if name[0] == "a" else name for name in NAMES}
PLAIN: dict[str, Callable[..., Any]] = {
    **{name: getattr(math, name) for name in NAMES},
    "min": min,
    "max": max,
    "nearest": functions.nearest,
    "select": lambda a, b, x, y: x if a <= b else y,
}
ARRAYS: dict[str, Callable[..., Any]] = {
    **{name: getattr(np, NUMPY[name]) for name in NAMES},
    "min": np.minimum,
    "max": np.maximum,
    "nearest": lambda x: np.floor(x + 0.5),
    "select": lambda a, b, x, y: np.where(a <= b, x, y),
}
ANY: dict[str, Callable[..., Any]] = {
    **{name: getattr(functions, name) for name in NAMES},
    "min": functions.minimum,
    "max": functions.maximum,
    "nearest": functions.nearest,
    "select": _select,
}


def apply(name: str, *args: Any) -> Any:
    """Return a function's value.

    A type that brings a method of the function's name, as in ``x.sin()`` and ``x.max(0)``, is asked for it, unless
    ``sarrus.functions`` knows the type.
    """
    if all(isinstance(arg, (int, float)) for arg in args):
        return PLAIN[name](*args)
    if any(isinstance(arg, np.ndarray) for arg in args):
        return ARRAYS[name](*args)
    for place, arg in enumerate(args):
        if not _is_known(arg):
            first = arg if place == 0 else arg * 0 + args[0]
            return _method(first, name)(*args[1:])
    return ANY[name](*args)


def power(x: Any, n: Any) -> Any:
    """Return x to the power n: a product where n is a small whole number, else exp(n log x)."""
    if isinstance(x, (int, float)) and isinstance(n, (int, float)):
        return math.pow(x, n)
    if isinstance(n, (int, float)) and float(n).is_integer() and abs(n) <= LARGEST_POWER:
        return product(x, int(n)) if n >= 0 else 1 / product(x, -int(n))
    return x.real_power(n) if hasattr(x, "real_power") else apply("exp", n * apply("log", x))


def product(x: Any, n: int) -> Any:
    """Return x x … x, n times, by repeated squaring."""
    if n < 2:
        return x if n else 1
    half = product(x, n // 2)
    return half * half * x if n % 2 else half * half


def _is_known(x: Any) -> bool:
    """Return whether ``sarrus.functions`` takes a number: plain, complex, recorded, or of mpmath."""
    return isinstance(x, (int, float, complex, np.generic)) or hasattr(x, "call") or hasattr(x, "context")


def _method(x: Any, name: str) -> Any:
    if not hasattr(x, name):
        raise TypeError(
            f"numbers of type {type(x).__name__} have no method {name}. Use arithmetic and NumPy's functions."
        )
    return getattr(x, name)
