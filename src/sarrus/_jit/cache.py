"""Where compiled kernels are kept, and what makes them out of date.

Numba looks at one file's time stamp; an edit in any other file would leave callers with old formulas. The folder is
therefore named by everything that a kernel depends on: the sources of the layers in which kernels are written, recorded
and put together, the versions, and the processor.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm
import numba
import numpy as np
from numba.core.caching import CompileResultCacheImpl, FunctionCache

PACKAGE = Path(__file__).resolve().parent.parent
SOURCES = ("_jit/**/*.py", "algebra.py", "euler.py", "elements/**/*.py", "system/group.py")
STALE_AFTER = 14 * 86400.0


def fingerprint(package: Path = PACKAGE) -> str:
    """Hash of the kernels' sources, the versions of Python, Numba, llvmlite and NumPy, and the processor."""
    digest = hashlib.sha256()
    for part in (sys.version, numba.__version__, llvmlite.__version__, np.__version__):
        digest.update(part.encode())
    digest.update(llvm.get_host_cpu_name().encode() + llvm.get_host_cpu_features().flatten().encode())
    for source in sorted(file for pattern in SOURCES for file in package.glob(pattern)):
        digest.update(source.relative_to(package).as_posix().encode() + source.read_bytes())
    return digest.hexdigest()[:20]


def candidates() -> list[Path]:
    """Folders to try, best first: ``SARRUS_CACHE_DIR``, beside the package, the user's cache, the temporary folder."""
    user = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
    places = [PACKAGE / "__pycache__", Path(user) / "sarrus", Path(tempfile.gettempdir()) / "sarrus"]
    chosen = os.environ.get("SARRUS_CACHE_DIR")
    return [Path(chosen), *places] if chosen else places


@cache
def folder() -> Path:
    """The folder of this version's compiled kernels: the first candidate that can be written."""
    name = f"kernels-{fingerprint()}"
    for place in candidates():
        target = place / name
        if _writable(target):
            _forget_stale(place, keep=name)
            return target
    return Path(tempfile.mkdtemp(prefix="sarrus-"))


def _writable(target: Path) -> bool:
    try:
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=target):
            return True
    except OSError:
        return False


def _forget_stale(place: Path, keep: str) -> None:
    """Remove folders of other versions that nobody has used for two weeks."""
    for other in place.glob("kernels-*"):
        if other.name == keep:
            os.utime(other)
        elif time.time() - other.stat().st_mtime > STALE_AFTER:
            shutil.rmtree(other, ignore_errors=True)


def kept(name: str, make: Callable[[], Any]) -> Any:
    """A plain value that depends on the sources alone, found in the folder under a name, or made and put there."""
    file = folder() / f"{name}.json"
    with suppress(OSError, ValueError):
        return json.loads(file.read_text(encoding="ascii"))
    value = make()
    with suppress(OSError):
        draft = file.with_name(f"{file.name}.{os.getpid()}")
        draft.write_text(json.dumps(value), encoding="ascii")
        draft.replace(file)
    return value


class _Locator:
    """Tells Numba's cache where functions are kept and how fresh they are (`numba.core.caching` protocol)."""

    @classmethod
    def from_function(cls, function: Any, file: str) -> _Locator:
        return cls()

    def ensure_cache_path(self) -> None:
        folder().mkdir(parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        return str(folder())

    def get_source_stamp(self) -> str:
        return folder().name

    def get_disambiguator(self) -> str:
        return "kernel"


class _Implementation(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # type: ignore[list-item]  # noqa: RUF012


class KernelCache(FunctionCache):
    """Numba's function cache, kept in our folder.

    Other versions of the package may have the same kernels, but other records of arrays: those that have the same names
    but other fields are told apart, and what is no longer there is forgotten.
    """

    _impl_class = _Implementation

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return super()._index_key(sig, codegen), tuple(_fields(kind) for kind in sig)  # type: ignore[no-untyped-call]

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except (ImportError, AttributeError):
            self.flush()  # type: ignore[no-untyped-call]
            return None


def _fields(kind: Any) -> Any:
    """The names of the fields of a record, and those of the records in it."""
    return (
        tuple((name, _fields(part)) for name, part in zip(kind.fields, kind.types, strict=True))
        if (hasattr(kind, "fields") and hasattr(kind, "types"))
        else None
    )
