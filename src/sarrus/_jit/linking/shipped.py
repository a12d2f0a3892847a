"""Compiled kernels of a wheel: read-only, in the package's own folder, each with its hash.

``_kernels/LEVEL/`` holds ``kernels.bin``, all kernels one after another, compressed, and ``index.json``: where each
begins, its size, and the hash by which it is verified when it is read. They are used if this processor has the level
and they were compiled from these sources, by these versions of Python, Numba and llvmlite. All others are compiled.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
import zlib
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba

from .folders import PACKAGE
from .processor import CONFIG, LANES, lanes_of_target, levels, triple
from .sources import sources_digest

FOLDER = "_kernels"
INDEX, CONTENT = "index.json", "kernels.bin"
Entry = tuple[int, int, str]


class Shipped:
    """The kernels of one level.

    Attributes
    ----------
    level : its name
    lanes : of kernels in lanes
    """

    def __init__(
        self, folder: Path, level: str, lanes: int, built_on: str, entries: dict[str, Entry]
    ) -> None:
        self.level, self.lanes, self._built_on = level, lanes, built_on
        self._file, self._entries = folder / CONTENT, entries

    def magic_tuple(self) -> tuple[str, str, str]:
        """The compiler with which the kernels were made, as Numba's cache names it."""
        return self._built_on, self.level, ""

    def read(self, name: str) -> bytes | None:
        """The content of a file, None if there is none or if its hash differs."""
        if name not in self._entries:
            return None
        start, size, digest = self._entries[name]
        with suppress(OSError, zlib.error), self._file.open("rb") as stream:
            stream.seek(start)
            found = stream.read(size)
            if hashlib.sha256(found).hexdigest() == digest:
                return zlib.decompress(found)
        return None


def identity(level: str, package: Path = PACKAGE) -> str:
    """Hash of all that the kernels of a level depend on, on every machine that has the level.

    The version of NumPy is not among it: kernels use its arrays as the binary interface of NumPy 2 defines them.
    """
    system = re.sub(r"(?<=darwin|macosx)[0-9.]+$", "", triple())  # of macOS the triple names the release, too
    python = f"{sys.implementation.cache_tag}{getattr(sys, 'abiflags', '')}"
    parts = (python, numba.__version__, llvmlite.__version__, system, level)
    return hashlib.sha256(repr(parts).encode() + sources_digest(package)).hexdigest()


@cache
def shipped(package: Path = PACKAGE) -> Shipped | None:
    """The kernels of the best level that this processor has, None if the package has none that fit."""
    for level in levels():
        folder = package / FOLDER / level.name
        usable = CONFIG.CPU_NAME in (None, level.name) and os.environ.get(LANES) in (None, str(level.lanes))
        if usable and (folder / INDEX).is_file():
            found = _read(folder)
            if found.get("identity") == identity(level.name, package):
                return Shipped(folder, level.name, level.lanes, found["triple"], found["entries"])
    return None


def _read(folder: Path) -> dict[str, Any]:
    with suppress(OSError, ValueError):
        found = json.loads((folder / INDEX).read_text(encoding="ascii"))
        return found if isinstance(found, dict) else {}
    return {}


def lanes() -> int:
    """How many lanes kernels in lanes have: those of the package's kernels, or as many as suit the processor."""
    found = shipped()
    return found.lanes if found else lanes_of_target()


def pack(files: Iterable[tuple[str, bytes]], folder: Path, level: str) -> int:
    """Write the kernels of a level; return their size in bytes."""
    folder.mkdir(parents=True)
    entries: dict[str, Entry] = {}
    size = 0
    with (folder / CONTENT).open("wb") as stream:
        for name, content in sorted(files):
            packed = zlib.compress(content, 9)
            entries[name] = size, len(packed), hashlib.sha256(packed).hexdigest()
            size += stream.write(packed)
    index = {"identity": identity(level), "triple": triple(), "entries": entries}
    (folder / INDEX).write_text(json.dumps(index), encoding="ascii")
    return size
