"""Work of Numba that linked functions do not need, left out while they are compiled.

* Numba's own functions, such as `numpy.zeros` for a type, are linked into the functions that call them. Their own
  machine code, which nobody calls, is not made.
* Lifetimes of variables are computed where the code is changed by them, not after each of nine passes.
* Flags of compilation and variables of instructions are listed by faster functions with the same results.

Numba compiles under one lock, so that no other thread compiles meanwhile.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

from numba.core import ir, transforms
from numba.core.cpu import CPUContext
from numba.core.postproc import PostProcessor
from numba.core.targetconfig import TargetConfig

from .linked_library import InnerLibrary, without_code

_complete: Any = PostProcessor.run
_entry: Any = CPUContext.get_executable
LEAVES = (str, ir.Loc, int, type(None))


def _run(processor: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
    """Numba's `PostProcessor.run` where variables are deleted or a generator keeps them; else only its first step."""
    code = processor.func_ir
    if emit_dels or code.is_generator:
        _complete(processor, emit_dels, extend_lifetimes)
    else:
        code.blocks, code.generator_info = transforms.canonicalize_cfg(code.blocks), None


def _values(flags: Any) -> dict[str, Any]:
    """Numba's `TargetConfig.values`, read at once."""
    values = flags._values
    return {name: values.get(name, option.default) for name, option in flags.options.items()}


def _variables(instruction: Any, value: Any) -> list[Any]:
    """Numba's `Inst._rec_list_vars`, without a call for each text, number and place in the source."""
    if isinstance(value, ir.Var):
        return [value]
    if isinstance(value, ir.Inst):
        return value.list_vars()
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, (list, tuple)) else ()
    return [
        found for part in parts if not isinstance(part, LEAVES) for found in _variables(instruction, part)
    ]


def _executable(target: Any, library: Any, *function: Any) -> Any:
    """Numba's `CPUContext.get_executable`, also for functions without machine code."""
    inner = isinstance(library, InnerLibrary)
    return without_code(library, *function) if inner else _entry(target, library, *function)


@contextmanager
def economy(codegen: Any) -> Iterator[None]:
    """Leave this work out while code is generated in this context."""
    with ExitStack() as stack:
        for owner, name, value in (
            (codegen, "_library_class", InnerLibrary),
            (CPUContext, "get_executable", _executable),
            (PostProcessor, "run", _run),
            (TargetConfig, "values", _values),
            (ir.Inst, "_rec_list_vars", _variables),
        ):
            stack.enter_context(patch.object(owner, name, value))
        yield
