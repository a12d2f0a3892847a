"""The functions that kernels call, as compiled code: `COMPILED` by name, and the stored curves."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload, register_jitable

from ..formulas import curves, functions, surfaces
from ..formulas.curves import STEPS, curve_bend, curve_slope, curve_twist, curve_value
from ..formulas.surfaces import HIGHEST, ORDERS, surface_value

ELEMENTARY = (
    functions.sqrt, functions.sin, functions.cos, functions.tan, functions.asin, functions.acos, functions.atan,
    functions.exp, functions.log, functions.tanh,
)  # fmt: skip
CALLED_BY_TABLES = (
    curves.interval, curves._cubic, curves._chain, curves._elementary_step, curves._binary_step, curves._formula,
    curves._evaluate, surfaces.hermite, surfaces._factors,
)  # fmt: skip


@intrinsic
def _stack(typingctx: Any, count: Any) -> Any:
    """Memory for a formula's values and derivatives, on the stack."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return cgutils.alloca_once(builder, ir.DoubleType(), size=4 * STEPS)

    return types.CPointer(types.float64)(count), codegen


@overload(curves._work, strict=False)
def _compiled_work() -> Any:
    return lambda: _stack(0)  # type: ignore[call-arg]


@overload(functions.real, strict=False)
def _compiled_real(x: Any) -> Any:
    return lambda x: x


@overload(functions.nearest, strict=False)
def _compiled_nearest(x: Any) -> Any:
    return lambda x: math.floor(x + 0.5)


def _math(name: str) -> Callable[[float], float]:
    """A function of `math` in a form that Numba compiles."""
    scope: dict[str, Any] = {"math": math}
    exec(f"def {name}(x):\n    return math.{name}(x)", scope)
    compiled: Callable[[float], float] = scope[name]
    return compiled


def _choice(function: Callable[[float], float]) -> Callable[[Any], Callable[[float], float]]:
    """Numba's callback that chooses the implementation by an argument's type: always the same one."""

    def choose(x: Any) -> Callable[[float], float]:
        return function

    return choose


def _register() -> None:
    """Let compiled code call the functions of `curves` and `surfaces`, and those that they call."""
    for elementary in ELEMENTARY:
        overload(elementary, strict=False)(_choice(_math(elementary.__name__)))
    own = (curve_value, curve_slope, curve_bend, curve_twist, surface_value)
    for function in (*CALLED_BY_TABLES, *own):
        register_jitable(function)


def _surface(i: int, j: int) -> Callable[..., Any]:
    """A derivative of a surface in a form that Numba compiles."""
    scope: dict[str, Any] = {"surface_value": surface_value}
    exec(
        f"def surface(numbers, at, x, y):\n    return surface_value(numbers, int(at), x, y, {i}, {j})", scope
    )
    compiled: Callable[..., Any] = scope["surface"]
    return compiled


_register()
SURFACES = {name: _surface(*orders) for name, orders in ORDERS.items() if sum(orders) <= HIGHEST}
COMPILED: dict[str, Callable[..., Any]] = {
    **{elementary.__name__: _math(elementary.__name__) for elementary in ELEMENTARY},
    "atan2": lambda y, x: math.atan2(y, x),
    "nearest": lambda x: math.floor(x + 0.5),
    "sech2": lambda x: 1.0 / (math.cosh(x) * math.cosh(x)),
    "positive": lambda x: 1.0 if x > 0.0 else 0.0,
    "curve": lambda numbers, at, x: curve_value(numbers, int(at), x),
    "curve_slope": lambda numbers, at, x: curve_slope(numbers, int(at), x),
    "curve_bend": lambda numbers, at, x: curve_bend(numbers, int(at), x),
    "curve_twist": lambda numbers, at, x: curve_twist(numbers, int(at), x),
    **SURFACES,
}
READS_NUMBERS = {"curve", "curve_slope", "curve_bend", "curve_twist", *SURFACES}
