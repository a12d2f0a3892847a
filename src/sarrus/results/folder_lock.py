"""A folder is written by one process at a time."""

from __future__ import annotations

import json
import os
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from .checked_file import FolderTakenError

LOCK = "lock"

if sys.platform == "win32":
    import msvcrt

    FAR = 2**30  # behind the content, which others may read

    def _try_lock(file: IO[bytes]) -> None:
        file.seek(FAR)
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError as wrong:
            raise BlockingIOError from wrong
else:
    import fcntl

    def _try_lock(file: IO[bytes]) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


class FolderLock:
    """The right to write a folder. The operating system ends it with the process, so that no dead one keeps it.

    Parameters
    ----------
    folder : in which the file `LOCK` is made; it says which process writes

    Raises
    ------
    FolderTakenError
        If another one writes.
    OSError
        If the file cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self._file = (folder / LOCK).open("a+b")
        try:
            if self._is_taken():
                told = f"{folder}: is being written by {self._writer()}."
                raise FolderTakenError(f"{told} Wait until it ends, or choose another folder.")
            self._file.truncate(0)
            own = {"process": os.getpid(), "host": socket.gethostname()}
            self._file.write(json.dumps(own).encode())
            self._file.flush()
        except BaseException:
            self._file.close()
            raise

    def _is_taken(self) -> bool:
        try:
            _try_lock(self._file)
        except BlockingIOError:
            return True
        except OSError:  # a file system without locks: what the file says must do
            process, host = self._written()
            return process > 0 and (host != socket.gethostname() or _is_alive(process))
        return False

    def _written(self) -> tuple[int, str]:
        """Process and host of the writer; 0 where there is none."""
        self._file.seek(0)
        try:
            written = json.loads(self._file.read())
            return int(written["process"]), str(written["host"])
        except (ValueError, TypeError, KeyError, OSError):
            return 0, ""

    def _writer(self) -> str:
        process, host = self._written()
        return f"process {process} on {host}" if process else "another process"

    def release(self) -> None:
        """Let others write."""
        if self._file.closed:
            return
        with suppress(OSError):
            self._file.truncate(0)
        self._file.close()


@contextmanager
def held(lock: FolderLock) -> Iterator[FolderLock]:
    """Work after which a lock is held, but released where something goes wrong."""
    try:
        yield lock
    except BaseException:
        lock.release()
        raise


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, if they are not there.

    Raises
    ------
    FolderTakenError
        If one of them is a file.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        told = f"{folder}: is a file, not a folder, or below a file."
        raise FolderTakenError(f"{told} Choose another folder.") from None


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
