"""A folder is written by one process at a time."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import chain
from pathlib import Path

from ...model import SarrusError
from .checked_file import FolderTakenError

LOCK = "lock"


class FolderLock:
    """The right to write a folder. The operating system ends it with the process, so that no dead one keeps it.

    Parameters
    ----------
    folder : in which the file `LOCK` is created; it names the process that writes

    Raises
    ------
    FolderTakenError
        If another one writes.
    OSError
        If the file cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / LOCK
        self._file = self._path.open("a+b")
        try:
            self._take(folder)
        except BaseException:
            self._file.close()
            raise

    def _take(self, folder: Path) -> None:
        """Lock the file, which its last owner may have removed after it was opened here; then the new one."""
        while True:
            if self._is_taken():
                message = f"{folder}: is being written by {self._writer()}."
                raise FolderTakenError(f"{message} Wait until it ends, or choose another folder.")
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(self._file.fileno()), self._path.stat()):
                    break
            self._file.close()
            self._file = self._path.open("a+b")
        self._file.truncate(0)
        self._file.write(json.dumps({"process": os.getpid(), "host": socket.gethostname()}).encode())
        self._file.flush()

    def _is_taken(self) -> bool:
        from filelock import lock_descriptor  # its import takes longer than that of Sarrus

        try:
            return not lock_descriptor(self._file.fileno(), blocking=False)
        except OSError:  # on a file system without locks the content of the file must do
            process, host = _writer_in(self._path)
            return process > 0 and (host != socket.gethostname() or _is_alive(process))

    def _writer(self) -> str:
        process, host = _writer_in(self._path)
        return f"process {process} on {host}" if process else "another process"

    def release(self) -> None:
        """Let others write."""
        if not self._file.closed:
            with suppress(OSError):
                self._path.unlink()
            self._file.close()

    def abandon(self) -> None:
        """Let others write; the empty file stays, and shows that the folder is ours before it holds anything else."""
        with suppress(OSError):
            self._file.truncate(0)
        self._file.close()


def is_lock(path: Path) -> bool:
    """Whether a file is the lock of a process, dead or alive; an empty one is that of a process that died early."""
    return path.is_file() and (not path.stat().st_size or _writer_in(path)[0] > 0)


def _writer_in(path: Path) -> tuple[int, str]:
    """Process and host of the writer; 0 where there is none."""
    try:
        written = json.loads(path.read_bytes())
        return int(written["process"]), str(written["host"])
    except (ValueError, TypeError, KeyError, OSError):
        return 0, ""


@contextmanager
def held(lock: FolderLock) -> Iterator[FolderLock]:
    """Work after which a lock is held; released where something is refused, abandoned where anything else happens."""
    try:
        yield lock
    except SarrusError:
        lock.release()
        raise
    except BaseException:
        lock.abandon()
        raise


def lock_folder(folder: Path) -> FolderLock:
    """The right to write a folder, which is made with those above it if it is not there.

    Raises
    ------
    FolderTakenError
        If one of them is a file, it contains links, through which other data could be changed, or another process
        writes.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        message = f"{folder}: is a file, not a folder, or below a file."
        raise FolderTakenError(f"{message} Choose another folder.") from None
    for path in chain(folder.iterdir(), folder.glob("*/*")):
        if Path(os.path.realpath(path.parent)) / path.name != Path(os.path.realpath(path)):
            message = f"{path}: is a link to data elsewhere, which is not touched."
            raise FolderTakenError(f"{message} Replace it by a copy, or choose another folder.")
    return FolderLock(folder)


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
