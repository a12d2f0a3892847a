"""Locks between the processes that share a cache: one of them compiles a kernel, the others wait for it and load it.

The operating system releases the locks of a process that ends, however it ends. Where files cannot be locked, and once
it has waited in vain for a holder that does not go on, a process compiles for itself.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

PATIENCE = 300.0  # s of waiting for a holder that may be stopped
PAUSE = 0.05  # s between two attempts


class CompilationLocks:
    """The locks of one folder, a file for each kernel."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._held: dict[str, Any] = {}
        self._useful = True  # until locking is refused, or a holder does not go on

    def acquire(self, name: str, waiting: Callable[[float], None]) -> None:
        """Lock a kernel as soon as no other process compiles it, or go on without a lock.

        ``waiting`` is called from time to time, with the seconds of waiting.
        """
        from filelock import FileLock  # its import takes longer than that of Sarrus

        began = time.monotonic()
        lock = FileLock(self._folder / f"{name}.lock")

        def waited() -> bool:
            waiting(time.monotonic() - began)
            return False

        try:
            if self._useful:
                lock.acquire(PATIENCE, PAUSE, cancel_check=waited)
                self._held[name] = lock
        except OSError:  # filelock's Timeout is one, too
            self._useful = False

    def release(self, name: str) -> None:
        """Unlock a kernel."""
        if name in self._held:
            self._held.pop(name).release()
