"""The functions and operators of formulas, each with its derivatives, for any kind of number."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from ... import functions
from .tree import REGISTRY, Expression, Function, Number, Partials, call, lift

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


CONSTANTS = {"pi": math.pi}
DEGREE = math.pi / 180


def _operator(name: str, precedence: int, value: Callable[..., Any], partials: Partials) -> None:
    REGISTRY[name] = Function(name, (1,) if name == "neg" else (2,), value, partials, precedence)


def _function(name: str, count: int, partials: Partials, value: Callable[..., Any] | None = None) -> None:
    REGISTRY[name] = Function(name, (count,), value or partial(apply, name), partials)


def _power_partials(x: Expression, n: Expression) -> tuple[Expression, ...]:
    by_x = n * x ** (Number(n.number - 1) if isinstance(n, Number) else n - 1)
    # A constant exponent needs no logarithm, which a negative x does not have.
    return by_x, Number(0.0) if not n.names() else x**n * call("log", x)


def _absolute(x: Any) -> Any:
    return apply("max", x, -x)


def _sign(x: Any) -> Any:
    """Return 1, 0 or -1."""
    return apply("select", x, 0, apply("select", 0, x, 0, -1), 1)


def _floor(x: Any) -> Any:
    """Return the largest whole number that is not larger."""
    return apply("nearest", x - 0.5)


def _hypot(x: Any, y: Any) -> Any:
    plain = isinstance(x, (int, float)) and isinstance(y, (int, float))
    return math.hypot(x, y) if plain else apply("sqrt", x * x + y * y)


def _select_partials(a: Expression, b: Expression, x: Expression, y: Expression) -> tuple[Expression, ...]:
    one, zero = Number(1.0), Number(0.0)
    return zero, zero, call("select", a, b, one, zero), call("select", a, b, zero, one)


def _extreme(first_if: Callable[[Expression, Expression], Expression]) -> Partials:
    """Return the partials of min or max: 1 for the argument that is taken, 0 for the other."""
    return lambda a, b: (first_if(a, b), 1 - first_if(a, b))


def _progress(x: Any, x0: Any, x1: Any) -> Any:
    """Return (x − x0)/(x1 − x0), held between 0 and 1."""
    return apply("min", apply("max", (x - x0) / (x1 - x0), 0), 1)


def _step(x: Any, *ramp: Any) -> Any:
    """Return the step from h0 at x0 to h1 at x1, or the unit step of x alone."""
    if not ramp:
        return apply("select", x, 0, 0, 1)
    x0, h0, x1, h1 = ramp
    s = _progress(x, x0, x1)
    return h0 + (h1 - h0) * (s * s * (3 - 2 * s))


def _step_partials(x: Expression, *ramp: Expression) -> tuple[Expression, ...]:
    if not ramp:
        return (Number(0.0),)
    x0, h0, x1, h1 = ramp
    width, height = x1 - x0, h1 - h0
    s = call("min", call("max", (x - x0) / width, Number(0.0)), Number(1.0))
    slope, risen = height * 6 * s * (1 - s) / width, s * s * (3 - 2 * s)
    return slope, slope * (s - 1), 1 - risen, -(slope * s), risen


_operator("+", 1, operator.add, lambda a, b: (Number(1.0), Number(1.0)))
_operator("-", 1, operator.sub, lambda a, b: (Number(1.0), Number(-1.0)))
_operator("*", 2, operator.mul, lambda a, b: (b, a))
_operator("/", 2, operator.truediv, lambda a, b: (1 / b, -(a / (b * b))))
_operator("neg", 3, operator.neg, lambda a: (Number(-1.0),))
_operator("**", 4, power, _power_partials)

_function("sin", 1, lambda x: (call("cos", x),))
_function("cos", 1, lambda x: (-call("sin", x),))
_function("tan", 1, lambda x: (1 + call("tan", x) ** 2,))
_function("asin", 1, lambda x: (1 / call("sqrt", 1 - x * x),))
_function("acos", 1, lambda x: (-(1 / call("sqrt", 1 - x * x)),))
_function("atan", 1, lambda x: (1 / (1 + x * x),))
_function("atan2", 2, lambda y, x: (x / (x * x + y * y), -(y / (x * x + y * y))))
_function("sqrt", 1, lambda x: (1 / (2 * call("sqrt", x)),))
_function("exp", 1, lambda x: (call("exp", x),))
_function("log", 1, lambda x: (1 / x,))
_function("tanh", 1, lambda x: (1 - call("tanh", x) ** 2,))
_function("hypot", 2, lambda x, y: (x / call("hypot", x, y), y / call("hypot", x, y)), _hypot)
_function("abs", 1, lambda x: (call("select", -x, x, Number(1.0), Number(-1.0)),), _absolute)
_function("sign", 1, lambda x: (Number(0.0),), _sign)
_function("floor", 1, lambda x: (Number(0.0),), _floor)
_function("mod", 2, lambda x, y: (Number(1.0), -call("floor", x / y)), lambda x, y: x - y * _floor(x / y))
_function("min", 2, _extreme(lambda a, b: call("select", a, b, Number(1.0), Number(0.0))))
_function("max", 2, _extreme(lambda a, b: call("select", b, a, Number(1.0), Number(0.0))))
_function("deg", 1, lambda x: (Number(1 / DEGREE),), lambda x: x / DEGREE)
_function("rad", 1, lambda x: (Number(DEGREE),), lambda x: x * DEGREE)
REGISTRY["step"] = Function("step", (5, 1), _step, _step_partials)
_function("select", 4, _select_partials)

# What a person may call. select(a, b, x, y), x where a <= b and else y, is only met in derivatives.
FUNCTIONS = tuple(name for name, known in REGISTRY.items() if not known.precedence and name != "select")


def _of_formulas(name: str) -> Callable[..., Expression]:
    return lambda *args: call(name, *map(lift, args))


# `sarrus.functions`, and NumPy by methods of its own names, call these for a formula, so that the value of a Python
# function for a formula is a formula.
Expression.context = SimpleNamespace(
    **{name: _of_formulas(name) for name in NAMES},
    absolute=_of_formulas("abs"),
    minimum=_of_formulas("min"),
    maximum=_of_formulas("max"),
)
for _name in NAMES:
    setattr(Expression, NUMPY[_name], _of_formulas(_name))
