"""A pause of Python's garbage collection, where many objects are made that all stay."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from contextlib import contextmanager

_paused = False


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
        _resume()


def _resume() -> None:
    """End the pause; a child process does so at once, as it does not have the thread that would."""
    global _paused
    if _paused:
        _paused = False
        gc.enable()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_resume)
