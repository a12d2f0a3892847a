"""Locks of files between processes, which the operating system releases when their process ends."""

from __future__ import annotations

import errno
import os
import sys

if sys.platform == "win32":
    import msvcrt

    BUSY = (errno.EACCES, errno.EDEADLK)
    FAR = 2**30  # behind the content, which others may read

    def lock_byte(file: int, offset: int, locked: bool) -> None:
        """Lock or unlock a byte of a file without waiting; an OSError of a number in `BUSY` if another has it."""
        os.lseek(file, offset, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK if locked else msvcrt.LK_UNLCK, 1)

    def lock_file(file: int) -> None:
        """Lock a file until it is closed, without waiting; an OSError of a number in `BUSY` if another has it."""
        lock_byte(file, FAR, True)

else:
    import fcntl

    BUSY = (errno.EACCES, errno.EAGAIN)

    def lock_byte(file: int, offset: int, locked: bool) -> None:
        """Lock or unlock a byte of a file without waiting; an OSError of a number in `BUSY` if another has it."""
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB if locked else fcntl.LOCK_UN, 1, offset)

    def lock_file(file: int) -> None:
        """Lock a file until it is closed, without waiting; an OSError of a number in `BUSY` if another has it."""
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
