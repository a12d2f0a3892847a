"""Refuse calls between compiled functions that disagree on who counts the references to an array.

A function that is compiled with reference counts releases the arrays that its callees return, as Python does; one
without counts never claims them. If the first calls the second, memory is freed that is still in use; if the second
calls the first, memory is never freed.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core.compiler_machinery import AnalysisPass, register_pass


@register_pass(mutates_CFG=False, analysis_only=True)
class CheckReturnedArrays(AnalysisPass):
    """Compares the options of a function with those of the functions that return arrays to it."""

    _name = "sarrus_check_returned_arrays"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        counted, name = bool(state.flags.nrt), state.func_id.func_name
        if not counted and not state.flags.no_cpython_wrapper and _holds_arrays(state, state.return_type):
            raise TypeError(_message("Python", name, True))
        for call, signature in state.calltypes.items():
            if getattr(call, "op", None) == "call":
                callee = state.typemap[call.func.name]
                if _counts(callee) not in (None, counted) and _holds_arrays(state, signature.return_type):
                    raise TypeError(_message(name, callee.dispatcher.__name__, counted))
        return False


def _counts(callee: Any) -> bool | None:
    """Whether a compiled function counts references; None for functions of Numba and intrinsics."""
    if not isinstance(callee, types.Dispatcher):
        return None
    return bool(callee.dispatcher.targetoptions.get("_nrt", True))


def _holds_arrays(state: Any, kind: Any) -> bool:
    return bool(state.targetctx.data_model_manager[kind].contains_nrt_meminfo())


def _message(caller: str, callee: str, counted: bool) -> str:
    caller, callee = caller.rpartition("_")[0] or caller, callee.rpartition("_")[0] or callee
    if counted:
        return (
            f"{callee}: {caller} counts references, and would release the array that {callee} returns. "
            f"Let {callee} write into an argument, or mark it with `compiled(entry=True)`."
        )
    return (
        f"{callee}: {caller} counts no references, and would never release the array that {callee} returns. "
        f"Let {callee} write into an argument, or mark {caller} with `compiled(entry=True)`."
    )
