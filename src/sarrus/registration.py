"""Import of every module of a folder, whose classes and functions register themselves."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pkgutil import iter_modules


def import_modules(package: str, folder: Iterable[str]) -> tuple[str, ...]:
    """Import every module of a package, given by name and ``__path__``, and return their names."""
    names = tuple(sorted(module.name for module in iter_modules(folder)))
    for name in names:
        import_module(f"{package}.{name}")
    return names
