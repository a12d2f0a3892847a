"""Libraries of compiled functions: only an entry is optimized as a whole and translated, with all that it calls in it.

Numba optimizes and translates each function with all that it calls, and again within each of its callers: a function at
depth eight is optimized eight times. Functions that only compiled code calls have no use for machine code of their own.
Here they are modules, simplified function by function, until an entry takes them.
"""

from __future__ import annotations

from typing import Any

from llvmlite.binding import Linkage, ModuleRef, set_option
from llvmlite.binding.newpassmanagers import (
    PipelineTuningOptions,
    create_pass_builder,
    create_pipeline_tuning_options,
)
from numba import _dynfunc  # type: ignore[attr-defined]
from numba.core import config
from numba.core.codegen import JITCodeLibrary, _parse_refprune_flags
from numba.core.compiler_machinery import register_pass
from numba.core.environment import lookup_environment
from numba.core.typed_passes import NativeLowering

from .record_lowering import RecordLowering

ENVIRONMENT = "_ZN08NumbaEnv"  # how Numba's names of the environments of functions begin
WRAPPER = (
    "_ZN7cpython"  # how Numba's names of functions begin that convert the arguments of a call from Python
)
UNOPTIMIZED = ("noinline", "optnone")
SETTINGS: Any = config
FIRST_LEVEL = 1  # of optimization of single functions: the whole is optimized at the full level
VECTORIZER = (  # options of LLVM's vectorizer of straight-line code: it finds as much in a fraction of the time
    "-slp-schedule-budget=1000", "-slp-recursion-max-depth=6", "-slp-max-look-ahead-depth=1",
)  # fmt: skip
for option in VECTORIZER:
    set_option("sarrus", option)


def _tuning() -> PipelineTuningOptions:
    """LLVM's options for the optimization of an entry with all that it calls."""
    tuning = create_pipeline_tuning_options(SETTINGS.OPT)
    tuning.slp_vectorization = bool(SETTINGS.SLP_VECTORIZE)
    tuning.loop_vectorization = bool(SETTINGS.LOOP_VECTORIZE)
    tuning.loop_interleaving = tuning.loop_unrolling = False
    return tuning


class LinkedLibrary(JITCodeLibrary):
    """The code of an entry."""

    inner = False

    def _optimize_functions(self, ll_module: ModuleRef) -> None:
        """Simplify functions that are linked into several entries, and those that are not optimized later."""
        ll_module.data_layout = self._codegen._data_layout
        manager, builder = self._codegen._function_pass_manager(opt=FIRST_LEVEL)
        for function in ll_module.functions:
            if not function.is_declaration and (self.inner or function.name.startswith(WRAPPER)):
                manager.run(function, builder)

    def _optimize_final_module(self) -> None:
        """Optimize all at once; Numba's first round serves reference counts, which are pruned in the second, too.

        Loops over entries of small matrices are short: unrolled copies of them are not faster, and take long to
        compile, as does the conversion of some hundred arrays. Inner functions are private to the entry, so that LLVM
        removes arguments that they do not use. They must not be symbols of its code, not even local ones: LLVM finds
        the address of an entry by its name among all of them, and an entry that is part of another has its name there.
        """
        for function in self._final_module.functions:
            if not function.is_declaration:
                if function.name.startswith(WRAPPER):
                    for attribute in UNOPTIMIZED:
                        function.add_function_attribute(attribute)
                elif function.linkage == Linkage.linkonce_odr:
                    function.linkage = "private"
        builder = create_pass_builder(self._codegen._tm, _tuning())
        manager = builder.getModulePassManager()
        manager.add_refprune_pass(_parse_refprune_flags())
        manager.run(self._final_module, builder)


class InnerLibrary(LinkedLibrary):
    """The code of a function that only compiled code calls."""

    inner = True

    def finalize(self) -> None:
        """Link what it calls; optimize and translate nothing."""
        self._raise_if_finalized()  # type: ignore[no-untyped-call]
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._finalized = True

    def serialize_using_object_code(self) -> Any:
        """The content of the cache's file: the module, no machine code."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return self.name, "object", (b"", self._get_module_for_linking().as_bitcode())  # type: ignore[no-untyped-call]


def without_code(library: Any, descriptor: Any, environment: Any) -> Any:
    """Numba's handle of a function that has no machine code; it is never called."""
    name, module = descriptor.qualname.rpartition(".")[2], descriptor.lookup_module()
    return _dynfunc.make_function(module, name, "", 0, environment, (library,))


@register_pass(mutates_CFG=True, analysis_only=False)
class LinkedLowering(NativeLowering):
    """Makes the code of a function, in a library of its kind."""

    _name = "sarrus_lowering"

    @property
    def lowering_class(self) -> type[RecordLowering]:
        return RecordLowering

    def run_pass(self, state: Any) -> bool:
        inner = state.flags.no_cpython_wrapper
        kind: Any = InnerLibrary if inner else LinkedLibrary
        state.library = kind(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.no_compile = inner
        super().run_pass(state)  # type: ignore[no-untyped-call]
        if inner:
            lowered = state["cr"]
            known_by = without_code(state.library, lowered.fndesc, lowered.env)
            state.targetctx.insert_user_function(known_by, lowered.fndesc, [state.library])
            state["cr"] = lowered._replace(cfunc=known_by)
        else:
            _set_environments(state.library)
        return True


def _set_environments(library: Any) -> None:
    """Let code find the environments of the functions that were linked with it."""
    for variable in library._final_module.global_variables:
        if variable.name.startswith(ENVIRONMENT) and (found := lookup_environment(variable.name)):
            library.codegen.set_env(variable.name, found)
