"""Extensions: a user's modules, imported before the command line is read. What they define registers itself.

They are the Python files in the environment variable ``SARRUS_EXTENSIONS``, separated as in ``PATH``, and the modules
that installed packages name as entry points of the group ``sarrus``.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import cast

from .parser import VERBS, Misuse, Verb

VARIABLE, GROUP = "SARRUS_EXTENSIONS", "sarrus"
VERB = ("PURPOSE", "EXAMPLES", "arguments", "run")


def load_extensions() -> None:
    """Import all extensions; those with the names of a verb are verbs.

    Raises
    ------
    Misuse
        For one that cannot be imported, or whose verb there is already.
    """
    for name, load in (*_installed(), *_files()):
        try:
            module = load()
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
            raise Misuse(f"extension {name}: {reason}. Correct it, or remove it from {VARIABLE}.") from error
        is_verb = all(hasattr(module, part) for part in VERB)
        if is_verb and VERBS.setdefault(name, cast(Verb, module)) is not module:
            raise Misuse(f"extension {name}: there is already a verb {name}. Rename the module.")


def _installed() -> Iterator[tuple[str, Callable[[], ModuleType]]]:
    return ((one.name, one.load) for one in entry_points(group=GROUP))


def _files() -> Iterator[tuple[str, Callable[[], ModuleType]]]:
    for text in filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)):
        yield Path(text).stem, partial(_import_file, Path(text).resolve())


def _import_file(file: Path) -> ModuleType:
    """The module of a file; other processes, as workers of studies, can import it, too."""
    if str(file.parent) not in sys.path:
        sys.path.append(str(file.parent))
    module = import_module(file.stem)
    if Path(module.__file__ or "").resolve() != file:
        raise ImportError(f"{file} is missing, or has the name of another module")
    return module
