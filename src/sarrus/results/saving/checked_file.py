"""Files with a checksum, replaced in one step: after a crash the old or the new one is there, and damage is found.

The checksum follows the content as a last line, which readers of NPZ files ignore.
"""

from __future__ import annotations

import errno
import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ...model import SarrusError
from ...model.file.replaced_file import replacing

NOT_SAVED = "not saved"  # the status where the disk is full, or the folder cannot be written
DRAFT = ".draft"  # ending of a file that is being written
SIZE = 16  # bytes of a checksum
MARK = b"\nsha256 "
SPACE, LIMIT, RIGHTS = "Free disk space", "Raise the limit of file sizes (ulimit -f)", "Make it writable"
REMEDIES = {errno.ENOSPC: SPACE, errno.EDQUOT: SPACE, errno.EFBIG: LIMIT}
REMEDIES[errno.ENOENT] = "Make its folder"
REMEDIES |= dict.fromkeys((errno.EACCES, errno.EPERM, errno.EROFS), RIGHTS)


class SavedDataError(SarrusError, ValueError):
    """Saved data that is damaged, or was written by another version."""


class NoSavedDataError(SavedDataError, FileNotFoundError):
    """A folder that does not hold the data."""


class FolderTakenError(SarrusError, FileExistsError):
    """A folder that may not be written: it holds other data, or another process writes it."""


class NotSavedError(SarrusError, OSError):
    """The disk is full, a limit is reached, or the file or folder cannot be written."""

    def __init__(self, folder: Path, wrong: OSError) -> None:
        remedy = REMEDIES.get(wrong.errno or 0, "Remedy the cause")
        message = f"{folder}: cannot be written ({wrong.strerror or wrong})."
        super().__init__(f"{message} {remedy}, or choose another place.")


@contextmanager
def writing(folder: Path) -> Iterator[None]:
    """Work on a folder in which an error of the operating system is a `NotSavedError`."""
    try:
        yield
    except SarrusError:
        raise
    except OSError as wrong:
        raise NotSavedError(folder, wrong) from None


def checksum(data: bytes) -> bytes:
    """The first bytes of SHA-256."""
    return hashlib.sha256(data).digest()[:SIZE]


def write_checked(path: Path, content: bytes) -> None:
    """Write a file with its checksum, see `replace_file`."""
    replace_file(path, content + MARK + checksum(content).hex().encode() + b"\n")


def read_checked(path: Path) -> bytes:
    """The content of a file that was written so.

    Raises
    ------
    NoSavedDataError
        If there is no such file.
    SavedDataError
        If it is damaged or cannot be read.
    """
    data = read_file(path)
    end = len(data) - len(MARK) - 2 * SIZE - 1
    content, last = data[: max(end, 0)], data[max(end, 0) :]
    if last != MARK + checksum(content).hex().encode() + b"\n":
        raise damaged(path)
    return content


def read_file(path: Path) -> bytes:
    """All bytes of a file; errors as `read_checked`."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise NoSavedDataError(f"{path}: is missing. Restore it from a copy, or compute it anew.") from None
    except OSError as wrong:
        raise SavedDataError(f"{path}: cannot be read ({wrong.strerror}). Restore it from a copy.") from None


def damaged(path: Path) -> SavedDataError:
    """The error for a file whose content is not what was written."""
    message = "is damaged: its checksum is wrong. Restore it from a copy, or compute it anew."
    return SavedDataError(f"{path}: {message}")


def replace_file(path: Path, data: bytes) -> None:
    """Write a file in one step: it is on the disk as a whole, or as it was before.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    with replacing(path, path.with_name(path.name + DRAFT)) as draft, draft.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    flush_to_disk(path.parent)


def flush_to_disk(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    if path.is_dir() and os.name != "posix":
        return  # folders cannot be flushed there
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    except OSError as wrong:
        if wrong.errno not in (errno.EINVAL, errno.ENOTSUP) or not path.is_dir():
            raise  # else a file system that does not flush folders
    finally:
        os.close(number)
