"""Pauses of Python's garbage collection, where many objects are made that all stay, and at the end of the process."""

from __future__ import annotations

import atexit
import gc
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import compress

WRITTEN = {io.BufferedWriter, io.BufferedRandom, io.TextIOWrapper}  # files that hold what is not yet written
SELDOM = (50_000, 20, 100)  # instead of 700, 10, 10
_paused = False
_frozen = False  # whether the user has frozen objects; to count them takes longer, the more they are


@contextmanager
def uncollected() -> Iterator[None]:
    """Collect nothing meanwhile: imports and loaded kernels leave no garbage, and looking for it is a tenth of them."""
    global _paused
    if not gc.isenabled():
        yield
        return
    gc.disable()
    _paused = True
    try:
        yield
    finally:
        _promote()
        _resume()


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Collect less often meanwhile: a compiler makes millions of objects that stay, and are looked at each time."""
    before = gc.get_threshold()
    if not before[0]:
        yield
        return
    gc.set_threshold(*SELDOM)
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _promote() -> None:
    """Count all objects as old, so that the next collections of young ones do not examine what was made meanwhile."""
    global _frozen
    _frozen = _frozen or gc.get_freeze_count() > 0
    if not _frozen:  # otherwise the user's frozen objects would be collected, too
        gc.freeze()
        gc.unfreeze()


def _resume() -> None:
    """End the pause; a child process does so at once, as it does not have the thread that would."""
    global _paused
    if _paused:
        _paused = False
        gc.enable()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_resume)


def _leave() -> None:
    """Leave the memory of all objects to the system: to find and free them one by one takes 0.3 s at the end.

    Files that are only in circles of references are not closed then, so what they hold is written now.
    """
    every = gc.get_objects()
    for file in compress(every, map(WRITTEN.__contains__, map(type, every))):
        with suppress(OSError, ValueError):  # a ValueError for closed files
            file.flush()
    gc.freeze()


atexit.register(_leave)
