"""Functions for formulas and kernels: they take numbers of any kind, recorded ones among them.

`abs`, `min`, `max`, `sign` and `step` have the names that they have in model files; `absolute`, `minimum` and
`maximum` are the same functions under the names that NumPy uses.
"""

from math import pi as _pi
from typing import Any as _Any

from ._jit.formulas.functions import (
    absolute,
    acos,
    asin,
    atan,
    atan2,
    cos,
    exp,
    log,
    maximum,
    minimum,
    nearest,
    positive,
    ramp,
    sign,
    sin,
    sqrt,
    tan,
    tanh,
)
from ._jit.formulas.functions import step as _rounded_step
from ._jit.formulas.roots import root

abs, min, max = absolute, minimum, maximum


def step(x: _Any, *ramp: _Any) -> _Any:
    """h0 up to x0 and h1 from x1 on, for ``step(x, x0, h0, x1, h1)``; of x alone 1 where x > 0, else 0."""
    return _rounded_step(x, *ramp) if ramp else positive(x)


def floor(x: _Any) -> _Any:
    """The largest whole number that is not larger than x (its derivative is zero)."""
    return nearest(x - 0.5)


def mod(x: _Any, y: _Any) -> _Any:
    """The remainder x - y floor(x/y), from 0 to y."""
    return x - y * floor(x / y)


def hypot(x: _Any, y: _Any) -> _Any:
    """√(x² + y²)."""
    return sqrt(x * x + y * y)


def deg(x: _Any) -> _Any:
    """An angle in degrees, of radians."""
    return x * (180 / _pi)


def rad(x: _Any) -> _Any:
    """An angle in radians, of degrees."""
    return x * (_pi / 180)


__all__ = [
    "abs",
    "absolute",
    "acos",
    "asin",
    "atan",
    "atan2",
    "cos",
    "deg",
    "exp",
    "floor",
    "hypot",
    "log",
    "max",
    "maximum",
    "min",
    "minimum",
    "mod",
    "nearest",
    "positive",
    "rad",
    "ramp",
    "root",
    "sign",
    "sin",
    "sqrt",
    "step",
    "tan",
    "tanh",
]
