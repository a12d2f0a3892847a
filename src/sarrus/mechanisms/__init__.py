"""The mechanisms that come with the package, as model files."""

from __future__ import annotations

from pathlib import Path

from ..model.errors import ModelError
from ..model.show import quote, suggest

_FOLDER = Path(__file__).parent


def names() -> tuple[str, ...]:
    """Return the names of the shipped mechanisms."""
    return tuple(sorted(file.stem for file in _FOLDER.glob("*.yaml")))


def suspensions() -> tuple[str, ...]:
    """Return the names of the shipped suspensions, each one axle with its rig."""
    return tuple(sorted(file.stem for file in _FOLDER.glob("suspensions/*.yaml")))


def path(name: str) -> Path:
    """Return the model file of a shipped mechanism or suspension.

    Raises
    ------
    ModelError
        If there is none of this name.
    """
    known = {file.stem: file for file in _FOLDER.rglob("*.yaml")}
    if name not in known:
        raise ModelError(f"there is no shipped mechanism {quote(name)}. {suggest(name, sorted(known))}")
    return known[name]
