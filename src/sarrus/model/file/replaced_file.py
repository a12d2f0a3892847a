"""Files that are written beside an earlier one and then replace it, which is lost only to a whole new file."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EACCES
from pathlib import Path
from threading import get_ident


@contextmanager
def replacing(path: Path, draft: Path | None = None) -> Iterator[Path]:
    """Yield where to write a file, which replaces the earlier one at the end of the block, if that does not fail.

    The target of a link is replaced, with its permissions; devices and pipes are written directly.

    Parameters
    ----------
    draft : where it is written; by default in the same folder, with the same ending

    Raises
    ------
    OSError
        If it cannot be written.
    """
    place = Path(os.path.realpath(path))
    if place.exists() and not place.is_file():
        yield path
        return
    if place.exists() and not os.access(place, os.W_OK):
        raise PermissionError(EACCES, os.strerror(EACCES), str(path))
    draft = draft or place.with_name(f".sarrus-{os.getpid()}-{get_ident()}{place.suffix}")
    try:
        yield draft
        if place.exists():
            shutil.copymode(place, draft)
        draft.replace(place)
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
