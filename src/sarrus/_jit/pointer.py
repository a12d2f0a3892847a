"""Compiled functions called by their address, so that a loop is compiled once for all that it may call.

A function that is called by name is compiled into its caller: a time loop would be compiled again for every kind of
system, with all its kernels in it.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .driver import Signature, compiled


class Entry(NamedTuple):
    """Drivers that are called one after another, and their index tables.

    Attributes
    ----------
    addresses : (n,) of the drivers' code
    starts : (n + 1,) where in `tables` each driver's table begins
    tables : all tables, one after another
    """

    addresses: Any
    starts: Any
    tables: Any


NONE = Entry(np.zeros(0, np.int64), np.zeros(1, np.int64), np.zeros(0, np.int64))


def entry(drivers: list[Any], tables: list[Any], signature: Signature) -> Entry:
    """The entry of drivers of one signature. The drivers must be kept alive as long as it is used."""
    found = [_address(driver, signature.types()) for driver in drivers]
    starts = np.cumsum([0, *(len(table) for table in tables)])
    return Entry(
        np.array(found, dtype=np.int64), starts.astype(np.int64), np.concatenate([NONE.tables, *tables])
    )


def _address(driver: Any, kinds: tuple[Any, ...]) -> int:
    result = driver.overloads[kinds]
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


@cache
def run(scalars: int, arrays: int) -> Any:
    """The compiled function ``run(entry, numbers, *scalars, *arrays)``, which calls all drivers of an entry."""
    given = [f"s{n}" for n in range(scalars)] + [f"a{n}" for n in range(arrays)]
    operands = ", ".join(given)
    name = f"run_{scalars}_{arrays}"
    lines = [
        f"def {name}(entry, numbers, {operands}):",
        "    for n in range(len(entry.addresses)):",
        "        table = entry.tables[entry.starts[n] : entry.starts[n + 1]]",
        f"        call(entry.addresses[n], table, numbers, {operands})",
    ]
    return compiled(name, lines, {"call": _call(scalars, arrays)})


def _call(scalars: int, arrays: int) -> Any:
    """A call of compiled code of the type ``(table, numbers, *scalars, *arrays) -> None`` at an address."""
    name = f"call_{scalars}_{arrays}"
    given = [f"x{n}" for n in range(scalars + arrays)]
    array, table = types.float64[::1], types.int64[::1]
    kinds = (table, array, *(types.float64,) * scalars, *(array,) * arrays)
    lines = [
        f"def {name}(typingctx, address, table, numbers, {', '.join(given)}):",
        "    return types.void(types.int64, *kinds), codegen",
    ]
    scope: dict[str, Any] = {"types": types, "kinds": kinds, "codegen": _emit}
    exec("\n".join(lines), scope)
    return intrinsic(scope[name])


def _emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    kinds = signature.args[1:]
    kind = context.call_conv.get_function_type(types.none, kinds)
    function = builder.inttoptr(args[0], ir.PointerType(kind))
    context.call_conv.call_function(builder, function, types.none, kinds, args[1:])
    return context.get_dummy_value()
