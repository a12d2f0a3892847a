"""Compiled functions called by their address, so that a loop is compiled once for all that it may call.

A function that is called by name is compiled into its caller: a time loop would be compiled again for every kind of
system, with all its kernels in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic, overload
from numpy.typing import NDArray

from ..linking.compiler import LinkedCompiler
from ..linking.link import COMMON
from .driver import Signature

Table = NDArray[np.int64]
Values = NDArray[np.float64]


class KernelTable(NamedTuple):
    """Drivers that are called one after another, and their index tables.

    Attributes
    ----------
    addresses : (n,) of the drivers' code
    starts : (n + 1,) where in `tables` each driver's table begins
    tables : all tables, one after another
    """

    addresses: Table
    starts: Table
    tables: Table


INNER: Any = COMMON | {"_nrt": False, "no_cpython_wrapper": True, "pipeline_class": LinkedCompiler}
NONE = KernelTable(np.zeros(0, np.int64), np.zeros(1, np.int64), np.zeros(0, np.int64))


def kernel_table(drivers: Sequence[Any], tables: Sequence[Table], signature: Signature) -> KernelTable:
    """The table of drivers of one signature. The caller must hold references to the drivers while it is used."""
    found = [_address(driver, signature.types()) for driver in drivers]
    starts = np.cumsum([0, *(len(table) for table in tables)])
    return KernelTable(
        np.array(found, dtype=np.int64), starts.astype(np.int64), np.concatenate([NONE.tables, *tables])
    )


def _address(driver: Any, kinds: tuple[Any, ...]) -> int:
    result = driver.overloads[kinds]
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def call_kernels(table: KernelTable, numbers: Values, *operands: float | Values) -> None:
    """Call all drivers of a table, one after another: ``driver(index, numbers, *operands)``.

    Operands are numbers, which become floats, and contiguous arrays of floats of one dimension.
    """
    _from_python(table, numbers, operands)


@overload(call_kernels, jit_options=INNER)
def _compiled_call(table: Any, numbers: Any, *operands: Any) -> Any:
    def loop(table: Any, numbers: Any, *operands: Any) -> None:
        for n in range(len(table.addresses)):
            index = table.tables[table.starts[n] : table.starts[n + 1]]
            _call(table.addresses[n], index, numbers, operands)  # type: ignore[call-arg]

    return loop


@njit(nogil=True)
def _from_python(table: Any, numbers: Any, operands: Any) -> None:
    call_kernels(table, numbers, *operands)


@intrinsic
def _call(typingctx: Any, address: Any, index: Any, numbers: Any, operands: Any) -> Any:
    """A call of compiled code of the type ``(index, numbers, *operands) -> None`` at an address."""
    array, given = types.float64[::1], tuple(operands)
    kinds = (
        types.int64[::1],
        array,
        *(types.float64 if isinstance(x, types.Number) else array for x in given),
    )

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        parts = [builder.extract_value(args[3], n) for n in range(len(given))]
        parts = [
            context.cast(builder, x, own, kind) for x, own, kind in zip(parts, given, kinds[2:], strict=True)
        ]
        function_type = context.call_conv.get_function_type(types.none, kinds)
        function = builder.inttoptr(args[0], ir.PointerType(function_type))
        context.call_conv.call_function(builder, function, types.none, kinds, [*args[1:3], *parts])
        return context.get_dummy_value()

    return types.void(types.int64, *kinds[:2], operands), codegen
