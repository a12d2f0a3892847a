"""An MJCF file as MuJoCo compiles it: defaults, classes, includes and shapes are resolved there."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import Any

from ...model.errors import ModelError
from .counts import check_counts


def mujoco() -> Any:
    """Return the module ``mujoco``.

    Raises
    ------
    ImportError
        If it is not installed, with the command that does it.
    """
    try:
        return import_module("mujoco")
    except ImportError:
        message = 'reading MJCF needs the package mujoco. Install it, pip install "sarrus[mjcf]".'
        raise ImportError(message) from None


def compiled(path: Path) -> Any:
    """Return the compiled ``MjModel`` of a file.

    Raises
    ------
    ModelError
        If there is no such file, or MuJoCo cannot read it.
    """
    if not path.is_file():
        raise ModelError("does not exist, or is no file. Check the path.", where=str(path))
    check_counts(path)
    try:
        return mujoco().MjModel.from_xml_path(str(path))
    except (ValueError, RuntimeError) as error:
        raise _refusal(path, " ".join(str(error).split())) from None


def name_of(named: Any, word: str) -> str:
    """Return the name of a body, joint or equality, or its kind and number if it has none."""
    return str(named.name) or f"{word}{named.id}"


def _refusal(path: Path, message: str) -> ModelError:
    line = re.search(r"line (\d+)", message)
    where = f"{path}:{line[1]}" if line else str(path)
    return ModelError(f"cannot be read by MuJoCo, {message.rstrip('.')}. Fix it.", part="file", where=where)
