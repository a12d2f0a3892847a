"""Compiled code from the cache, whose LLVM module is parsed only where code is compiled that calls it.

Numba parses the module of every function that it loads and lists its symbols, which is most of the time of loading it.
Here the symbols are stored beside the code, and the module is parsed when another one is linked with it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from llvmlite.binding import Linkage, ModuleRef, parse_bitcode
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult

from .linked_library import without_code


class StoredCode(NamedTuple):
    """Stored form of a library: its name, object code, module, and the symbols that the module defines."""

    name: str
    code: bytes
    module: bytes
    symbols: tuple[str, ...]

    @classmethod
    def of(cls, library: Any, serialized: Any) -> StoredCode:
        """The stored form of a library, from Numba's serialization."""
        name, _, (code, module) = serialized
        shared = library._get_module_for_linking()
        symbols = (one for kind in (shared.global_variables, shared.functions) for one in kind)
        return cls(name, code, module, tuple(one.name for one in symbols if _is_seen(one)))


def _is_seen(symbol: Any) -> bool:
    """Whether other code finds what the module defines."""
    return not symbol.is_declaration and symbol.linkage != Linkage.private


class StoredLibrary(JITCodeLibrary):
    """A library of Numba that is made from stored code."""

    _stored: bytes | None = None
    _has_code = True
    _parsed: ModuleRef | None = None

    @classmethod
    def loaded(cls, codegen: Any, stored: StoredCode) -> StoredLibrary:
        """The library, ready to be called."""
        library = cls(codegen, stored.name)
        library._stored = stored.module
        library._has_code = bool(stored.code)
        library.enable_object_caching()  # type: ignore[no-untyped-call]
        if not stored.code:
            library._finalized = True
            return library
        library._set_compiled_object(stored.code)  # type: ignore[no-untyped-call]
        library._finalize_final_module()  # type: ignore[no-untyped-call]
        codegen._engine._defined_symbols.update(stored.symbols)
        return library

    @property
    def _shared_module(self) -> ModuleRef | None:
        if self._parsed is None and self._stored is not None:
            self._parsed = parse_bitcode(self._stored)
        return self._parsed

    @_shared_module.setter
    def _shared_module(self, module: ModuleRef | None) -> None:
        self._parsed = module


class Loading:
    """A target of compilation whose libraries are made from stored code, for `CompileResult._rebuild`."""

    def __init__(self, target: Any) -> None:
        self._target, self.typing_context = target, target.typing_context

    def codegen(self) -> Loading:
        """The same, as what makes libraries."""
        return self

    def unserialize_library(self, stored: StoredCode) -> StoredLibrary:
        """The library of stored code."""
        return StoredLibrary.loaded(self._target.codegen(), stored)

    def get_executable(self, library: Any, *function: Any) -> Any:
        """The Python function that calls the code."""
        return (
            self._target.get_executable(library, *function)
            if library._has_code
            else without_code(library, *function)
        )

    def result(self, stored: tuple[Any, ...]) -> CompileResult:
        """A compiled function from what is stored of it."""
        if not stored[0].code:
            stored = (*stored[:-1], ())  # its environments are those of the entries that it is linked with
        return CompileResult._rebuild(self, *stored)._replace(target_context=self._target)
