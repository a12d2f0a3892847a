"""Folders that no other user can write: compiled code is loaded from such a folder only."""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def private(folder: Path) -> bool:
    """Whether a folder is the user's own, and neither it nor a folder above it can be written by another user.

    The owner of this package is trusted with the folders above, as the superuser is: either could change the package.
    Systems without owners of this kind (Windows) keep users apart by themselves.
    """
    if not hasattr(os, "geteuid"):
        return True
    here = folder.lstat()
    if not stat.S_ISDIR(here.st_mode) or here.st_uid != os.geteuid() or here.st_mode & OTHERS_WRITE:
        return False
    trusted = {0, os.geteuid(), PACKAGE.stat().st_uid}
    return all(_safe(above.lstat(), trusted) for above in folder.parents)


def _safe(found: os.stat_result, trusted: set[int]) -> bool:
    """Whether only trusted users can rename what is in a folder; in one with the sticky bit, owners alone can."""
    return found.st_uid in trusted and (
        not found.st_mode & OTHERS_WRITE or bool(found.st_mode & stat.S_ISVTX)
    )


def made_private(folder: Path) -> bool:
    """Make a folder, with those above it, that only the user can enter; return whether it can be used."""
    try:
        for above in reversed([here for here in folder.parents if not here.exists()]):
            above.mkdir(exist_ok=True, mode=0o755)  # one by one: `parents` would leave the mode to the umask
        folder.mkdir(exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder):
            return private(folder)
    except OSError:
        return False
