"""Compiled functions with fixed arguments, which are passed by the addresses of their memory.

Python takes about 0.2 µs to pass one array, and records of compiled loops have more than a hundred. A bound function
takes one array of addresses and lengths instead, from which compiled code makes the arrays again.

Compiled forms are cached by their source, which contains a digest of this file: an edit compiles them anew.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from ..linking.link import link
from .driver import compile_source
from .scalars import Scalars

Table = NDArray[np.int64]
JIT: Any = numba
_functions: dict[str, Any] = {}  # by their source


class Bound:
    """A compiled function with its first arguments fixed: arrays, scalars by name, numbers, and named tuples of them.

    Other compiled code calls ``function(data, ...)``; the object must exist as long.

    Attributes
    ----------
    function : the compiled function, which takes `data` in the place of the fixed arguments
    data : addresses and lengths of the arrays, and numbers
    """

    def __init__(self, function: Callable[..., Any], *fixed: Any) -> None:
        self._fixed = fixed
        linked: Any = link(function, entry=False)
        leaves, scope = list[int](), dict[str, Any]({"function": linked, "address": address})
        scope |= {"carray": JIT.carray, "float64": np.float64}
        built = ", ".join(_rebuilt(one, leaves, scope) for one in fixed)
        self.data = np.array(leaves, dtype=np.int64)
        count = function.__code__.co_argcount - len(fixed)
        others = "".join(f", x{n}" for n in range(count))
        lines = [
            f"def bound(data{others}):",
            f"    # {linked.__name__} {_digest()}",
            f"    return function({built}{others})",
        ]
        source = "\n".join(lines)
        if source not in _functions:
            _functions[source] = compile_source(f"bound_{function.__name__}", lines, scope)
        self.function = _functions[source]

    def __call__(self, *others: Any) -> Any:
        """Call it with the other arguments."""
        return self.function(self.data, *others)


def _rebuilt(value: Any, leaves: list[int], scope: dict[str, Any]) -> str:
    """The text by which compiled code makes an argument from `data`, to which its numbers are added."""
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        kind = f"{type(value).__module__}.{type(value).__qualname__}".replace(".", "_")
        scope[kind] = type(value)
        parts = (f"{name}={_rebuilt(getattr(value, name), leaves, scope)}" for name in value._fields)
        return f"{kind}({', '.join(parts)})"
    at = len(leaves)
    if isinstance(value, (int, np.integer)):
        leaves.append(int(value))
        return f"data[{at}] != 0" if isinstance(value, bool) else f"data[{at}]"
    if isinstance(value, float):
        leaves.append(int(np.float64(value).view(np.int64)))
        return f"data.view(float64)[{at}]"
    if isinstance(value, Scalars):
        kind = "_".join(["scalars", *(f"{name}_{value.dtype[name]}" for name in value.dtype.names or ())])
        scope[kind], memory = value.dtype, memoryview(value)  # type: ignore[arg-type]
        leaves.append(np.frombuffer(memory, np.uint8).ctypes.data)
        return f"carray(address(data[{at}]), (1,), {kind})[0]"
    if not (isinstance(value, np.ndarray) and value.flags.c_contiguous and value.flags.writeable):
        raise TypeError(f"cannot bind {type(value).__name__}. Pass contiguous writeable arrays, or numbers.")
    scope[value.dtype.name] = value.dtype.type
    leaves += [value.ctypes.data, *value.shape]
    shape = ", ".join(f"data[{at + 1 + n}]" for n in range(value.ndim))
    return f"carray(address(data[{at}]), ({shape},), {value.dtype.name})"


@cache
def _digest() -> str:
    """A digest of this file."""
    return hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:12]


@intrinsic
def address(typingctx: Any, number: Any) -> Any:
    """The address that a whole number is."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], ir.PointerType(ir.IntType(8)))

    return types.voidptr(types.int64), codegen
