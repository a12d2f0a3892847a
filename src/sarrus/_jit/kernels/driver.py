"""One compiled function per group of operators: it clears what is summed and runs the loop of every element type."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numba
from numba import njit
from numba.core import config as numba_config

from ..linking.cache import KernelCache
from ..linking.compiler import LinkedCompiler
from ..linking.link import COMMON
from .emit import Recording, loop

LONGEST = 60  # characters of a name: files that Numba keeps have it twice in theirs, of at most 255
COMPILING = threading.RLock()  # Numba's settings are global, and a driver is made once


@dataclass(frozen=True)
class Signature:
    """Arguments of a driver: ``driver(index, numbers, *scalars, *arrays, *outputs)``; `clears` marks the outputs that
    are set to zero first.

    `hot` drivers are compiled with LLVM's vectorizer of straight-line code: slower to compile, faster to run. In
    several `lanes` scalars are arrays too.
    """

    name: str
    scalars: tuple[str, ...]
    arrays: tuple[str, ...]
    outputs: tuple[str, ...]
    clears: tuple[bool, ...]
    hot: bool = False
    lanes: int = 1

    def types(self) -> tuple[Any, ...]:
        """The types of a driver's arguments."""
        array, table = numba.float64[::1], numba.int64[::1]
        scalar = numba.float64 if self.lanes == 1 else array
        return (
            table,
            array,
            *(scalar,) * len(self.scalars),
            *(array,) * (len(self.arrays) + len(self.outputs)),
        )


def driver(signature: Signature, recorders: Sequence[Callable[[], Recording]], clear: bool = True) -> Any:
    """Compile (or find in the cache, under the signature's name) the driver of a group.

    Parameters
    ----------
    signature : Signature
    recorders : one function per element type, each returning the type's `Recording`
    clear : whether the outputs that the signature marks are set to zero first
    """
    operands = ", ".join((*signature.scalars, *signature.arrays, *signature.outputs))
    counts = (len(signature.arrays), len(signature.scalars), len(signature.outputs), signature.lanes)
    loops = {f"loop_{n}": loop(record, *counts) for n, record in enumerate(recorders)}
    lines = [f"def driver(index, numbers, {operands}):"]
    if clear:
        lines += [
            f"    {out}[:] = 0.0"
            for out, wanted in zip(signature.outputs, signature.clears, strict=True)
            if wanted
        ]
    lines += [f"    loop_{n}(index, {n}, numbers, {operands})" for n in range(len(recorders))]
    result = compile_source(signature.name, [*lines, "    return"], loops)
    with _vectorizer(signature.hot):
        result.compile(signature.types())
    return result


@contextmanager
def _vectorizer(on: bool) -> Iterator[None]:
    """LLVM's vectorizer of straight-line code on or off; that of loops finds none in formulas of an element."""
    with COMPILING, patch.multiple(numba_config, SLP_VECTORIZE=int(on), LOOP_VECTORIZE=0):
        yield


def compile_source(name: str, lines: Sequence[str], namespace: dict[str, Any]) -> Any:
    """Compile the one function written in `lines`, or find it in the cache under `name` and its source."""
    digest = hashlib.sha256(repr((name, *lines)).encode()).hexdigest()[:16]
    name = f"{name[:LONGEST]}_{digest}"
    scope: dict[str, Any] = {}
    exec(compile("\n".join(lines), f"<{name}>", "exec"), {"__name__": __name__, **namespace}, scope)
    (function,) = scope.values()
    function.__name__ = function.__qualname__ = name
    compiler: Any = njit
    result: Any = compiler(**COMMON, pipeline_class=LinkedCompiler)(function)
    result._cache = KernelCache(function)
    return result
