"""Functions for formulas and kernels: they take numbers of any kind, recorded ones among them.

`abs`, `min`, `max`, `sign` and `step` have the names that they have in model files; `absolute`, `minimum` and
`maximum` are the same functions under the names that NumPy uses.
"""

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
    step,
    tan,
    tanh,
)

abs, min, max = absolute, minimum, maximum

__all__ = [
    "abs",
    "absolute",
    "acos",
    "asin",
    "atan",
    "atan2",
    "cos",
    "exp",
    "log",
    "max",
    "maximum",
    "min",
    "minimum",
    "nearest",
    "positive",
    "ramp",
    "sign",
    "sin",
    "sqrt",
    "step",
    "tan",
    "tanh",
]
