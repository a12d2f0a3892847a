"""Arguments of a compiled function that are stored once: calls from Python then take no time for them.

Every array of an argument costs a quarter of a microsecond in a call from Python. A stored argument is the value that
compiled code has of it, without counts of references: whoever stores it holds the arrays.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numba import typeof, types
from numba.core.registry import cpu_target
from numba.extending import intrinsic

from .driver import compile_source


class StoredCall:
    """A compiled function of a record of arrays, which is stored, and of one number.

    Parameters
    ----------
    function : compiled, of the record and a number
    record : nested named tuples of arrays and numbers; the arrays must stay where they are
    """

    def __init__(self, function: Callable[..., Any], record: tuple[Any, ...]) -> None:
        kind = typeof(record)
        context: Any = cpu_target.target_context
        self._held, store = record, _store(kind)
        self._memory = np.zeros(context.get_abi_sizeof(context.get_value_type(kind)), np.uint8)
        store(self._memory, record)
        self._call = _caller(function, kind)

    def __call__(self, number: float) -> Any:
        """Call the function."""
        return self._call(self._memory, number)


@cache
def _caller(function: Any, kind: Any) -> Any:
    """The function of the stored record."""

    @intrinsic
    def loaded(typingctx: Any, memory: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return builder.load(_place(context, builder, signature.args[0], args[0], kind))

        return kind(memory), codegen

    lines = ["def call(memory, number):", "    return function(loaded(memory), number)"]
    name = _name(f"call_{function.py_func.__name__}", kind)
    return compile_source(name, lines, {"function": function, "loaded": loaded})


@cache
def _store(kind: Any) -> Any:
    """Write a record to memory."""

    @intrinsic
    def stored(typingctx: Any, memory: Any, record: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            value = _uncounted(context, builder, kind, args[1])
            builder.store(value, _place(context, builder, signature.args[0], args[0], kind))
            return context.get_dummy_value()

        return types.void(memory, record), codegen

    lines = ["def store(memory, record):", "    stored(memory, record)"]
    return compile_source(_name("store", kind), lines, {"stored": stored})


def _name(name: str, kind: Any) -> str:
    """The name under which a compiled function of a record is stored; it changes with this file."""
    digest = hashlib.sha256(repr(kind).encode() + Path(__file__).read_bytes()).hexdigest()
    return f"{name}_{digest[:12]}"


def _place(context: Any, builder: Any, memory_kind: Any, memory: Any, kind: Any) -> Any:
    """The address of the record in its memory."""
    data = context.make_array(memory_kind)(context, builder, memory).data
    return builder.bitcast(data, context.get_value_type(kind).as_pointer())


def _uncounted(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """A value whose arrays count no references."""
    if isinstance(kind, types.BaseTuple):
        parts: Any = kind
        for n, part in enumerate(parts):
            inner = _uncounted(context, builder, part, builder.extract_value(value, n))
            value = builder.insert_value(value, inner, n)
        return value
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo, array.parent = (context.get_constant_null(types.voidptr),) * 2
        return array._getvalue()
    return value
