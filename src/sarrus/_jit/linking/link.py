"""Linker of compiled functions: a marked function is compiled at first use, with all that its globals name.

A loop is written as ordinary functions that call each other, each marked with `compiled`. They import what they call,
so that readers, editors and type checkers can follow a call to its definition; as plain Python they run as they are.
`link` resolves the globals of a function, and of those that it calls, and compiles copies of them. No module changes.

A compiled function is named, and cached, by its code and by everything that its globals resolve to.
"""

from __future__ import annotations

import builtins
import dis
import functools
import hashlib
import threading
import types
from collections.abc import Callable, Iterator
from typing import Any, TypeVar, overload

import numpy as np
from numba import njit
from numba.core.types import unliteral

from .cache import KernelCache
from .compiler import LinkedCompiler

F = TypeVar("F", bound=Callable[..., Any])
Function = Callable[..., Any]
CONSTANTS = (bool, int, float, complex, str, type(None), np.generic)
COMMON: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
COMPILER = __package__.rpartition(".")[0]
LIBRARIES = ("math", "cmath", "numpy")  # modules whose functions compiled code may call
LINKING = threading.RLock()
_entries: dict[Function, bool] = {}  # marked functions, and whether they count references
_linked: dict[str, Any] = {}  # compiled functions by name
_links: dict[tuple[Function, bool], Any] = {}  # what `link` has returned


@overload
def compiled(function: F) -> F: ...
@overload
def compiled(*, entry: bool) -> Callable[[F], F]: ...
def compiled(function: F | None = None, *, entry: bool = False) -> F | Callable[[F], F]:
    """Mark a function as one that is compiled; it stays a plain function.

    Parameters
    ----------
    entry : whether it counts references, as it makes arrays or returns them, and is an entry for all that call it. The
        others are entries where Python calls them (`link`). Where compiled code calls them, they are compiled in half
        the time: they have no second entry for Python, to which long lists of arrays are costly. An entry cannot call
        them if they return (parts of) arrays, nor can they call an entry that returns one.
    """

    def mark(marked: F) -> F:
        _entries[marked] = entry
        return marked

    return mark if function is None else mark(function)


def link(function: F, *, entry: bool = True) -> F:
    """The compiled form of a function that is marked with `compiled`.

    Parameters
    ----------
    entry : whether Python calls it, or only the code of an entry, which has it in its own machine code

    Raises
    ------
    TypeError
        If a global is neither marked nor a constant, a record, or a library of mathematics; or, when it is first called
        and types are known, if functions that count references exchange arrays with functions that do not.
    """
    found = _links.get((function, entry))
    if found is None:
        with LINKING:
            found = _links.setdefault((function, entry), _Linker().linked(function, entry))
    return found


def fingerprint(function: Function) -> str:
    """The name of the compiled form of a marked function, which identifies all that it depends on."""
    return _Linker().name(function, entry=True)


def marked() -> list[Function]:
    """All marked functions of the modules that have been imported."""
    return list(_entries)


class _Linker:
    """Resolves a function, and those that it calls, by what their globals are now."""

    def __init__(self) -> None:
        self._names: dict[tuple[Function, bool], str] = {}
        self._open: list[Function] = []  # whose globals are being resolved

    def linked(self, function: Function, entry: bool) -> Any:
        """The compiled function."""
        name = self.name(function, entry)
        if name not in _linked:
            scope = {key: self._value(value) for key, value in self._globals(function).items()}
            _linked[name] = _compiled(function, name, scope, _options(function, entry))
        return _linked[name]

    def name(self, function: Function, entry: bool) -> str:
        """The function's name and a digest of its code and its globals."""
        key = function, entry
        if key not in self._names:
            self._names[key] = self._digested(function, entry)
        return self._names[key]

    def _digested(self, function: Function, entry: bool) -> str:
        _check_marked(function)
        if function in self._open:
            path = " → ".join(f.__name__ for f in [*self._open, function])
            raise TypeError(
                f"{function.__module__}: compiled functions call each other in a circle: {path}. Write one as a loop."
            )
        self._open.append(function)
        content = (
            function.__module__,
            _code(function),
            getattr(function, "__defaults__", None),
            {key: self._token(function, key, value) for key, value in self._globals(function).items()},
            _options(function, entry),
        )
        self._open.pop()
        return f"{function.__name__}_{hashlib.sha256(repr(content).encode()).hexdigest()[:12]}"

    def _globals(self, function: Function) -> dict[str, Any]:
        """The linked values of the function's globals, by name."""
        scope = function.__globals__
        found = {}
        for name in sorted(_global_names(function.__code__)):
            if name in scope:
                found[name] = scope[name]
            elif not hasattr(builtins, name):
                raise TypeError(
                    f"{function.__module__}.{function.__name__}: {name} is not defined. Import it."
                )
        return found

    def _value(self, value: Any) -> Any:
        return self.linked(value, _entries[value]) if _is_marked(value) else value

    def _token(self, function: Function, name: str, value: Any) -> object:
        """A token that identifies the value of a global."""
        if _is_marked(value):
            return self.name(value, _entries[value])
        known = _token(value)
        if known is None:
            raise TypeError(
                f"{function.__module__}.{function.__name__}: {name} is neither a compiled function nor a constant. "
                "Mark a function with `compiled`, or pass a value as an argument."
            )
        return known


def _is_marked(value: Any) -> bool:
    return isinstance(value, types.FunctionType) and value in _entries


def _check_marked(function: Function) -> None:
    if not _is_marked(function):
        name = getattr(function, "__name__", repr(function))
        raise TypeError(f"{name} cannot be linked. Mark it with `compiled`.")
    if function.__code__.co_freevars:
        names = ", ".join(function.__code__.co_freevars)
        raise TypeError(f"{function.__name__} uses {names} of an enclosing function. Pass it as an argument.")


def _token(value: Any) -> object:
    """A token of a value that is no marked function; None if compiled code cannot depend on it."""
    if isinstance(value, CONSTANTS):
        return type(value).__name__, repr(value)
    if isinstance(value, tuple) and type(value) is tuple:
        found = [_token(part) for part in value]
        return None if None in found else tuple(found)
    if isinstance(value, types.ModuleType):
        return (
            value.__name__ if value.__name__ in LIBRARIES else None
        )  # others may hold what is to be resolved
    name = getattr(value, "__module__", ""), getattr(value, "__qualname__", getattr(value, "__name__", ""))
    if isinstance(value, type):
        return *name, getattr(value, "_fields", ())
    return name if name[0].startswith(f"{COMPILER}.") else None  # their sources name the folder of the cache


@functools.cache
def _global_names(code: types.CodeType) -> frozenset[str]:
    own = {code.co_names[n >> 1] for n in _arguments(code.co_code, dis.opmap["LOAD_GLOBAL"])}
    inner = (_global_names(part) for part in code.co_consts if isinstance(part, types.CodeType))
    return frozenset(own).union(*inner)


def _arguments(instructions: bytes, wanted: int) -> Iterator[int]:
    """The arguments of all instructions of one kind, ten times as fast as `dis` finds them."""
    high = 0
    for operation, low in zip(instructions[::2], instructions[1::2], strict=True):
        argument = high | low
        high = argument << 8 if operation == dis.EXTENDED_ARG else 0
        if operation == wanted:
            yield argument


def _code(function: Function) -> object:
    """The code of a function without its documentation, annotations and place in the file."""
    return _content(function.__code__, function.__doc__)


def _content(code: types.CodeType, documentation: str | None = None) -> object:
    constants = [_content(part) if isinstance(part, types.CodeType) else part for part in code.co_consts]
    if documentation is not None and constants[:1] == [documentation]:
        constants[0] = None
    return code.co_code, constants, code.co_names, code.co_varnames, code.co_argcount, code.co_flags


def _options(function: Function, entry: bool) -> dict[str, Any]:
    """How a function is compiled."""
    wrapper = {} if entry else {"no_cpython_wrapper": True}
    return COMMON | wrapper | ({} if entry and _entries[function] else {"_nrt": False})


def _compiled(function: Function, name: str, scope: dict[str, Any], options: dict[str, Any]) -> Any:
    """A copy of a function with other globals, compiled at its first call or found in the cache."""
    scope = {**scope, "__name__": function.__module__, "__builtins__": builtins}
    copy = types.FunctionType(function.__code__, scope, name, function.__defaults__)
    copy.__qualname__ = name
    compiler: Any = njit
    result = compiler(**options, pipeline_class=LinkedCompiler)(copy)
    result._cache = KernelCache(copy)
    _compile_once_for_all_constants(result._compiler)
    return result


def _compile_once_for_all_constants(compiler: Any) -> None:
    """Let arguments that are constants where a function is called have the types of others; Numba compiles for each."""
    folded = compiler.fold_argument_types

    def fold_argument_types(*call: Any) -> tuple[Any, tuple[Any, ...]]:
        signature, kinds = folded(*call)
        return signature, tuple(unliteral(kind) for kind in kinds)

    compiler.fold_argument_types = fold_argument_types
