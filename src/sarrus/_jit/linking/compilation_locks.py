"""Locks between the processes that share a cache: one of them compiles a kernel, the others wait for it and load it.

Each kernel is a byte of one file, at an offset that follows from the kernel's name. The operating system releases the
locks of a process that ends, however it ends. A process whose child is forked meanwhile keeps its locks to itself.
Where files cannot be locked, and once it has waited in vain for a holder that does not go on, a process compiles for
itself.
"""

from __future__ import annotations

import errno
import os
import sys
import time
import zlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

PATIENCE = 300.0  # s of waiting for a holder that may be stopped
PAUSE = 0.05  # s between two attempts

if sys.platform == "win32":
    import msvcrt

    BUSY = (errno.EACCES, errno.EDEADLK)

    def _lock(file: int, offset: int, locked: bool) -> None:
        os.lseek(file, offset, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK if locked else msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    BUSY = (errno.EACCES, errno.EAGAIN)

    def _lock(file: int, offset: int, locked: bool) -> None:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB if locked else fcntl.LOCK_UN, 1, offset)


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
                _lock(self._file, _offset(name), locked=False)

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
            _lock(self._file, _offset(name), locked=True)
        except OSError as failure:
            self._useful = failure.errno in BUSY
            return self._useful
        return False


def _offset(name: str) -> int:
    return zlib.crc32(name.encode()) // 4
