"""Numba's compiler with two passes of ours: who counts references is checked, and code is made in linked libraries.

Passes whose results linked functions do not use are left out.
"""

from __future__ import annotations

from typing import Any

from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.typed_passes import AnnotateTypes, NativeLowering, NopythonRewrites

from .economy import economy
from .linked_library import LinkedLowering
from .reference_counts import CheckReturnedArrays


class LinkedCompiler(CompilerBase):
    """The compiler of linked functions and of drivers."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a function, and Numba's own functions that it calls, without work that they do not need."""
        with economy(self.state.targetctx.codegen()):
            return super().compile_extra(func)  # type: ignore[no-untyped-call]

    def define_pipelines(self) -> list[Any]:
        passes: Any = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(CheckReturnedArrays, AnnotateTypes)
        passes.add_pass_after(LinkedLowering, NativeLowering)
        unused = [NativeLowering, AnnotateTypes]  # a listing of types, which nobody reads
        if not self.state.flags.nrt:  # sums and products of arrays would make arrays
            unused.append(NopythonRewrites)
        passes.passes = [one for one in passes.passes if one[0] not in unused]
        passes.finalize()
        return [passes]
