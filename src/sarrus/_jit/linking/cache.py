"""Cache of compiled kernels on disk, and its dependence on sources, versions and processor.

Numba looks at one file's time stamp; an edit in any other file would leave callers with old formulas. The folder is
therefore named by everything that a kernel depends on: the sources of the layers in which kernels are written, recorded
and put together, the versions, and the processor. A kernel is a file of its own, named by function and signature, with
a checksum: processes and versions that share the folder cannot mix theirs, and a damaged file is compiled again.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import os
import pickle
import shutil
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.event import Listener, register
from numba.core.runtime.nrt import rtsys

from .compilation import Compilation
from .compilation_locks import CompilationLocks
from .folders import PACKAGE, made_private
from .processor import target
from .shipped import lanes, shipped
from .sources import sources_digest
from .stored_library import Loading, StoredCode

STALE_AFTER = 14 * 86400.0
LARGEST = 1000.0  # [MB] of the kernels of a version, unless SARRUS_CACHE_SIZE is set
DIGEST = hashlib.sha256().digest_size


def fingerprint(package: Path = PACKAGE) -> str:
    """Hash of the kernels' sources, the versions of Python, Numba, llvmlite and NumPy, the processor and the lanes."""
    digest = hashlib.sha256()
    for part in (
        sys.version,
        numba.__version__,
        llvmlite.__version__,
        np.__version__,
        *target(),
        str(lanes()),
    ):
        digest.update(part.encode())
    digest.update(sources_digest(package))
    return digest.hexdigest()[:20]


def candidates() -> list[Path]:
    """Folders to try, best first: beside the package, the user's cache, the user's own in the temporary folder."""
    owner = f"-{os.geteuid()}" if hasattr(os, "geteuid") else ""
    user = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or _home() / ".cache"
    places = [PACKAGE / "__pycache__", Path(user) / "sarrus", Path(tempfile.gettempdir()) / f"sarrus{owner}"]
    return [place.resolve() for place in places]


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError:  # a user without a home
        return Path(tempfile.gettempdir())


@cache
def folder() -> Path:
    """The folder of this version's compiled kernels: ``SARRUS_CACHE_DIR``, or the first candidate.

    One that cannot be written, or that another user could write, is passed over.
    """
    name = f"kernels-{fingerprint()}"
    for place in [*_chosen(name), *candidates()]:
        if made_private(place / name):
            _forget_stale(place, keep=name)
            return place / name
    return _temporary()


def _chosen(name: str) -> list[Path]:
    """The folder that ``SARRUS_CACHE_DIR`` names, with a warning if it cannot be used."""
    text = os.environ.get("SARRUS_CACHE_DIR")
    place = Path(text).resolve() if text else None
    if place and not made_private(place / name):
        message = (
            f"SARRUS_CACHE_DIR: {place} cannot be written, or can be written by other users, and is not used. "
            "Give a folder that only you can write."
        )
        warnings.warn(message, RuntimeWarning, stacklevel=2)
    return [place] if place else []


def _temporary() -> Path:
    """A folder of this process alone, removed at its end."""
    made, maker = Path(tempfile.mkdtemp(prefix="sarrus-")), os.getpid()
    atexit.register(lambda: shutil.rmtree(made, ignore_errors=True) if os.getpid() == maker else None)
    return made


def _forget_stale(place: Path, keep: str) -> None:
    """Remove folders of other versions that nobody has used for two weeks; another process may do so too."""
    for other in place.glob("kernels-" + "[0-9a-f]" * 20):
        with suppress(OSError):
            if other.name == keep:
                os.utime(other)
            elif time.time() - other.stat().st_mtime > STALE_AFTER:
                shutil.rmtree(other, ignore_errors=True)


def shrink(place: Path, most: float) -> None:
    """Remove the least recently used kernels beyond so many bytes; they are compiled again where they are needed."""
    files, total = list[tuple[float, int, Path]](), 0
    for file in place.glob("*.kernel"):
        with suppress(OSError):  # another process has removed it
            found = file.stat()
            files.append((found.st_mtime, found.st_size, file))
    for _, size, file in sorted(files, reverse=True):
        total += size
        if total > most:
            with suppress(OSError):
                file.unlink(missing_ok=True)


@cache
def _bound() -> None:
    """Bound the size of the folder when this process ends, once it has stored a kernel."""
    atexit.register(shrink, folder(), float(os.environ.get("SARRUS_CACHE_SIZE") or LARGEST) * 1e6)


def _sealed(content: bytes) -> bytes:
    return hashlib.sha256(content).digest() + content


def _opened(file: Path) -> bytes:
    """The content of a file without its checksum; a ValueError if it is damaged, an OSError if there is none."""
    found = file.read_bytes()
    if hashlib.sha256(found[DIGEST:]).digest() != found[:DIGEST]:
        raise ValueError(f"{file} is damaged. Remove it; it is made anew.")
    return found[DIGEST:]


def contents(place: Path) -> Iterator[tuple[str, bytes]]:
    """Names and contents of all that is stored in a folder, without what is damaged."""
    for file in sorted([*place.glob("*.kernel"), *place.glob("*.value")]):
        with suppress(OSError, ValueError):
            yield file.name, _opened(file)


def _shipped(name: str) -> bytes | None:
    """The content of a file of the package's kernels."""
    ready = shipped()
    return ready.read(name) if ready else None


def stored_value(name: str, make: Callable[[], Any]) -> Any:
    """A plain value that depends on the sources alone, found in the folder under a name, or made and stored there."""
    file = folder() / f"{name}.value"
    with suppress(OSError, ValueError):
        return json.loads(_opened(file))
    if ready := _shipped(file.name):
        return json.loads(ready)
    value = make()
    with suppress(OSError):
        draft = file.with_name(f"{file.name}.{os.getpid()}")
        draft.write_bytes(_sealed(json.dumps(value).encode("ascii")))
        draft.replace(file)
    return value


@cache
def _locks() -> CompilationLocks:
    return CompilationLocks(folder())


class _Locator:
    """Location and version of stored functions, for Numba's cache (`numba.core.caching` protocol)."""

    @classmethod
    def from_function(cls, function: Any, file: str) -> _Locator:
        return cls()

    def ensure_cache_path(self) -> None:
        with suppress(OSError):
            folder().mkdir(parents=True, exist_ok=True, mode=0o700)

    def get_cache_path(self) -> str:
        return str(folder())

    def get_source_stamp(self) -> str:
        return folder().name

    def get_disambiguator(self) -> str:
        return "kernel"


class _Implementation(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # type: ignore[list-item]  # noqa: RUF012

    def reduce(self, cres: Any) -> Any:
        """Stored form of a compiled function, without Numba's annotated listing."""
        serialized, description, *others = super().reduce(cres)  # type: ignore[no-untyped-call]
        return (StoredCode.of(cres.library, serialized), description, *others[:4], "", *others[5:])

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """The compiled function from what is stored of it."""
        return Loading(target_context).result(payload)


class _Files(IndexDataCacheFile):
    """The compiled kernels of one function, a file for each key; there is no index that could be damaged."""

    def save(self, key: str, data: Any) -> None:
        with suppress(OSError), self._open_for_write(str(self.file(key))) as stream:
            stream.write(_sealed(self._dump(data)))  # type: ignore[no-untyped-call]
            _bound()

    def load(self, key: str) -> Any:
        with suppress(OSError, ValueError):
            content = _opened(self.file(key))
            os.utime(self.file(key))  # the time of its last use, see `shrink`
            return pickle.loads(content)
        return None

    def flush(self) -> None:
        """Remove the kernels of the function."""
        for file in Path(self._cache_path).glob(f"{Path(self._index_name).stem}.*.kernel"):
            file.unlink(missing_ok=True)

    def file(self, key: str) -> Path:
        """Where a kernel is stored."""
        return Path(self._cache_path) / f"{Path(self._index_name).stem}.{key[:24]}.kernel"


class KernelCache(FunctionCache):
    """Numba's function cache, in our folder and files.

    Other versions of the package may have the same kernels, but other records of arrays: records with the same names
    but different fields have different keys, and a kernel whose records are no longer there is compiled again.
    """

    _impl_class = _Implementation

    def __init__(self, function: Any) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        base = self._impl.filename_base
        self._cache_file = self._files = _Files(self._cache_path, base, folder().name)  # type: ignore[no-untyped-call]
        self._locked: str | None = None

    def _index_key(self, sig: Any, codegen: Any) -> str:
        whole = super()._index_key(sig, codegen), tuple(_fields(kind) for kind in sig)  # type: ignore[no-untyped-call]
        return hashlib.sha256(repr(whole).encode()).hexdigest()

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        """The user's own kernel, which is compiled for this very processor, or that of the package."""
        found = super()._load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        ready = shipped()
        if found is not None or ready is None:
            return found
        content = ready.read(self._files.file(self._index_key(sig, ready)).name)
        return content and self._impl.rebuild(target_context, pickle.loads(content))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The kernel from disk; None if it is not there, and then it is locked for this process until `release`."""
        found = self._loaded(sig, target_context)
        if found is None:
            file = self._files.file(self._index_key(sig, target_context.codegen()))
            try:
                self._lock(file.name)
                found = self._loaded(sig, target_context) if file.exists() else None
            except BaseException:
                self.release()
                raise
        if found is not None:
            self.release()
        return found

    def _loaded(self, sig: Any, target_context: Any) -> Any:
        """The kernel from disk; None if it is not there.

        Numba would first register all functions that it can compile, which takes longer than loading a hundred kernels.
        Loading needs its allocator only; whoever compiles registers them (`Compiler.__init__`).
        """
        with suppress(ImportError, AttributeError), self._guard_against_spurious_io_errors():
            rtsys.initialize(target_context)
            return self._load_overload(sig, target_context)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store a kernel, which other processes may wait for."""
        try:
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
        finally:
            self.release()

    def release(self) -> None:
        """Unlock the kernel that is now stored, or could not be compiled."""
        if self._locked is not None:
            _locks().release(self._locked)
            self._locked = None

    def _lock(self, name: str) -> None:
        self._locked = name
        with _shown.waiting() as show:
            _locks().acquire(name, show)


_shown = Compilation()


class _Compilations(Listener):
    """Reports each kernel that Numba compiles, since the cache does not have it."""

    def on_start(self, event: Any) -> None:
        if isinstance(event.data["dispatcher"]._cache, KernelCache):
            _shown.begin(event.data["dispatcher"])

    def on_end(self, event: Any) -> None:
        kernel = event.data["dispatcher"]
        if isinstance(kernel._cache, KernelCache):
            success = tuple(event.data["args"]) in kernel.overloads  # Numba's `is_failed` has the sign wrong
            _shown.end(success)
            if not success:
                kernel._cache.release()


register("numba:compile", _Compilations())


def _fields(kind: Any) -> Any:
    """The class of a record, the names of its fields, and those of the records in it."""
    if not (hasattr(kind, "fields") and hasattr(kind, "types")):
        return None
    record = getattr(kind, "instance_class", None)
    parts = tuple((name, _fields(part)) for name, part in zip(kind.fields, kind.types, strict=True))
    return getattr(record, "__module__", ""), getattr(record, "__qualname__", ""), parts
