"""Public names of packages, which are imported when they are first used, so that importing a package is quick.

A package lists them below ``if TYPE_CHECKING`` as lines ``from .home import Name as Name``: type checkers and editors
read these lines as they are, and `names` reads them too, so that there is one list.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from os.path import dirname, exists, join
from typing import Any


def names(file: str) -> Iterator[tuple[str, str]]:
    """Yield name and home of each line ``from .model import Body as Body`` of a file, and of packages with a star."""
    if not exists(file):
        raise ImportError(
            f"{dirname(file)}: Sarrus cannot be imported from an archive. Install or unpack it."
        )
    with open(file, encoding="utf-8") as lines:
        for line in lines:
            match line.split():
                case ["from", home, "import", "*"]:
                    package = join(dirname(file), home[1:], "__init__.py")
                    yield from ((name, home) for name, _ in names(package))
                case ["from", home, "import", _, "as", name]:
                    yield name, home


def on_demand(package: str, file: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package that imports its names when they are first used."""
    home_of = dict(names(file))

    def attribute(name: str) -> Any:
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(home_of[name], package), name)
        setattr(sys.modules[package], name, value)
        return value

    return attribute
