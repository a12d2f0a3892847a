"""Locks between the processes that share a cache: one of them compiles a kernel, the others wait for it and load it.

Each kernel is a byte of one file, at an offset that follows from the kernel's name. The operating system releases the
locks of a process that ends, however it ends. A process whose child is forked meanwhile keeps its locks to itself.
Where files cannot be locked, and once it has waited in vain for a holder that does not go on, a process compiles for
itself.
"""

from __future__ import annotations

import os
import time
import zlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from .file_locks import BUSY, lock_byte

PATIENCE = 300.0  # s of waiting for a holder that may be stopped
PAUSE = 0.05  # s between two attempts


class CompilationLocks:
    """The locks of one folder. Its file stays open: closing it would release all locks of the process."""

    def __init__(self, folder: Path) -> None:
        self._file: int | None = None
        self._useful = True  # until locking is refused, or a holder does not go on
        with suppress(OSError):
            self._file = os.open(folder / "compiling.lock", os.O_RDWR | os.O_CREAT, 0o600)

    def acquire(self, name: str, waiting: Callable[[float], None]) -> None:
        """Lock a kernel as soon as no other process compiles it, or go on without a lock.

        ``waiting`` is called from time to time, with the seconds of waiting.
        """
        began = time.monotonic()
        while self._useful and self._is_busy(name):
            waited = time.monotonic() - began
            self._useful = waited < PATIENCE
            if self._useful:
                waiting(waited)
                time.sleep(PAUSE)

    def release(self, name: str) -> None:
        """Unlock a kernel."""
        if self._file is not None:
            with suppress(OSError):
                lock_byte(self._file, _offset(name), locked=False)

    def close(self) -> None:
        """Release all locks, and take none from now on."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _is_busy(self, name: str) -> bool:
        """Whether another process holds the lock; if not, this one does from now on, where files can be locked."""
        if self._file is None:
            return False
        try:
            lock_byte(self._file, _offset(name), locked=True)
        except OSError as failure:
            self._useful = failure.errno in BUSY
            return self._useful
        return False


def _offset(name: str) -> int:
    return zlib.crc32(name.encode()) // 4
