"""The sources on which compiled kernels depend."""

from __future__ import annotations

import hashlib
from pathlib import Path

from .folders import PACKAGE

SOURCES = ("_jit/**/*.py", "algebra.py", "euler.py", "elements/**/*.py", "system/structure/group.py")
NO_KERNELS = (  # these store and find kernels; what the others make is named by all that it depends on
    "_jit/linking/cache.py",
    "_jit/linking/compilation.py",
    "_jit/linking/compilation_locks.py",
    "_jit/linking/folders.py",
    "_jit/linking/link.py",
    "_jit/linking/processor.py",
    "_jit/linking/reference_counts.py",
    "_jit/linking/shipped.py",
    "_jit/linking/sources.py",
    "_jit/kernels/bound.py",
    "_jit/kernels/scalars.py",
)


def sources_digest(package: Path = PACKAGE) -> bytes:
    """Hash of the layers in which kernels are written, recorded and put together; paths and times do not enter."""
    digest = hashlib.sha256()
    for source in sorted(file for pattern in SOURCES for file in package.glob(pattern)):
        name = source.relative_to(package).as_posix()
        if name not in NO_KERNELS:
            digest.update(name.encode() + source.read_bytes())
    return digest.digest()
